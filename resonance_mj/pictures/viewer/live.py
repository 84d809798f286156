"""An experiment that is simulated while it is watched, in step with the clock."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from ...laws.memory import Memory
from ...plan.plan import Plan
from ...results.metrics import reduction, tracks
from ...results.run import Run
from ...robots import elastic
from ...simulation.simulation import simulate_plans
from ...simulation.stepper import Alone
from ...status import Status
from ..film import frame_data
from ..film.frame_data import FrameData, Scale, planned
from ..film.options import RenderOptions
from .clock import Clock, Closed

PORTION = 64
"""Time steps between looks at the time, at most."""
BEHIND = 0.5
"""How far a simulation may fall behind the clock, which waits then [s]."""
OF_SAMPLES = (
    *("time", "cycle", "period", "q", "x", "x_desired", "stiffness", "offset", "center", "tau"),
    *("elastic", "reduction", "best"),
)
"""What frame data have of each sample."""


class Restarted(Exception):  # noqa: N818 (nothing went wrong)
    """The user wants the run from its beginning."""


class Watched(Alone):
    """One robot in one mjData, shown in a window while it is advanced.

    Args:
        models: the robot's model, in a list.
        plan: of the experiment.
        window: where it is shown.
        clock: how far the run should be.
    """

    def __init__(self, models: list[mujoco.MjModel], plan: Plan, window: Any, clock: Clock) -> None:
        super().__init__(models)
        self._plan, self._window, self._clock = plan, window, clock
        self._starts, self._dt = clock.starts, plan.experiment.simulation.timestep
        self._memory = Memory(self.userdata, plan.layout)
        # The cycle that is simulated, as it is planned until then, behind the one before it.
        self._shown, self._scale = planned(plan, 0), expected(plan, 0)
        self._cycle = self._done = self._taken = self._begin = self._filled = 0
        # A payload's body is one that the window's copy of the arm does not have.
        bodies = np.arange(models[0].nbody)
        self._bodies = bodies[bodies != plan.robot.payload]

    def simulate(self) -> Run:
        """Simulate the experiment, with what `step` raises."""
        return simulate_plans([self._plan], lambda models: self)[0]

    def step(self, robots: list[int], steps: int) -> None:
        """Advance the robot by so many time steps of a cycle.

        Raises:
            Closed: the window was closed.
            Restarted: the user wants the run from its beginning.
        """
        whole = self._plan.steps(self._plan.schedule[self._cycle])
        if self._cycle and not self._done:
            self._go_on()
        end = self._done + steps
        while self._done < end:
            failed = self._recorded(whole) < whole
            due = steps if failed else self._clock.steps(self._dt) - self._taken
            some = min(due, end - self._done, PORTION)
            if some > 0:
                super().step(robots, some)
                self._done, self._taken = self._done + some, self._taken + some
            if some <= 0 or self._window.late:
                self._fill(min(self._done, self._recorded(whole)))
                self.show()
                if due * self._dt > BEHIND * self._clock.speed:
                    self._clock.go_on_at(self._taken * self._dt)
        if end == whole:
            self._fill(self._recorded(whole))
            self._cycle, self._done = self._cycle + 1, 0

    def show(self, state: str = "") -> None:
        """Show the last sample, and wait for the next frame; `state` is what the line adds."""
        sample = max(self._begin + self._filled - 1, 0)
        # A copy: what has been filled in since the last frame is new to the window.
        self._window.show(replace(self._shown), sample, self._scale, state)
        self.data.xfrc_applied[self._bodies] = self._window.pushes
        if self._clock.starts != self._starts:
            raise Restarted

    def _recorded(self, steps: int) -> int:
        """How many of a cycle's time steps were recorded: not those after the run has failed."""
        failed = int(self._memory.scalar("failed_step")[0])
        return failed - 1 if failed else steps

    def _fill(self, steps: int) -> None:
        """Take what was recorded in the first `steps` steps of the cycle."""
        new = slice(self._filled, steps)
        at = slice(self._begin + self._filled, self._begin + steps)
        for name in ("q", "x", "tau", "stiffness", "offset"):
            values = getattr(self._shown, name)
            values[at] = self._memory.recorded(name, steps)[0, new, : values.shape[1]]
        self._shown.center[at] = self._memory["q_c"][0]
        if self._plan.robot.elements:
            acting = elastic.read(self.models[0], self._plan.robot.elements)
            self._shown.elastic[at] = acting.torque(self._shown.q[at])
        self._filled = steps

    def _go_on(self) -> None:
        """Go on to the next cycle; the one before it has been filled."""
        plan, motion = self._plan, self._plan.schedule[self._cycle]
        part: Any = {name: getattr(self._shown, name)[self._begin :] for name in OF_SAMPLES}
        before, now = replace(self._shown, **part), planned(plan, self._cycle)
        # Springs that grow stiffer than the optimum's become what the thickest stands for.
        scales = self._scale, expected(plan, motion), frame_data.scale([self._shown])
        self._scale = Scale(*np.max(scales, axis=0))
        if motion == plan.schedule[self._cycle - 1]:
            best = plan.optima[motion]
            off = np.sqrt(((before.x - before.x_desired) ** 2).sum(axis=1).mean())
            if tracks(off, np.ptp(before.x_desired, axis=0).max()):
                cost = best.rate(before.tau), best.rate(best.torque_without_springs)
                now.reduction[:] = reduction(*cost)
        self._shown, self._begin, self._filled = joined([before, now]), len(before.time), 0


def joined(parts: Sequence[FrameData]) -> FrameData:
    """Parts of one arm's run, one after the other."""
    whole: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in OF_SAMPLES
    }
    return replace(parts[-1], sample=np.arange(len(whole["time"])), **whole)


def expected(plan: Plan, motion: int) -> Scale:
    """The overlays' scale while nothing is known: the best springs, and the torque without any."""
    best = plan.optima[motion]
    needed = np.abs(best.torque_without_springs).max(axis=0)
    return frame_data.scale_of(np.abs(best.stiffness), needed, plan.robot.slides)


def live(
    plan: Plan,
    options: RenderOptions,
    clock: Clock,
    once: bool,
    ended: Callable[[Run], None],
    note: Callable[[str], None],
    window_of: Callable[..., Any],
) -> Run | None:
    """Simulate an experiment in a window, until the window is closed.

    Args:
        plan: of the experiment.
        options: camera, background and what is drawn.
        clock: how fast.
        once: close the window when the run ends.
        ended: is called with the run as soon as it ends.
        note: is called with each line that the user should know.
        window_of: opens the window of what is shown, options, clock and note.

    Returns:
        The last run that ended, None if there is none.
    """
    run: Run | None = None
    # A cycle of each motion as it should be: all that the run will come past.
    whole = joined([planned(plan, plan.schedule.index(i)) for i in range(len(plan.joints))])
    with window_of(whole, options, clock, note) as window:
        while True:
            clock.go_on_at(0.0)
            watched = Watched([plan.robot.model], plan, window, clock)
            try:
                run = watched.simulate()
                ended(run)
                while not once:
                    watched.show("the end" if run.status is Status.OK else str(run.status))
                return run
            except Restarted:
                continue
            except Closed:
                return run
