"""Bodies put where the home pose has them: what does not move the tool is held there."""

from typing import Any

import mujoco
import numpy as np

from ..text import listed

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
"""The quaternion of no rotation."""


def hold_off_chain(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    at_home: mujoco.MjData,
    chain: list[int],
    notes: list[str],
) -> None:
    """Fix the joints that do not move the tool, and mocap bodies, where the home pose has them."""
    off = [j for j in range(model.njnt) if j not in chain]
    mocap = np.flatnonzero(model.body_mocapid >= 0)
    # A body on joints of both kinds is placed by those that are held alone, and turns the others.
    rest = mujoco.MjData(model)
    rest.qpos[:] = at_home.qpos
    rest.qpos[model.jnt_qposadr[chain]] = model.qpos0[model.jnt_qposadr[chain]]
    mujoco.mj_kinematics(model, rest)
    moved = set(model.jnt_bodyid[chain].tolist())
    for body in sorted({*model.jnt_bodyid[off].tolist(), *mocap.tolist()}):
        data = rest if body in moved else at_home
        _place(spec.bodies[body], data, body, int(model.body_parentid[body]))
        for j in (j for j in chain if model.jnt_bodyid[j] == body):
            joint, into = spec.joint(model.joint(j).name), rest.xmat[body].reshape(3, 3).T
            joint.pos = into @ (rest.xanchor[j] - rest.xpos[body])
            joint.axis = into @ rest.xaxis[j]
    names = [model.joint(j).name for j in off]
    for name in names:
        spec.delete(spec.joint(name))
    if names:
        notes.append(f"held where the home pose has them: joints {listed(names)}")


def _place(element: mujoco.MjsBody, data: mujoco.MjData, body: int, parent: int) -> None:
    """Write the pose that a body has in `data`, relative to its parent, into the spec."""
    if element.frame is not None:
        # MuJoCo puts the pose of a <frame> before that of a body in it.
        element.set_frame(element.parent.add_frame())
    at = _relative(data.xpos[parent], data.xquat[parent], data.xpos[body], data.xquat[body])
    set_pose(element, *at)


def _relative(
    pos: np.ndarray, quat: np.ndarray, of_pos: np.ndarray, of_quat: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The pose (of_pos, of_quat) as seen from the pose (pos, quat)."""
    inverse, seen_pos, seen_quat = np.empty(4), np.empty(3), np.empty(4)
    mujoco.mju_negQuat(inverse, quat)
    mujoco.mju_rotVecQuat(seen_pos, of_pos - pos, inverse)
    mujoco.mju_mulQuat(seen_quat, inverse, of_quat)
    return seen_pos, seen_quat


def set_pose(element: Any, pos: np.ndarray, quat: np.ndarray) -> None:
    """Give a body or site its position (3,) [m] and its orientation as a quaternion (4,)."""
    element.pos, element.quat = pos, quat
    element.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
