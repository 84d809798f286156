"""What an experiment needs before its first step, and how it is written into the memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import StabilityError
from ..experiments.experiment import Experiment
from ..laws import laws, springs
from ..laws.gains import Gains
from ..laws.laws import Law
from ..laws.memory import Memory
from ..motions import motion as motions
from ..motions.kinematics import JointMotion, Kinematics
from ..optimal_springs import Optimum, along, center, follow, resolved
from ..robots.automatic_gains import gains
from ..robots.robot import Robot, build
from . import warnings


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


def load_law(memory: Memory, index: int, one: Prepared) -> None:
    """Write the robot's indices, the gains, the bounds and the first springs into the memory."""
    experiment, robot, chosen = one.experiment, one.robot, one.gains
    law, bounds = experiment.law, experiment.springs
    for name in ("qpos_address", "dof_address", "joint_id", "actuator_id", "coordinate"):
        memory[name][index] = getattr(robot, name)
    memory["orientation"][index] = robot.orientation
    memory["posture"][index] = robot.home
    memory["k_v"][index] = chosen.k_v
    memory["k_p"][index] = chosen.k_p
    memory["feedback"][index] = chosen.feedback
    memory["feedback_p"][index] = chosen.feedback_p
    for name in ("gamma_k", "gamma_qe"):
        memory[name][index] = getattr(law, name) if name in one.law.adapts else 0.0
    memory["parameters"][index] = law.parameters
    memory["q_c"][index] = one.q_c
    memory["q_s"][index] = one.q_s
    memory["k_min"][index], memory["k_max"][index] = bounds.stiffness
    memory["low"][index], memory["high"][index] = bounds.equilibrium
    memory["tau_min"][index], memory["tau_max"][index] = robot.torque_limit.T
    k = np.asarray(bounds.initial_stiffness)
    memory["stiffness"][index] = k
    # Springs whose stiffness alone is adapted have their equilibrium at q_c, where q̄_e is 0.
    stays = one.law.adapts == ("gamma_k",)
    away = 0.0 if stays else np.asarray(bounds.initial_equilibrium) - one.q_c
    memory["offset"][index] = k * away
    # A joint that turns by a radian in a time step is beyond any sampled control.
    dt = experiment.simulation.timestep
    memory["before"][index] = robot.position
    memory["torque_limit"][index] = np.diag(robot.inertia) / dt**2
    for name, value in (
        ("site", robot.site),
        ("rotates", robot.rotates),
        ("form", {"inverse": 0, "transpose": 1, "damped": 2}[chosen.jacobian]),
        ("difference", chosen.velocity == "difference"),
        ("inertial", bool(chosen.feedback.any())),
        ("usual", 0.1 * robot.usual),
        ("count", len(law.parameters)),
        ("alpha", law.alpha),
        ("alpha_0", law.alpha_0),
        ("timestep", dt),
        ("stages", 4 if experiment.simulation.integrator == "RK4" else 1),
        ("speed_limit", 1.0 / dt),
    ):
        memory.scalar(name)[index] = value


def load_motion(memory: Memory, index: int, one: Prepared, cycle: int) -> None:
    """Write the tables of a cycle of the run into the memory."""
    samples = desired(one, cycle)
    steps = len(samples.x)
    memory["x_desired"][index, :steps] = samples.x
    memory["dx_desired"][index, :steps] = samples.dx
    if one.gains.velocity == "difference":
        positions = len(one.robot.position_axes)
        # A passage does not begin where it ends.
        first = samples.x[0] - samples.dx[0] * one.experiment.simulation.timestep
        before = samples.x[-1] if one.blending(cycle) is None else first
        moved = np.diff(samples.x, axis=0, prepend=before[None])
        velocity = moved / one.experiment.simulation.timestep
        memory["dx_desired"][index, :steps, :positions] = velocity[:, :positions]
    for what in one.law.told:
        TELL[what](memory, index, one, cycle)


def _tell_joints(memory: Memory, index: int, one: Prepared, cycle: int) -> None:
    """The desired joint angles and velocities."""
    q, dq, ddq = one.joint_motion(cycle)
    if one.experiment.simulation.integrator != "RK4":
        # After a semi-implicit step q is that of its end, and q̇ that of its middle.
        dq = dq - 0.5 * one.experiment.simulation.timestep * ddq
    memory["q_desired"][index, : len(q)] = q
    memory["dq_desired"][index, : len(q)] = dq


def _tell_springs(memory: Memory, index: int, one: Prepared, cycle: int) -> None:
    """The springs that are the best for the motion."""
    best = one.optima[one.schedule[cycle]]
    memory["q_c"][index] = best.center
    memory["stiffness"][index] = best.stiffness
    memory["offset"][index] = best.offset


def _tell_torque(memory: Memory, index: int, one: Prepared, cycle: int) -> None:
    """The motors' torque that makes the desired motion with these springs, by inverse dynamics."""
    segment = one.schedule[cycle]
    best, joints = one.optima[segment], one.joint_motion(cycle)
    needed = Kinematics(one.loaded[segment]).torque(joints)
    memory["learned"][index, : len(needed)] = needed - springs.torque(
        best.stiffness, best.offset, joints.q, best.center
    )


TELL: dict[str, Callable[[Memory, int, Prepared, int], None]] = {
    "joints": _tell_joints,
    "springs": _tell_springs,
    "torque": _tell_torque,
}
"""What a law may be told of a cycle, by the names that laws.LAWS uses."""


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
