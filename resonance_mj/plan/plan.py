"""Everything that is known of an experiment before its first step, built once and passed on."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypeVar, cast

import numpy as np

from ..callback.callback import refuse_foreign
from ..errors import StabilityError
from ..experiments.effects import without_effect
from ..experiments.experiment import Experiment
from ..laws import laws
from ..laws.gains import Gains, gains
from ..laws.laws import Law
from ..laws.memory import Layout, layout_of
from ..motions import carrying, default_motion, poses
from ..motions import motion as motions
from ..motions.kinematics import JointMotion, Kinematics
from ..robots.robot import Robot
from ..robots.warned import heard
from ..springs.cost import Drives
from ..springs.fit import LinearSprings
from ..springs.optimum import Optimum, best_springs
from ..text import Caution
from . import notes
from .building import Followed, built
from .driving import drives
from .filling import Left, adapting, without_passage
from .finishing import finished
from .holding import holding
from .inputs import Input, gather
from .passages import desired, passages

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Plan:
    """An experiment with all that it needs; what is not a field is found when it is first asked.

    Attributes:
        experiment: with everything that it left open in its motions filled in.
        robot: its arm, without a payload.
        kinematics: of the robot.
        loaded: of the robot with the payload of each motion.
        law: what the law does.
        gains: that it has on the robot.
        left: what the arm did before; None if it was at rest at home.
        looks: whether what is doubtful is looked for, which takes a while.
    """

    experiment: Experiment
    robot: Robot
    kinematics: Kinematics
    loaded: list[Kinematics]
    law: Law
    gains: Gains
    left: Left | None
    looks: bool
    _followed: Followed = field(repr=False)
    _warned: list[str] = field(default_factory=list, repr=False)

    @cached_property
    def joints(self) -> list[JointMotion]:
        """Joint motion of each motion, by inverse kinematics on the branch of the home pose.

        Raises:
            MotionError: a motion leaves the arm's reach or passes through a singular pose.
        """
        return self._shared("joints", self._follow)

    @cached_property
    def optima(self) -> list[Optimum]:
        """The best constant springs of each motion, by inverse dynamics; no law uses them."""
        experiment, bounds, found = self.experiment, self.gains.bounds, []
        for index, (motion, joints) in enumerate(zip(experiment.motion, self.joints, strict=True)):
            load, torque = self._load(index), self.needed(index)
            # Springs of other laws than the printed ones are centred on the motion's own mean.
            center, q = self.q_c if experiment.law.printed else joints.q.mean(axis=0), joints.q
            within = [np.asarray(part).tobytes() for part in (center, *bounds.stiffness)]
            kind = repr((experiment.springs, bounds.objective, bounds.material))
            springs = "springs", *load, *within, kind
            work = partial(
                best_springs, q, torque, center=center, period=motion.period, bounds=bounds
            )
            found.append(self._shared(springs, work))
        return found

    @cached_property
    def drives(self) -> Drives:
        """The motors of the arm."""
        return drives(self.experiment, self.robot, self.needed, [])

    @cached_property
    def q_c(self) -> np.ndarray:
        """Centre of the springs' regressor (n,) [rad]; "mean" is that of the first motion."""
        return self._center(self.experiment.law.q_c)

    @cached_property
    def holding(self) -> LinearSprings | None:
        """Springs that hold the arm at home from the first step; None where its motors can."""
        return holding(self.experiment, self.gains.bounds, self.loaded[0], self.q_c)

    @cached_property
    def q_s(self) -> np.ndarray:
        """Centre of the learning's regressor (n,) [rad]."""
        return self._center(self.experiment.law.q_s)

    @cached_property
    def unstable(self) -> tuple[str, ...]:
        """What will diverge, a line each."""
        known = self.experiment, self.loaded, self.gains, self.joints, self.optima, self.q_c
        return tuple(notes.unstable(*known))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What is doubtful, a `Caution` each, and then what was found or changed, a line each."""
        seen = self._heard(self._look) if self.looks else self.robot.notes
        lines = dict.fromkeys((*seen, *self._warned))
        return tuple(sorted(lines, key=lambda line: not isinstance(line, Caution)))

    @cached_property
    def inputs(self) -> tuple[Input, ...]:
        """The files that the experiment depends on, as they are when it is first asked for them."""
        return gather(self.experiment)

    @property
    def layout(self) -> Layout:
        """Sizes of the controller's block of memory."""
        return layout_of(self.experiment, self.robot.n, self.robot.m, self.robot.model.nv)

    @cached_property
    def schedule(self) -> list[int]:
        """Of each cycle in a row, the motion that it repeats."""
        return [i for i, motion in enumerate(self.experiment.motion) for _ in range(motion.cycles)]

    def steps(self, segment: int) -> int:
        """Time steps in a cycle of a motion."""
        return self.experiment.motion[segment].steps(self.experiment.simulation.timestep)

    def parts(self, segment: int) -> list[tuple[int, Robot]]:
        """Time steps of each part of a cycle of a motion, and the robot with what it carries."""
        return carrying.parts(self.loaded[segment], self.steps(segment))

    def blending(self, cycle: int) -> int | None:
        """Which cycle of the passage into its motion a cycle of the run is, None for no passage."""
        segment = self.schedule[cycle]
        begun = cycle - self.schedule.index(segment)
        return begun if begun < self.experiment.motion[segment].passage else None

    def desired(self, cycle: int) -> motions.Samples:
        """The desired motion in a cycle of the run: a motion, or the passage to it."""
        return desired(self, cycle)

    def joint_motion(self, cycle: int) -> JointMotion:
        """Joint motion that makes the desired motion of a cycle of the run."""
        passed = self.blending(cycle) is None
        return self.joints[self.schedule[cycle]] if passed else self.passages[cycle]

    @cached_property
    def passages(self) -> dict[int, JointMotion]:
        """Joint motion of each cycle of the run in which the arm passes over into a motion.

        Raises:
            MotionError: a passage leaves the arm's reach or goes through a singular pose.
        """
        return passages(self)

    def refuse_unstable(self) -> None:
        """Raise a StabilityError if something will diverge."""
        if self.unstable:
            more = f" (and {rest} more)" if (rest := len(self.unstable) - 1) else ""
            raise StabilityError(f"experiment {self.experiment.name!r}: {self.unstable[0]}{more}")

    def needed(self, index: int) -> np.ndarray:
        """Torque that a motion needs, of motors and springs together (N, n) [N m]."""
        torque = self.loaded[index].torque
        return self._shared(self._load(index), partial(torque, self.joints[index]))

    def _load(self, index: int) -> tuple[object, ...]:
        """What the torque that a motion needs depends on besides the joint motion."""
        payload, friction = self.experiment.motion[index].payload, self.experiment.reality.friction
        return index, payload, self.experiment.simulation.gravity, friction

    def _shared(self, what: object, work: Callable[[], T]) -> T:
        """What some work on joint motions finds, once for all experiments that have the same."""
        experiment, alike = self.experiment, {"blend": 0, "payload": 0.0}
        # Not how often, by which law or with which load.
        cycles = [
            one.model_copy(update={"duration": one.period} | alike) for one in experiment.motion
        ]
        how = experiment.robot, experiment.task, experiment.simulation.timestep
        key = (what, *how, self.gains.alpha_0, *cycles)
        if key not in self._followed:
            self._followed[key] = self._heard(work)
        return cast("T", self._followed[key])

    def _heard(self, work: Callable[[], T]) -> T:
        """The result of some work, with what MuJoCo warns of meanwhile kept for the notes."""
        with heard() as warned:
            result = work()
        self._warned.extend(warned)
        return result

    def _look(self) -> tuple[str, ...]:
        square, limited = self.robot.m == self.robot.n, bool(self.robot.limited.any())
        given = without_effect(self.experiment, square=square, limited=limited)
        before = notes.before(self.loaded, self.joints, self.optima)
        before += notes.rounded(self.experiment)
        held = notes.held(self.robot, self.holding if self.left is None else None)
        lost = notes.lost(self.loaded, self.joints, self.optima)
        return (*self.unstable, *before, *map(Caution, given), *self.robot.notes, *held, *lost)

    def _follow(self) -> list[JointMotion]:
        experiment, start, found = self.experiment, self.robot.home, []
        for index, motion in enumerate(experiment.motion):
            samples = motions.sample(motion, self.steps(index), self.robot)
            if self.robot.joint_space:
                found.append(JointMotion(*samples[:3]))
                continue
            name = f"experiment {experiment.name!r}: motion.{index}"
            how = start, motion.period, name, self.gains.alpha_0
            found.append(self.kinematics.follow(samples, *how))
            start = found[-1].q[-1]
        return found

    def _center(self, value: str | float | tuple[float, ...]) -> np.ndarray:
        if value == "mean":
            return self.joints[0].q.mean(axis=0)
        if value == "running":  # of the cycles made: before the first the arm has stood at home
            return self.robot.home.copy()
        return np.broadcast_to(np.asarray(value, float), self.robot.n).copy()


def plan_for(
    experiment: Experiment,
    followed: Followed | None = None,
    left: Left | None = None,
    *,
    looks: bool = True,
) -> Plan:
    """Load the law and the robot of an experiment, and fill in what it leaves open.

    Args:
        experiment: what to plan.
        followed: joint motions of experiments before, taken from here and added here.
        left: what the arm did before, if it was not at rest; the same motion goes on without a
            passage.
        looks: whether its notes say what is doubtful, and what will diverge.

    Raises:
        ExperimentError: a list in the experiment is not as long as the arm or the task needs.
        RobotError: the robot cannot be loaded.
        MotionError: no size was given and the arm can make the motion in none.
        CallbackError: a callback that is not ours would act on the robot.
    """
    refuse_foreign()
    law = laws.load(experiment.law.kind).in_space(experiment.task.space)
    unloaded = built(experiment, followed)
    robot = unloaded.robot
    said = [*robot.notes, *law.said]
    experiment = adapting(experiment, law, robot, said)
    with heard() as warned:
        chosen = gains(experiment, unloaded)
        experiment = default_motion.filled_in(experiment, unloaded, chosen.alpha_0, said)
        along = poses.along(experiment, unloaded) if experiment.reality.sensed else ()
        chosen = gains(experiment, unloaded, poses.middles(experiment, unloaded), along)
    robot = replace(robot, notes=tuple(said))
    if left is not None:
        experiment = without_passage(experiment, left.motion)
    plan = Plan(
        experiment=experiment,
        robot=robot,
        kinematics=unloaded,
        loaded=carrying.loaded(experiment, unloaded),
        law=law,
        gains=chosen,
        left=left,
        looks=looks,
        _followed={} if followed is None else followed,
        _warned=warned,
    )
    return finished(plan, warned)


def optimum(experiment: Experiment) -> list[Optimum]:
    """The optimum of each motion of an experiment, by inverse dynamics within its springs' bounds.

    Raises:
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
    """
    return plan_for(experiment).optima
