"""How far an arm reaches: the length that sizes and distances on it are shares of."""

import mujoco
import numpy as np

from .robot import Robot


def reach(robot: Robot) -> float:
    """Distance from the first joint to the tool with the chain stretched out [m].

    The sum of the distances between the joints' anchors at home, and of the ways of slide joints.
    """
    model, data = robot.model, mujoco.MjData(robot.model)
    data.qpos[:] = robot.qpos
    mujoco.mj_kinematics(model, data)
    points = np.vstack([data.xanchor[robot.joint_id], data.site_xpos[robot.site]])
    slides = model.jnt_type[robot.joint_id] == int(mujoco.mjtJoint.mjJNT_SLIDE)
    ways = np.abs(model.jnt_range[robot.joint_id] - robot.home[:, None]).max(axis=1)
    way = ways[slides & model.jnt_limited[robot.joint_id].astype(bool)].sum()
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum() + way)
