"""What an experiment needs before its first step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import StabilityError
from ..experiments.experiment import Experiment
from ..laws import laws
from ..laws.automatic_gains import gains
from ..laws.gains import Gains
from ..laws.laws import Law
from ..motions import motion as motions
from ..motions.kinematics import JointMotion, Kinematics
from ..robots.robot import Robot, build
from ..springs.optimum import Optimum, along, center, follow, resolved
from . import notes as warnings


@dataclass(frozen=True)
class Prepared:
    """An experiment with everything that it needs before its first step.

    Attributes:
        experiment: with everything that it left open filled in.
        robot: without a payload.
        loaded: the robot in each motion, with the payload of that motion.
        law: what the law does.
        gains: that it has on the robot.
        notes: what to know before the first step, a line each.
        joints: joint motion of each motion.
        optima: optimum of each motion.
        q_c: centre of the springs' regressor (n,) [rad].
        q_s: centre of the learning's regressor (n,) [rad].
    """

    experiment: Experiment
    robot: Robot
    loaded: list[Robot]
    law: Law
    gains: Gains
    notes: tuple[str, ...]
    joints: list[JointMotion]
    unstable: tuple[str, ...]
    optima: list[Optimum]
    q_c: np.ndarray
    q_s: np.ndarray

    @cached_property
    def schedule(self) -> list[int]:
        """Of each cycle in a row, the motion that it repeats."""
        return [i for i, motion in enumerate(self.experiment.motion) for _ in range(motion.cycles)]

    def steps(self, segment: int) -> int:
        """Time steps in a cycle of a motion."""
        return self.experiment.motion[segment].steps(self.experiment.simulation.timestep)

    def blending(self, cycle: int) -> int | None:
        """Which cycle of the passage into its motion a cycle of the run is, None for no passage."""
        segment = self.schedule[cycle]
        begun = cycle - self.schedule.index(segment)
        return begun if begun < self.experiment.motion[segment].blend else None

    @cached_property
    def passages(self) -> dict[int, JointMotion]:
        """Joint motion of each cycle of the run in which the arm passes over into a motion.

        Raises:
            MotionError: a passage leaves the arm's reach or goes through a singular pose.
        """
        found: dict[int, JointMotion] = {}
        start = self.robot.home
        for segment, motion in enumerate(self.experiment.motion):
            first = self.schedule.index(segment)
            cycles = range(first, first + motion.blend)
            if cycles:
                whole = motions.in_a_row([desired(self, cycle) for cycle in cycles])
                made = Kinematics(self.robot).passage(
                    whole,
                    start,
                    motion.blend * motion.period,
                    f"experiment {self.experiment.name!r}: passage to motion.{segment}",
                    self.experiment.law.alpha_0,
                )
                steps = self.steps(segment)
                for number, cycle in enumerate(cycles):
                    part = slice(number * steps, (number + 1) * steps)
                    found[cycle] = JointMotion(*(signal[part] for signal in made))
            start = self.joints[segment].q[-1]
        return found

    def joint_motion(self, cycle: int) -> JointMotion:
        """Joint motion that makes the desired motion of a cycle of the run."""
        passage = self.blending(cycle) is not None
        return self.passages[cycle] if passage else self.joints[self.schedule[cycle]]

    @property
    def fits_with(self) -> tuple[object, ...]:
        """Equal for experiments that one batch can step together."""
        experiment = self.experiment
        return (
            experiment.robot.mjcf,
            experiment.robot.tool,
            experiment.task,
            experiment.simulation.integrator,
            self.law.command,
            self.robot.payload,
            tuple(motion.blend for motion in experiment.motion),
            self.robot.layout,
            tuple(self.schedule),
            tuple(self.steps(i) for i in range(len(experiment.motion))),
        )


Followed = dict[tuple[object, ...], list[JointMotion]]
"""Joint motions by all that they depend on."""


def prepare(experiment: Experiment, followed: Followed | None = None) -> Prepared:
    """Load the robot, find the joint motions and their optimum.

    Args:
        experiment: what to prepare.
        followed: joint motions of experiments before, taken from here and added here.

    Raises:
        ExperimentError: a list in the experiment is not as long as the arm or the task needs.
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
    """
    law = laws.load(experiment.law.kind)
    robot = build(experiment)
    experiment = resolved(experiment, robot)
    followed = {} if followed is None else followed
    path = _path(experiment)
    if path not in followed:
        followed[path] = follow(experiment, robot)
    found = followed[path]
    optima = along(experiment, robot, found)
    chosen = gains(experiment, robot)
    unstable = tuple(warnings.unstable(experiment, robot, chosen, found, optima))
    prepared = Prepared(
        experiment=experiment,
        robot=robot,
        loaded=[robot.carrying(motion.payload) for motion in experiment.motion],
        law=law,
        gains=chosen,
        notes=(*robot.notes, *warnings.before(experiment, robot, found, optima), *unstable),
        unstable=unstable,
        joints=found,
        optima=optima,
        q_c=center(experiment.law.q_c, found, robot),
        q_s=center(experiment.law.q_s, found, robot),
    )
    if "joints" in law.told:
        _ = prepared.passages  # so that one that cannot be made is refused before the first step
    return prepared


def _path(experiment: Experiment) -> tuple[object, ...]:
    """What the joint motions depend on: not how often they are repeated, by which law or load."""
    one_cycle = tuple(
        motion.model_copy(update={"duration": motion.period, "blend": 0, "payload": 0.0})
        for motion in experiment.motion
    )
    return (
        experiment.robot,
        experiment.task,
        experiment.simulation.timestep,
        experiment.law.alpha_0,
        one_cycle,
    )


def refuse_unstable(one: Prepared) -> None:
    """Raise a StabilityError if something of an experiment will diverge."""
    if one.unstable:
        more = f" (and {len(one.unstable) - 1} more)" if len(one.unstable) > 1 else ""
        raise StabilityError(f"experiment {one.experiment.name!r}: {one.unstable[0]}{more}")


def desired(one: Prepared, cycle: int) -> motions.Samples:
    """The desired motion in a cycle of the run: a motion, or the passage to it."""
    segment = one.schedule[cycle]
    motion = one.experiment.motion[segment]
    steps = one.steps(segment)
    samples = motions.sample(motion, steps, one.robot)
    begun = one.blending(cycle)
    if begun is None:
        return samples
    if segment == 0:
        rest = Kinematics(one.robot).position(one.robot.home)
        still = np.zeros_like(samples.x)
        before = motions.Samples(still + rest, still, still)
    else:
        # The motion that is left goes on by the clock while the new one takes over.
        left = one.experiment.motion[segment - 1]
        old = motions.sample(left, one.steps(segment - 1), one.robot)
        at = (begun * steps + np.arange(steps)) % one.steps(segment - 1)
        before = motions.Samples(old.x[at], old.dx[at], old.ddx[at])
    return motions.blended(before, samples, begun, motion.blend, motion.period)
