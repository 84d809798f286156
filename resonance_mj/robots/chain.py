"""The joints from the world to a body, and whether they can carry springs."""

from __future__ import annotations

from pathlib import Path

import mujoco

from ..errors import RobotError


def joints_to(model: mujoco.MjModel, body: int) -> list[int]:
    """Ids of the joints from the world to a body."""
    joints: list[int] = []
    while body > 0:
        first = int(model.body_jntadr[body])
        joints[:0] = range(first, first + int(model.body_jntnum[body]))
        body = int(model.body_parentid[body])
    return joints


def length(model: mujoco.MjModel, body: int) -> int:
    """Number of joints that move a body, 0 if one of them can carry no spring."""
    chain = joints_to(model, body)
    return 0 if any(not carries_spring(model, j) for j in chain) else len(chain)


def depth(model: mujoco.MjModel, body: int) -> int:
    """Number of bodies from the world to a body."""
    return 0 if body == 0 else 1 + depth(model, int(model.body_parentid[body]))


def carries_spring(model: mujoco.MjModel, joint: int) -> bool:
    """Whether a joint is a hinge or a slide."""
    return int(model.jnt_type[joint]) in (
        mujoco.mjtJoint.mjJNT_HINGE,
        mujoco.mjtJoint.mjJNT_SLIDE,
    )


def check(model: mujoco.MjModel, chain: list[int], path: Path, tool: str = "the arm's end") -> None:
    """Check that every joint of a chain can carry a spring.

    Raises:
        RobotError: one of them cannot.
    """
    for j in chain:
        if not carries_spring(model, j):
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            raise RobotError(
                f"{path}: joint {model.joint(j).name!r} between the world and {tool} is "
                f"a {kind} joint; only hinge and slide joints can carry a spring"
            )
