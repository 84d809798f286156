"""Kinematics of an arm that picks something up and puts it down within a cycle."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np

from ..experiments.experiment import Experiment
from ..robots.robot import Robot
from .kinematics import JointMotion, Kinematics


class Carrying(Kinematics):
    """Of an arm whose load changes within a cycle: the torque is that of the load of its time.

    All else, as what may touch or what the joints must bear, is asked of its heaviest load.

    Args:
        loads: the kinematics with the load of each time step of a cycle.
        heaviest: that with the heaviest load.
    """

    def __init__(self, loads: list[Kinematics], heaviest: Kinematics) -> None:
        super().__init__(heaviest.robot)
        self.loads, self.heaviest = loads, heaviest
        begins = [0, *(i for i in range(1, len(loads)) if loads[i] is not loads[i - 1])]
        lengths = np.diff([*begins, len(loads)]).tolist()
        self.parts = [(n, loads[i].robot) for i, n in zip(begins, lengths, strict=True)]

    def torque(self, motion: JointMotion) -> np.ndarray:
        """Torque (N, n) [N m] without springs and contacts, by (2), of a whole cycle."""
        torque, count = np.empty_like(motion.q), len(motion.q)
        loads = [self.loads[i * len(self.loads) // count] for i in range(count)]
        for one in dict.fromkeys(loads):
            its = np.array([load is one for load in loads])
            torque[its] = one.torque(JointMotion(*(part[its] for part in motion)))
        return torque


def loaded(experiment: Experiment, unloaded: Kinematics) -> list[Kinematics]:
    """The kinematics of an arm with what it carries in each motion of an experiment.

    Args:
        experiment: says what it carries.
        unloaded: of the arm without a payload.
    """
    robot, by_mass, found = unloaded.robot, {0.0: unloaded}, []
    for motion in experiment.motion:
        masses = motion.carried(motion.steps(experiment.simulation.timestep))
        kinds = np.unique(masses).tolist()
        for mass in kinds:
            if mass not in by_mass:
                by_mass[mass] = Kinematics(robot.carrying(mass))
        heaviest = by_mass[kinds[-1]]
        alike = len(kinds) == 1
        loads = [] if alike else [by_mass[mass] for mass in masses.tolist()]
        found.append(heaviest if alike else Carrying(loads, heaviest))
    return found


def parts(kinematics: Kinematics, steps: int) -> list[tuple[int, Robot]]:
    """Time steps of each part of a cycle of so many, and the robot with its load of that part."""
    return kinematics.parts if isinstance(kinematics, Carrying) else [(steps, kinematics.robot)]


def rubbing(kinematics: Kinematics, friction: np.ndarray) -> Kinematics:
    """The kinematics with dry friction (n,) [N m] added in the arm's joints."""
    if isinstance(kinematics, Carrying):
        rubbed = {one: rubbing(one, friction) for one in dict.fromkeys(kinematics.loads)}
        return Carrying([rubbed[one] for one in kinematics.loads], rubbed[kinematics.heaviest])
    robot, model = kinematics.robot, copy.copy(kinematics.robot.model)
    model.dof_frictionloss[robot.dof_address] += friction
    return Kinematics(replace(robot, model=model))
