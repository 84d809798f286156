"""The arm of an experiment, built once for all that share it."""

import copy
from dataclasses import replace
from typing import cast

from ..experiments.experiment import Experiment
from ..laws.memory import layout_of
from ..robots.robot import Robot, build

Followed = dict[tuple[object, ...], object]
"""Arms, joint motions, the torque that they need and the best springs, by all they depend on."""


def built(experiment: Experiment, followed: Followed) -> Robot:
    """The robot of an experiment, or a copy of one that was built for an experiment like it."""
    carries = any(motion.payload > 0 for motion in experiment.motion)
    how = experiment.simulation.model_copy(update={"samples": None})
    springs = experiment.springs.model_dump_json()
    most = experiment.reality.motor_torque
    key = "robot", experiment.robot, experiment.task, how, springs, carries, most

    def room(joints: int, coordinates: int, dofs: int) -> int:
        return layout_of(experiment, joints, coordinates, dofs).size

    known = followed.get(key)
    if known is not None:
        robot, size = cast("tuple[Robot, int]", known)
        if size == room(robot.n, robot.m, robot.model.nv):
            return replace(robot, model=copy.copy(robot.model))
    robot = build(experiment, room)
    followed[key] = (
        replace(robot, model=copy.copy(robot.model)),
        room(robot.n, robot.m, robot.model.nv),
    )
    return robot
