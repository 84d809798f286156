"""Names of joints, bodies and sites: those that are missing, and what the given ones mean."""

import re
from collections.abc import Callable
from typing import Any

UNNAMED = "unnamed_"
"""What the names of joints, bodies and sites begin with that have none in the file."""

TOOLS = (
    "attachment",
    "tool",
    "tool0",
    "tcp",
    "toolcenterpoint",
    "grip",
    "grasp",
    "ee",
    "eef",
    "endeffector",
    "rightcenter",
    "righthand",
    "hand",
    "pinch",
    "tooltip",
    "tip",
    "fingertip",
    "flange",
    "gripper",
)
"""Names that authors give to the point that works, the likeliest first, without prefixes."""

_ENDINGS = ("site", "frame", "link", "point", "body", "center", "left", "right", "l", "r")
_SENSORS = re.compile(r"cam|camera\w*|optical|imu|lidar|laser|sensor|ft|force|torque|touch|marker")
_GRIPPER = re.compile(r"jaw|finger|fngr|claw|thumb|knuckle|pincer")
_TURNING = re.compile(r"roll|rotat|twist|yaw|pitch|wrist")
_LEG = re.compile(r"[lrfb]?(leg|foot|ankle|knee|hip|thigh|calf|shin|toe|wheel|head|neck|tail)\w*")


def name_all(elements: list[Any], kind: str) -> None:
    """Give a name to each element that has none."""
    taken = {element.name: element for element in elements}
    for number, element in enumerate(elements, 1):
        if not element.name:
            element.name = free(f"{UNNAMED}{kind}{number}", taken.get)
            taken[element.name] = element


def free(name: str, find: Callable[[str], Any]) -> str:
    """A name with as many underscores behind it as it takes for `find` to find nothing."""
    while find(name) is not None:
        name += "_"
    return name


def words(name: str) -> list[str]:
    """The words of a name in lower case, as `left`, `tool0` of `leftTool0` or `left/tool0`."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return [word for word in re.split(r"[\W_]+", spaced.lower()) if word]


def usual(name: str) -> int | None:
    """How likely a name is a tool's, 0 the likeliest; None if it is no usual one.

    What an author or a scene puts before it is ignored, and so is what kind of element it is.
    """
    own = words(name)
    while own:
        for first in range(len(own)):
            if "".join(own[first:]) in TOOLS:
                return TOOLS.index("".join(own[first:]))
        if not (own[-1] in _ENDINGS or own[-1].isdigit()):
            return None
        own.pop()
    return None


def is_sensor(name: str) -> bool:
    """Whether a frame is a camera's or another sensor's by its name."""
    return any(map(_SENSORS.fullmatch, words(name)))


def is_gripper(joint: str, body: str) -> bool:
    """Whether a joint and the body that it moves are a gripper's by their names."""
    if _TURNING.search(joint.lower()):
        return False
    return bool(re.search("grip", joint.lower()) or _GRIPPER.search(f"{joint} {body}".lower()))


def is_leg(name: str) -> bool:
    """Whether something is a leg's, a wheel's, a tail's or a head's by its name."""
    return any(map(_LEG.fullmatch, words(name)))
