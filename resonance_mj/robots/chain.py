"""The joints from the world to a body, and whether they can carry springs."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from ..errors import RobotError


def joints_to(model: mujoco.MjModel, body: int) -> list[int]:
    """Ids of the joints from the world to a body."""
    joints: list[int] = []
    while body > 0:
        joints[:0] = _joints_of(model, body)
        body = int(model.body_parentid[body])
    return joints


def lengths(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Of each body, how many joints and how many bodies stand between the world and it (nbody,).

    No joints are counted where one of them can carry no spring.
    """
    joints, bodies = np.zeros((2, model.nbody), int)
    sprung = np.ones(model.nbody, bool)
    for body in range(1, model.nbody):
        parent, own = int(model.body_parentid[body]), _joints_of(model, body)
        sprung[body] = sprung[parent] and all(carries_spring(model, j) for j in own)
        joints[body] = joints[parent] + len(own)
        bodies[body] = bodies[parent] + 1
    return joints * sprung, bodies


def _joints_of(model: mujoco.MjModel, body: int) -> range:
    first = int(model.body_jntadr[body])
    return range(first, first + int(model.body_jntnum[body]))


def weld_rest(model: mujoco.MjModel, chain: list[int]) -> None:
    """Let MuJoCo look for contacts as if the joints that are not of a chain were gone."""
    for body in range(1, model.nbody):
        if not set(_joints_of(model, body)) & set(chain):
            model.body_weldid[body] = model.body_weldid[model.body_parentid[body]]


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
