"""The tool's motion that a joint motion makes."""

import numpy as np

from .kinematics import JointMotion, Kinematics
from .motion import Samples


def tool_path(kinematics: Kinematics, motion: JointMotion) -> Samples:
    """Position, velocity and acceleration of the tool (N, m) along a joint motion.

    Args:
        kinematics: of the robot.
        motion: of its joints.
    """
    x, dx, ddx = [], [], []
    for q, dq, ddq in zip(*motion, strict=True):
        J = kinematics.jacobian(q)
        x.append(kinematics.position(q))
        dx.append(J @ dq)
        ddx.append(J @ ddq + kinematics.jacobian_rate(q, dq) @ dq)
    return Samples(np.array(x), np.array(dx), np.array(ddx), kinematics.robot.rotates)
