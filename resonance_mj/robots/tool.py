"""The point of an arm that works: the one that is named, or the one that is found."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from ..errors import RobotError
from ..text import listed, shown
from . import chain
from .names import UNNAMED

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


@dataclass(frozen=True)
class Tool:
    """What follows the motion, or could: it hangs on the last joint of the arm.

    Attributes:
        name: in the file.
        kind: site or body.
        body: the body that carries a site; the body itself.
    """

    name: str
    kind: str
    body: str


def find_tools(
    model: mujoco.MjModel, given: str | None, path: Path, notes: list[str]
) -> tuple[Tool, ...]:
    """What could be the tool, first what is."""
    ends = _ends(model)
    sites = [model.site(i) for i in range(model.nsite)]
    tools = [Tool(site.name, "site", model.body(int(site.bodyid[0])).name) for site in sites]
    tools += [Tool(name, "body", name) for name in _names_of_bodies(model)]
    at_end = [tool for tool in tools if tool.name and model.body(tool.body).id in ends]
    chosen = (
        _found(model, at_end, path, notes)
        if given is None
        else next((tool for tool in tools if tool.name == given), None)
    )
    if chosen is None:
        raise RobotError(
            f"{path}: robot.tool = {shown(given)}: no such site or body; its sites are: "
            f"{listed(site.name for site in sites)}; its bodies: {listed(_names_of_bodies(model))}"
        )
    others = [tool for tool in at_end if not tool.name.startswith(UNNAMED)]
    return tuple(dict.fromkeys((chosen, *others)))


def _found(model: mujoco.MjModel, at_end: list[Tool], path: Path, notes: list[str]) -> Tool:
    """The tool by its usual name, else the deepest body."""
    if not at_end:
        for j in range(model.njnt):
            if chain.carries_spring(model, j):
                chain.check(model, chain.joints_to(model, int(model.jnt_bodyid[j])), path)
        raise RobotError(
            f"{path}: no hinge or slide joint moves anything in it; an arm needs at least one"
        )
    for name in USUAL_TOOLS:
        for tool in at_end:
            if tool.name == name:
                notes.append(f"tool: {tool.kind} {name!r}, found by its usual name")
                return tool
    depth = chain.lengths(model)[1]
    best = max(
        (tool for tool in at_end if tool.kind == "body"),
        key=lambda tool: (not tool.name.startswith(UNNAMED), depth[model.body(tool.name).id]),
    )
    notes.append(f"tool: body {best.name!r}, the deepest of the longest chain of joints")
    return best


def _names_of_bodies(model: mujoco.MjModel) -> list[str]:
    return [model.body(i).name for i in range(1, model.nbody)]


def _ends(model: mujoco.MjModel) -> set[int]:
    """Bodies that all joints of the arm move; none without an arm.

    A usual name on the base or on another arm is not the tool: the arm's joints are those of the
    longest chain without a gripper's.
    """
    lengths, _ = chain.lengths(model)
    cloth = model.flex_vertbodyid
    lengths[cloth[cloth >= 0]] = 0
    longest = int(lengths.max())
    if longest == 0:
        return set()
    longest -= _fingers(model, int(lengths.argmax()))
    return set(np.flatnonzero(lengths == longest).tolist())


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
