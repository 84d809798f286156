"""What an experiment needs before its first step, and how it is written into the memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import laws, warnings
from . import motion as motions
from .controller import standard
from .errors import StabilityError
from .experiment import Experiment
from .gains import Gains, gains
from .kinematics import Kinematics
from .laws import CustomLaw
from .memory import Memory
from .optimal_springs import Optimum, along, center, follow, resolved
from .robot import Robot, build


@dataclass(frozen=True)
class Prepared:
    """An experiment with everything that it needs before its first step."""

    experiment: Experiment
    robot: Robot
    law: CustomLaw
    gains: Gains
    notes: tuple[str, ...]
    unstable: tuple[str, ...]
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

    def blending(self, cycle: int) -> int | None:
        """Which cycle of the passage into its motion a cycle of the run is, None for no passage."""
        segment = self.schedule[cycle]
        begun = cycle - self.schedule.index(segment)
        return begun if begun < self.experiment.motion[segment].blend else None

    @property
    def fits_with(self) -> tuple[object, ...]:
        """Equal for experiments that one batch can step together."""
        experiment = self.experiment
        return (
            experiment.robot.mjcf,
            experiment.robot.tool,
            experiment.task,
            experiment.simulation.integrator,
            experiment.law.kind,
            tuple(motion.blend for motion in experiment.motion),
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
    kind = experiment.law.kind
    law = CustomLaw(standard, None) if kind in ("transfer", "paper") else laws.load(kind)
    robot = build(experiment)
    experiment = resolved(experiment, robot)
    found = follow(experiment, robot)
    optima = along(experiment, robot, found)
    chosen = gains(experiment, robot)
    unstable = tuple(warnings.unstable(experiment, robot, chosen, found, optima))
    return Prepared(
        experiment=experiment,
        robot=robot,
        law=law,
        gains=chosen,
        notes=(*robot.notes, *warnings.before(robot, found, optima), *unstable),
        unstable=unstable,
        optima=optima,
        q_c=center(experiment.law.q_c, found, robot),
        q_s=center(experiment.law.q_s, found, robot),
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
    for name in ("gamma_k", "gamma_qe"):
        memory[name][index] = getattr(law, name)
    memory["parameters"][index] = law.parameters
    memory["q_c"][index] = one.q_c
    memory["q_s"][index] = one.q_s
    memory["k_min"][index], memory["k_max"][index] = bounds.stiffness
    memory["low"][index], memory["high"][index] = bounds.equilibrium
    memory["tau_min"][index], memory["tau_max"][index] = robot.torque_limit.T
    k = np.asarray(bounds.initial_stiffness)
    memory["stiffness"][index] = k
    memory["offset"][index] = k * (np.asarray(bounds.initial_equilibrium) - one.q_c)
    # A joint that turns by a radian in a time step is beyond any sampled control.
    dt = experiment.simulation.timestep
    memory["torque_limit"][index] = np.diag(robot.inertia) / dt**2
    for name, value in (
        ("site", robot.site),
        ("rotates", robot.rotates),
        ("form", {"inverse": 0, "transpose": 1, "damped": 2}[chosen.jacobian]),
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
    """Write the table of a cycle of the run into the memory."""
    samples = desired(one, cycle)
    steps = len(samples.x)
    memory["x_desired"][index, :steps] = samples.x
    memory["dx_desired"][index, :steps] = samples.dx


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
