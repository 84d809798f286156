"""Poses of an arm that its gains are chosen at, by inverse kinematics of a few points."""

from functools import partial

import numpy as np

from ..experiments.experiment import Experiment
from ..experiments.motion_section import Motion
from . import motion as motions
from .inverse_kinematics import REACHED
from .kinematics import Kinematics

POINTS = 48
"""Points of a cycle of which the mean is taken."""

EACH = 3
"""Of these, one in so many is a pose along the motion."""


def middles(experiment: Experiment, kinematics: Kinematics) -> list[np.ndarray]:
    """Joint angles (n,) with the tool in the mean of each motion; at home if it is out of reach."""
    return [
        kinematics.once(("middle", motion), partial(_middle, motion, kinematics))
        for motion in experiment.motion
    ]


def along(experiment: Experiment, kinematics: Kinematics) -> list[np.ndarray]:
    """Joint angles (n,) with the tool at points along the motions, the nearest from its middle."""
    robot, found = kinematics.robot, []
    for motion in experiment.motion:
        points = motions.sample(motion, POINTS, robot).x[::EACH]
        q = _middle(motion, kinematics)
        for x in points:
            q = x if robot.joint_space else kinematics.solve(x, q)
            found.append(q)
    return found


def _middle(motion: Motion, kinematics: Kinematics) -> np.ndarray:
    robot = kinematics.robot
    x: np.ndarray = motions.sample(motion, POINTS, robot).x.mean(axis=0)
    if robot.joint_space:
        return x
    q = kinematics.solve(x, robot.home)
    reached = np.linalg.norm(kinematics.position(q) - x) < REACHED
    return q if reached else robot.home
