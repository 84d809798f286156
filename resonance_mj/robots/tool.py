"""The point of an arm that works: the one that is named, or the one that is found."""

from __future__ import annotations

from pathlib import Path

import mujoco

from ..errors import RobotError
from . import chain
from .names import UNNAMED, listed

USUAL_TOOLS = (
    "attachment_site",
    "tool",
    "tcp",
    "grip_site",
    "grasp_site",
    "ee",
    "eef",
    "ee_site",
    "end_effector",
    "right_center",
    "right_hand",
    "hand",
    "pinch",
)
"""Names that authors give to the point that works, the likeliest first."""

FINGER_JOINTS = 3
"""Most joints of a gripper's finger."""


def find_tool(
    model: mujoco.MjModel, given: str | None, path: Path, notes: list[str]
) -> tuple[str, str]:
    """Whether the tool is a site or a body, and its name."""
    sites = [model.site(i).name for i in range(model.nsite)]
    bodies = [model.body(i).name for i in range(1, model.nbody)]
    if given is not None:
        if given in sites:
            return "site", given
        if given in bodies:
            return "body", given
        raise RobotError(
            f"{path}: robot.tool = {given!r}: no such site or body; its sites are: "
            f"{listed(sites)}; its bodies: {listed(bodies)}"
        )
    cloth = set(model.flex_vertbodyid.tolist())
    lengths = [chain.length(model, body) * (body not in cloth) for body in range(model.nbody)]
    longest = max(lengths)
    if longest == 0:
        for j in range(model.njnt):
            if chain.carries_spring(model, j):
                chain.check(model, chain.joints_to(model, int(model.jnt_bodyid[j])), path)
        raise RobotError(
            f"{path}: no hinge or slide joint moves anything in it; an arm needs at least one"
        )
    # A usual name on the base or on another arm is not the tool: it must be moved by all joints of
    # the arm, which are those of the longest chain without a gripper's.
    longest -= _fingers(model, lengths.index(longest))
    at_end = {body for body in range(model.nbody) if lengths[body] == longest}
    for name in USUAL_TOOLS:
        if name in sites and int(model.site(name).bodyid[0]) in at_end:
            notes.append(f"tool: site {name!r}, found by its usual name")
            return "site", name
        if name in bodies and int(model.body(name).id) in at_end:
            notes.append(f"tool: body {name!r}, found by its usual name")
            return "body", name
    depth = [chain.depth(model, body) for body in range(model.nbody)]
    best = max(
        sorted(at_end),
        key=lambda body: (not model.body(body).name.startswith(UNNAMED), depth[body]),
    )
    notes.append(
        f"tool: body {model.body(best).name!r}, the deepest of the longest chain of joints"
    )
    return "body", model.body(best).name


def _fingers(model: mujoco.MjModel, tip: int) -> int:
    """How many of the joints that move `tip` are a finger's, past a body where several spread.

    Two arms on a torso spread as well, but with more joints than a finger has.
    """
    moved = {int(model.jnt_bodyid[j]) for j in range(model.njnt)}
    joints, body, found = 0, tip, 0
    while body > 0 and joints <= FINGER_JOINTS:
        joints += int(model.body_jntnum[body])
        body = int(model.body_parentid[body])
        branches = {_child_towards(model, body, other) for other in moved} - {-1}
        if (
            body > 0
            and len(branches) > 1
            and 0 < joints <= FINGER_JOINTS
            and chain.joints_to(model, body)
        ):
            found = joints
    return found


def _child_towards(model: mujoco.MjModel, ancestor: int, body: int) -> int:
    """The child of `ancestor` through which `body` hangs on it, or -1."""
    while body > 0:
        parent = int(model.body_parentid[body])
        if parent == ancestor:
            return body
        body = parent
    return -1
