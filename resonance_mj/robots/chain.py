"""The joints from the world to a body, and whether they can carry springs."""

from pathlib import Path

import mujoco

from ..errors import RobotError


def joints_to(model: mujoco.MjModel, body: int) -> list[int]:
    """Ids of the joints from the world to a body."""
    joints: list[int] = []
    while body > 0:
        joints[:0] = _joints_of(model, body)
        body = int(model.body_parentid[body])
    return joints


def sprung_to(model: mujoco.MjModel, body: int) -> tuple[int, ...]:
    """Ids of the joints to a body from the world, or from a base that floats.

    None where one of them can carry no spring.
    """
    joints = joints_to(model, body)
    if joints and floats(model, joints[0]):
        joints = joints[1:]
    return tuple(joints) if all(carries_spring(model, j) for j in joints) else ()


def mobile_base(model: mujoco.MjModel, joints: list[int]) -> list[int]:
    """The first joints of an arm, where they move its base over the ground: two slides at least.

    Axes of a gantry have carriages that weigh something; those of a base sit on one body, or on
    bodies without mass.
    """
    base: list[int] = []
    carrier = model.jnt_bodyid[joints[0]] if joints else 0
    for j in joints:
        body = model.jnt_bodyid[j]
        if body != carrier and model.body_mass[carrier] > 1e-3 * model.body_subtreemass[carrier]:
            break
        base, carrier = [*base, j], body
    slides = [model.jnt_type[j] == int(mujoco.mjtJoint.mjJNT_SLIDE) for j in base]
    return base if sum(slides) >= 2 and len(base) < len(joints) else []


def depth(model: mujoco.MjModel, body: int) -> int:
    """How many bodies stand between the world and a body."""
    return 0 if body == 0 else 1 + depth(model, int(model.body_parentid[body]))


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


def floats(model: mujoco.MjModel, joint: int) -> bool:
    """Whether a joint leaves its body free."""
    return int(model.jnt_type[joint]) == mujoco.mjtJoint.mjJNT_FREE


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
