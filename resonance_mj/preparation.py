"""What an experiment needs before its first step, and how it is written into the memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import motion as motions
from .experiment import Experiment
from .memory import Memory
from .optimal_springs import Optimum, along, center, follow
from .robot import Robot, build


@dataclass(frozen=True)
class Prepared:
    """An experiment with everything that it needs before its first step."""

    experiment: Experiment
    robot: Robot
    optima: list[Optimum]
    q_c: np.ndarray
    q_s: np.ndarray

    @property
    def schedule(self) -> list[int]:
        """Of each cycle in a row, the motion that it repeats."""
        return [i for i, motion in enumerate(self.experiment.motion) for _ in range(motion.cycles)]

    def steps(self, segment: int) -> int:
        """Time steps in a cycle of a motion."""
        return self.experiment.motion[segment].steps(self.experiment.simulation.timestep)

    @property
    def fits_with(self) -> tuple[object, ...]:
        """Equal for experiments that one batch can step together."""
        experiment = self.experiment
        return (
            experiment.robot.mjcf,
            experiment.robot.tool,
            experiment.task,
            experiment.simulation.integrator,
            self.robot.layout,
            tuple(self.schedule),
            tuple(self.steps(i) for i in range(len(experiment.motion))),
        )


def prepare(experiment: Experiment) -> Prepared:
    """Load the robot, find the joint motions and their optimum.

    Raises:
        ExperimentError: a list in the experiment is not as long as the arm or the task needs.
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
    """
    robot = build(experiment)
    found = follow(experiment, robot)
    return Prepared(
        experiment=experiment,
        robot=robot,
        optima=along(experiment, robot, found),
        q_c=center(experiment.law.q_c, found, robot),
        q_s=center(experiment.law.q_s, found, robot),
    )


def load_law(memory: Memory, index: int, one: Prepared) -> None:
    """Write the robot's indices, the gains, the bounds and the first springs into the memory."""
    experiment, robot = one.experiment, one.robot
    law, bounds = experiment.law, experiment.springs
    for name in ("qpos_address", "dof_address", "joint_id", "actuator_id", "coordinate"):
        memory[name][index] = getattr(robot, name)
    for name in ("k_v", "k_p", "gamma_k", "gamma_qe"):
        memory[name][index] = getattr(law, name)
    memory["q_c"][index] = one.q_c
    memory["q_s"][index] = one.q_s
    memory["k_min"][index], memory["k_max"][index] = bounds.stiffness
    memory["low"][index], memory["high"][index] = bounds.equilibrium
    k = np.asarray(bounds.initial_stiffness)
    memory["stiffness"][index] = k
    memory["offset"][index] = k * (np.asarray(bounds.initial_equilibrium) - one.q_c)
    # A joint that turns by a radian in a time step is beyond any sampled control.
    dt = experiment.simulation.timestep
    memory["torque_limit"][index] = robot.inertia / dt**2
    for name, value in (
        ("site", robot.site),
        ("transpose", law.jacobian == "transpose"),
        ("alpha", law.alpha),
        ("beta", law.beta),
        ("lead", law.lead),
        ("timestep", dt),
        ("stages", 4 if experiment.simulation.integrator == "RK4" else 1),
        ("speed_limit", 1.0 / dt),
    ):
        memory.scalar(name)[index] = value


def load_motion(memory: Memory, index: int, one: Prepared, segment: int) -> None:
    """Write a motion's table into the memory."""
    steps = one.steps(segment)
    samples = motions.sample(one.experiment.motion[segment], steps)
    memory["x_desired"][index, :steps] = samples.x
    memory["dx_desired"][index, :steps] = samples.dx
