"""An experiment that is simulated while it is watched, in step with the clock."""

from collections.abc import Callable

import mujoco
import numpy as np

from ...laws.memory import Memory
from ...plan.plan import Plan
from ...results.run import Run
from ...simulation.simulation import simulate_plans
from ...simulation.stepper import Alone
from ...status import Status
from ..film.options import RenderOptions
from . import live_data
from .clock import Clock
from .live_data import LiveData
from .window import Closed, Window

PORTION = 64
"""Time steps between looks at the time, at most."""
BEHIND = 0.5
"""How far a simulation may fall behind the clock, which waits then [s]."""


class Restarted(Exception):  # noqa: N818 (nothing went wrong)
    """The user wants the run from its beginning."""


class Watched(Alone):
    """One robot in one mjData, shown in a window while it is advanced.

    Args:
        models: the robot's model, in a list.
        prepared: the experiment.
        window: where it is shown.
        clock: how far the run should be.
    """

    def __init__(
        self, models: list[mujoco.MjModel], prepared: Plan, window: Window, clock: Clock
    ) -> None:
        super().__init__(models)
        self._window, self._clock, self._starts = window, clock, clock.starts
        self._dt = prepared.experiment.simulation.timestep
        self._memory = Memory(self.userdata, prepared.layout)
        self._live = LiveData(prepared, self._memory)
        self._cycle = self._taken = 0
        # A payload's body is one that the window's copy of the arm does not have.
        bodies = np.arange(models[0].nbody)
        self._bodies = bodies[bodies != prepared.robot.payload]

    def step(self, robots: list[int], steps: int) -> None:
        """Advance the robot by a cycle of so many time steps.

        Raises:
            Closed: the window was closed.
            Restarted: the user wants the run from its beginning.
        """
        self._live.begin(self._cycle)
        done = 0
        while done < steps:
            failed = self._recorded(steps) < steps
            due = steps if failed else self._clock.steps(self._dt) - self._taken
            some = min(due, steps - done, PORTION)
            if some > 0:
                super().step(robots, some)
                done, self._taken = done + some, self._taken + some
            if some <= 0 or self._window.late:
                self._live.fill(min(done, self._recorded(steps)))
                self.show()
                if due * self._dt > BEHIND * self._clock.speed:
                    self._clock.go_on_at(self._taken * self._dt)
        self._live.fill(self._recorded(steps))
        self._cycle += 1

    def show(self, state: str = "") -> None:
        """Show the last sample, and wait for the next frame; `state` is what the line adds."""
        self._window.go_on(self._live.shown, self._live.scales, state)
        self._window.show(self._live.sample)
        self._window.wait()
        self.data.xfrc_applied[self._bodies] = self._window.pushes
        if self._clock.starts != self._starts:
            raise Restarted

    def _recorded(self, steps: int) -> int:
        """How many of a cycle's time steps were recorded: not those after the run has failed."""
        failed = int(self._memory.scalar("failed_step")[0])
        return failed - 1 if failed else steps


def live(
    prepared: Plan,
    options: RenderOptions,
    clock: Clock,
    once: bool,
    ended: Callable[[Run], None],
    note: Callable[[str], None],
) -> Run | None:
    """Simulate an experiment in a window, until the window is closed.

    Args:
        prepared: the experiment.
        options: camera, background and what is drawn.
        clock: how fast.
        once: close the window when the run ends.
        ended: is called with the run as soon as it ends.
        note: is called with each line that the user should know.

    Returns:
        The last run that ended, None if there is none.
    """
    run: Run | None = None
    with Window(
        live_data.whole(prepared), options, live_data.expected(prepared, 0), clock, note
    ) as window:
        while True:
            clock.go_on_at(0.0)
            watched = Watched([prepared.robot.model], prepared, window, clock)
            try:
                run = _simulate(prepared, watched)
                ended(run)
                while not once:
                    watched.show("the end" if run.status is Status.OK else str(run.status))
                return run
            except Restarted:
                continue
            except Closed:
                return run


def _simulate(prepared: Plan, watched: Watched) -> Run:
    return simulate_plans([prepared], lambda models: watched)[0]
