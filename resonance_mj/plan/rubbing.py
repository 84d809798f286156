"""The dry friction that `[reality]` gives an arm's joints, of which its law is not told."""

import copy
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..experiments.experiment import Experiment
from ..motions.kinematics import JointMotion, Kinematics


def rubbing(
    experiment: Experiment, joints: Callable[[], list[JointMotion]], loaded: list[Kinematics]
) -> list[Kinematics]:
    """The kinematics of the arm with the load of each motion, with friction in its joints.

    Args:
        experiment: says how much, as a share of the largest torque of each joint without it.
        joints: joint motion of each motion, asked for if there is friction.
        loaded: kinematics without it.
    """
    share = experiment.reality.friction
    if not share:
        return loaded
    torques = [one.torque(joint) for one, joint in zip(loaded, joints(), strict=True)]
    friction = share * np.max([np.abs(torque).max(axis=0) for torque in torques], axis=0)
    found: dict[int, Kinematics] = {}
    for one in loaded:
        if id(one) not in found:
            robot, model = one.robot, copy.copy(one.robot.model)
            model.dof_frictionloss[robot.dof_address] += friction
            found[id(one)] = Kinematics(replace(robot, model=model))
    return [found[id(one)] for one in loaded]
