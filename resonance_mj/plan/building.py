"""The arm of an experiment, built once for all that share it."""

from typing import cast

from ..experiments.experiment import Experiment
from ..laws.memory import layout_of
from ..motions.kinematics import Kinematics
from ..robots.robot import build

Followed = dict[tuple[object, ...], object]
"""Arms, joint motions, the torque that they need and the best springs, by all they depend on."""


def built(experiment: Experiment, followed: Followed | None) -> Kinematics:
    """Kinematics of the robot of an experiment.

    The robot is a copy of one that was built for an experiment like it, if any, with models of its
    own.

    Args:
        experiment: what it is for.
        followed: arms of experiments before, taken from here and added here; None for one alone.
    """

    def room(joints: int, coordinates: int, dofs: int) -> int:
        return layout_of(experiment, joints, coordinates, dofs).size

    if followed is None:
        return Kinematics(build(experiment, room))
    carries = any(motion.carries for motion in experiment.motion)
    how = experiment.simulation.model_copy(update={"samples": None})
    springs = repr(experiment.springs)
    real = experiment.reality
    motors = real.motor_torque, real.motor_speed, real.base_tilt
    geared = real.joint_stiffness, real.rotor_inertia, real.backlash
    key = "robot", experiment.robot, experiment.task, how, springs, carries, motors, geared
    shared, size = cast("tuple[Kinematics | None, int]", followed.get(key, (None, 0)))
    robot = None if shared is None else shared.robot
    if shared is None or robot is None or size != room(robot.n, robot.m, robot.model.nv):
        shared = Kinematics(build(experiment, room))
        robot = shared.robot
        followed[key] = shared, room(robot.n, robot.m, robot.model.nv)
    return shared.of(robot.copied())
