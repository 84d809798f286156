"""One robot of those that step together: what is done before and after each of its cycles."""

from dataclasses import replace

import numpy as np

from ..errors import ExperimentError
from ..laws import learning, listening
from ..laws.adjusting import write_springs
from ..laws.doubting import Belief
from ..laws.laws import doubts, listens, transfer_in_doubt
from ..laws.memory import Memory
from ..laws.tuning import Tuning
from ..plan.plan import Plan
from ..results import schema
from ..results.motions import motions
from ..results.run import Run
from ..robots import elastic
from ..springs.fit import LinearSprings
from ..status import Status
from .checkpoint import DAMAGED, STATE, packed, unpacked
from .continuing import Start
from .ending import diverging, ending
from .hindrances import hindrances, limited
from .loading import (
    first_springs,
    load_law,
    load_motion,
    load_noise,
    load_springs,
    load_tuning,
    load_way,
)
from .recording import Recording
from .stepper import Alone, Stepper


class Member:
    """One robot of a batch.

    Args:
        plan: of its experiment.
        memory: of the controllers of all robots of the batch.
        stepper: that advances them.
        index: of this robot in both.
        start: what it goes on from; None for rest at home.
    """

    def __init__(
        self,
        plan: Plan,
        memory: Memory,
        stepper: Stepper,
        index: int,
        start: Start | None = None,
    ) -> None:
        self.plan = plan
        self._memory, self._stepper, self._index = memory, stepper, index
        self._recording = Recording(plan)
        self._steps, self._passing = 0, False
        self.status, self._message = Status.OK, ""
        stepper.start(index, plan.robot.qpos)
        load_law(memory, index, plan)
        self._others = first_springs(plan).others
        belief = Belief.begins(plan.robot.n) if doubts(plan.experiment) else None
        self._tuning = Tuning(springs=belief)
        self._listens = listens(plan.experiment.law)
        if start is not None:
            self._go_on_from(start)

    def _go_on_from(self, start: Start) -> None:
        """Take state, springs and learned torque of a run before."""
        memory, index, robot = self._memory, self._index, self.plan.robot
        qpos, qvel = self._stepper.state(index)
        qpos[robot.qpos_address], qvel[robot.dof_address] = start.q, start.dq
        robot.followers.place(qpos)
        robot.followers.move(qvel)
        positions = ["xyz".index(axis) for axis in robot.position_axes]
        memory["before"][index, positions] = start.x[: len(positions)]
        load_springs(memory, index, start.springs, self.plan.gains.bounds)
        self._others = start.springs.others
        memory["learned"][index, : len(start.u)] = start.u

    def resume(self, run: Run) -> None:
        """Take up a run after its last cycle, with all that it had then."""
        assert isinstance(self._stepper, Alone)
        physics, parameters, self._tuning = unpacked(run.data[STATE].values)
        fixed = self._memory.fixed(self._index)
        self._stepper.restore(physics)
        # Compiled steps go by it unchecked, and a file may come from anywhere.
        same = np.array_equal(self._memory.fixed(self._index), fixed)
        shape = self.plan.steps(self.plan.schedule[run.data.sizes["cycle"] - 1]), self.plan.robot.n
        fits = parameters.shape == self._others.parameters.shape
        if not (same and fits and self._tuning.fits(shape)):
            raise ExperimentError(DAMAGED)
        self._others = self._others._replace(parameters=parameters)
        done = run.data.sizes["cycle"]
        self._passing = self.plan.blending(done - 1) is not None
        self._steps = run.steps
        self._recording.restore(run.data)

    def begin_cycle(self, cycle: int) -> None:
        """Set the tables, the load and the springs of a cycle of the run."""
        plan, index = self.plan, self._index
        segment = plan.schedule[cycle]
        begins = cycle == 0 or segment != plan.schedule[cycle - 1]
        passed, self._passing = self._passing, plan.blending(cycle) is not None
        if begins:
            dt = plan.experiment.simulation.timestep
            if (belief := self._tuning.springs) is not None:
                self._tuning = self._tuning._replace(springs=belief.begun())
            if self._listens:
                self._tuning = listening.begun(self._tuning, plan.gains, dt)
                load_tuning(self._memory, index, plan, self._tuning)
        if begins or passed or self._passing:
            load_motion(self._memory, index, plan, cycle)
            if "springs" in plan.law.told:
                self._others = plan.optima[segment].springs.others
        load_noise(self._memory, index, plan, cycle)
        self.carry(cycle, 0)

    def carry(self, cycle: int, part: int) -> None:
        """Have the load of a part of a cycle at the tool, and the springs as they are now."""
        _, robot = self.plan.parts(self.plan.schedule[cycle])[part]
        self._stepper.models[self._index] = model = robot.model
        elastic.write(model, self._others)
        block = self._memory.block(self._index)
        write_springs(block, model.jnt_stiffness, model.qpos_spring, model.dof_damping)

    def end_cycle(self, cycle: int) -> None:
        """Record a cycle, see how it ended, and learn from it what the next one does.

        Raises:
            ExperimentError: a law from a file has failed.
        """
        steps = self.plan.steps(self.plan.schedule[cycle])
        failed = int(self._memory.scalar("failed_step")[self._index])
        if self._memory.scalar("failed_joint")[self._index] < 0:
            raise ExperimentError(
                f"{self.plan.experiment.law.kind}: command raised an exception at step {failed} of "
                f"cycle {cycle + 1}; --interpret says which, and in which line"
            )
        # Plans ask what motions need of the arm without springs, and so without their damping.
        if self.plan.gains.bounds.material is not None:
            for _, robot in self.plan.parts(self.plan.schedule[cycle]):
                robot.model.dof_damping[robot.dof_address] = self._memory["viscous"][self._index]
        signals = self._signals(failed - 1 if failed else steps)
        springs = self.springs
        self._recording.add(signals, springs, whole=not failed)
        self._steps += len(signals["q"])
        self._message = self._what_diverged(cycle, failed)
        if self._message:
            self.status = Status.DIVERGED
        elif cycle + 1 < len(self.plan.schedule):
            self._learn(cycle, signals, springs)

    def interrupt(self, cycle: int) -> None:
        """End after a cycle of the run, if others were to follow."""
        total = len(self.plan.schedule)
        if self.status is Status.OK and cycle + 1 < total:
            self.status = Status.INTERRUPTED
            self._message = f"asked to stop, after cycle {cycle + 1} of {total}"

    def checkpoint(self, cycle: int, wall_s: float) -> Run:
        """The run after a cycle, as if it had been interrupted there; it goes on undisturbed."""
        self.interrupt(cycle)
        found = self.run(wall_s)
        self.status, self._message = Status.OK, ""
        return found

    def run(self, wall_s: float) -> Run:
        """The run so far.

        Args:
            wall_s: wall time of the simulation [s].
        """
        last = self._recording.last.items()
        hindered = {index: hindrances(self.plan, index, cycle) for index, cycle in last}
        robot, (qpos, qvel) = self.plan.robot, self._stepper.state(self._index)
        end = qpos[robot.qpos_address], qvel[robot.dof_address]
        data = self._recording.dataset(hindered, *end)
        if self.status is Status.INTERRUPTED and isinstance(self._stepper, Alone):
            state = packed(self._stepper.whole(), self._others.parameters, self._tuning)
            data = schema.with_checkpoint(data, state)
        ended = ending(self.plan, motions(data, self.plan.experiment.springs.cost), hindered)
        status, message = self.status, self._message
        if status is Status.OK:
            status, message = ended.status, ended.message
        found = self._tuning.said(self.plan.experiment.simulation.timestep)
        notes = (*self.plan.notes, *ended.notes, *found, *self._stepper.warnings(self._index))
        return Run(
            experiment=self.plan.experiment,
            status=status,
            message=message,
            notes=tuple(dict.fromkeys(notes)),
            data=data,
            steps=self._steps,
            simulation_wall_s=wall_s,
            inputs=self.plan.inputs,
            planned=self.plan,
        )

    @property
    def springs(self) -> LinearSprings:
        """The springs that act."""
        k, offset, center = (self._memory[name][self._index] for name in _SPRINGS)
        return LinearSprings(k, offset, center, self._others)

    def _signals(self, steps: int) -> dict[str, np.ndarray]:
        """A copy of what the last cycle's control steps recorded, and what was desired."""
        memory, index = self._memory, self._index
        recorded = memory.columns(memory["record"][index, :steps].copy())
        desired = ("x_desired", "q_desired") if self.plan.robot.joint_space else ("x_desired",)
        return recorded | {name: memory[name][index, :steps] for name in desired}

    def _learn(self, cycle: int, signals: dict[str, np.ndarray], springs: LinearSprings) -> None:
        """Replace the learned torque of a cycle by that of the next; short passages teach none."""
        memory, index, plan = self._memory, self._index, self.plan
        following = plan.steps(plan.schedule[cycle + 1])
        learned = signals["u"]
        memory["stiffness_step"][index] = memory["offset_step"][index] = 0.0
        if not self._passing or plan.experiment.motion[plan.schedule[cycle]].gradual:
            done = self._done(signals, springs)
            if self._listens:
                self._tuning = listening.tuned(
                    self._tuning, done, plan.gains, limited=done.limited > 0, passing=self._passing
                )
                load_tuning(memory, index, plan, self._tuning)
                done = done._replace(tuning=self._tuning)
            if done.tuning.springs is None:
                learned, wanted = plan.law.learn(done, plan.gains, plan.experiment)
            else:
                learned, wanted, belief = transfer_in_doubt(done, plan.gains)
                self._tuning = self._tuning._replace(springs=belief)
            begin = springs.about(wanted.center)
            begin = replace(begin, stiffness=springs.stiffness.copy(), others=wanted.others)
            load_springs(memory, index, wanted, plan.gains.bounds)
            self._others = wanted.others
            if done.acting is not None:
                left = load_way(memory, index, begin, wanted, following)
                left = learning.resample(left[:, None], len(learned))
                ahead = done.torque_of(wanted, done.q) - done.torque_of(begin, done.q)
                learned = learned + left * ahead
        memory["learned"][index, :following] = learning.resample(learned, following)

    def _done(self, signals: dict[str, np.ndarray], springs: LinearSprings) -> learning.Cycle:
        """A cycle's signals as its law sees them."""
        plan, reality = self.plan, self.plan.experiment.reality
        dt, steps = plan.experiment.simulation.timestep, len(signals["u"])
        on_its_way = reality.slow_springs and plan.law.listens
        acting = LinearSprings(
            signals["stiffness"], signals["offset"], springs.center, springs.others
        )
        return learning.Cycle(
            u=signals["u"],
            y=signals["y"],
            q=self._seen(signals["q"]),
            tau=signals["tau"],
            q_desired=self._memory["q_desired"][self._index, :steps],
            springs=springs,
            q_s=plan.q_s,
            timestep=dt,
            hold=reality.steps("control_period", dt),
            tuning=self._tuning,
            acting=acting if on_its_way else None,
            farthest=(reality.stiffness_rate or np.inf) * steps * dt if on_its_way else np.inf,
            passing=self._passing,
            limited=limited(plan, signals["tau"], signals["dq"]),
        )

    def _seen(self, q: np.ndarray) -> np.ndarray:
        """Joint angles of a cycle (N, n) as they were measured; it is taken to follow its like."""
        reality, dt = self.plan.experiment.reality, self.plan.experiment.simulation.timestep
        if not reality.sensed:
            return q
        late = np.roll(q, reality.steps("measurement_delay", dt), axis=0)
        angle = late + self._memory["noise"][self._index, : len(q)]
        step = reality.encoder_resolution
        return step * np.round(angle / step) if step else angle

    def _what_diverged(self, cycle: int, failed: int) -> str:
        """Which joint failed, when, why, and what to try; empty if none did."""
        why = "" if failed else self._recording.diverges()
        if not failed and not why:
            return ""
        plan = self.plan
        if failed:
            joint = plan.robot.joints[int(self._memory.scalar("failed_joint")[self._index])]
            why = f"{joint} would turn by more than one radian in a time step"
        return diverging(plan, cycle, failed, why, self._recording.last.get(plan.schedule[cycle]))


_SPRINGS = ("stiffness", "offset", "q_c")
"""The springs in the controller's memory."""
