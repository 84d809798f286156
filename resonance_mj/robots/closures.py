"""Constraints that tie an arm's joints to each other: the law moves each joint by itself."""

from pathlib import Path

import mujoco

from ..errors import RobotError
from ..text import listed
from . import chain

_EQ = mujoco.mjtEq


def check(
    model: mujoco.MjModel, joints: list[int], kept: list[int], asked: bool, path: Path
) -> None:
    """Refuse constraints of the file that make joints of the arm depend on others.

    They are taken out where the joints that move are asked for by name.

    Args:
        model: of the file.
        joints: ids of those that move.
        kept: ids of the constraints by which others follow them.
        asked: whether they are named in the experiment.
        path: of the file.

    Raises:
        RobotError: joints are coupled, or bodies that they move are tied to others: a closed loop.
    """
    for i in range(model.neq):
        passed = asked or i in kept or not model.eq_active0[i]
        tied = set() if passed else _tied(model, i, set(joints))
        if tied:
            name = f" {model.equality(i).name!r}" * bool(model.equality(i).name)
            kind = _EQ(model.eq_type[i]).name.removeprefix("mjEQ_").lower()
            raise RobotError(
                f"{path}: {kind} constraint{name} between {_ends(model, i)} ties joints of the arm "
                f"({listed(model.joint(j).name for j in sorted(tied))}) to others, and each moves "
                "by a spring and a motor of its own: name those that move as robot.joints to take "
                "the constraint out"
            )


def _tied(model: mujoco.MjModel, i: int, joints: set[int]) -> set[int]:
    """The joints of the arm that a constraint ties; none where it holds by itself."""
    kind, one, other = (int(of[i]) for of in (model.eq_type, model.eq_obj1id, model.eq_obj2id))
    if kind == int(_EQ.mjEQ_JOINT):
        return joints & {one, other}
    if kind == int(_EQ.mjEQ_TENDON):
        first, count = model.ten_J_rowadr, model.ten_J_rownnz
        rows = [slice(first[t], first[t] + count[t]) for t in (one, other) if t >= 0]
        return joints & {
            int(model.dof_jntid[dof]) for row in rows for dof in model.ten_J_colind[row]
        }
    if kind not in (int(_EQ.mjEQ_CONNECT), int(_EQ.mjEQ_WELD)):
        return set()
    bodies = _bodies(model, i)
    moving = [set(chain.joints_to(model, body)) for body in bodies]
    # What a mouse drags, or an object that lies loose in the scene, is held and no part of a loop.
    loose = any(model.body_mocapid[body] >= 0 for body in bodies) or any(
        chain.floats(model, j) for j in moving[0] ^ moving[1]
    )
    return set() if loose else joints & (moving[0] ^ moving[1])


def _bodies(model: mujoco.MjModel, i: int) -> list[int]:
    """The two bodies that a connect or weld constraint ties."""
    ends = [int(model.eq_obj1id[i]), int(model.eq_obj2id[i])]
    if model.eq_objtype[i] == int(mujoco.mjtObj.mjOBJ_SITE):
        ends = [int(model.site_bodyid[site]) for site in ends]
    return ends


def _ends(model: mujoco.MjModel, i: int) -> str:
    kind = int(model.eq_type[i])
    if kind in (int(_EQ.mjEQ_CONNECT), int(_EQ.mjEQ_WELD)):
        names = [model.body(body).name for body in _bodies(model, i)]
    else:
        find = model.joint if kind == int(_EQ.mjEQ_JOINT) else model.tendon
        ids = (int(model.eq_obj1id[i]), int(model.eq_obj2id[i]))
        names = [find(one).name if one >= 0 else "a constant" for one in ids]
    return " and ".join(map(repr, names))
