"""A simulation as frame data: what is planned, and a cycle that fills up while it goes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...laws.memory import Memory
from ...plan.plan import Plan
from ...results.metrics import reduction, tracks
from ..film import frame_data
from ..film.frame_data import FrameData, Scale
from ..film.plan_data import planned

OF_SAMPLES = (
    *("time", "cycle", "period", "q", "x", "x_desired", "stiffness", "offset", "center", "tau"),
    *("reduction", "best"),
)
"""What frame data have of each sample."""


def joined(parts: Sequence[FrameData]) -> FrameData:
    """Parts of one arm's run, one after the other."""
    whole: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in OF_SAMPLES
    }
    cycle = whole["cycle"]
    first = np.searchsorted(cycle, cycle)
    return replace(parts[-1], sample=np.arange(len(cycle)), first=first, **whole)


def whole(one: Plan) -> FrameData:
    """A cycle of each motion as it should be: all that the run will come past."""
    return joined([planned(one, one.schedule.index(i)) for i in range(len(one.joints))])


def expected(one: Plan, segment: int) -> Scale:
    """What the overlays' full thickness, colour and length stand for while nothing is known.

    Args:
        one: the experiment.
        segment: which motion: its optimal springs, and the torque without any.
    """
    best = one.optima[segment]
    needed = np.abs(best.torque_without_springs).max(axis=0)
    return frame_data.scale_of(np.abs(best.stiffness), needed, one.robot.slides)


class LiveData:
    """What is simulated, taken from the controller's memory.

    Args:
        prepared: the experiment.
        memory: of its controller.

    Attributes:
        shown: the cycle that is being simulated, behind the one before it.
        sample: the last sample of it that has been simulated.
        scales: what the overlays' full thickness, colour and length stand for.
    """

    def __init__(self, prepared: Plan, memory: Memory) -> None:
        self._one, self._memory = prepared, memory
        self.shown, self.scales = planned(prepared, 0), expected(prepared, 0)
        self.sample = self._begin = self._filled = 0

    def begin(self, cycle: int) -> None:
        """Go on to a cycle of the run, counted from 0; the one before it has been filled."""
        if cycle == 0:
            return
        coming = planned(self._one, cycle)
        # Springs that grow stiffer than the optimum's become what the thickest stands for.
        hoped = expected(self._one, self._one.schedule[cycle])
        self.scales = Scale(*map(_most, self.scales, hoped, frame_data.scale([self.shown])))
        before = self._last()
        motion = self._one.schedule[cycle]
        if motion == self._one.schedule[cycle - 1]:
            without = self._one.optima[motion].torque_squared_without_springs
            off = np.sqrt(((before.x - before.x_desired) ** 2).sum(axis=1).mean())
            if tracks(off, np.ptp(before.x_desired, axis=0).max()):
                coming.reduction[:] = reduction((before.tau**2).sum(axis=1).mean(), without)
        self.shown = joined([before, coming])
        self._begin, self._filled = len(before.time), 0

    def fill(self, steps: int) -> None:
        """Take what was recorded in the first `steps` steps of the cycle."""
        new = slice(self._filled, steps)
        at = slice(self._begin + self._filled, self._begin + steps)
        for name in ("q", "x", "tau", "stiffness", "offset"):
            values = getattr(self.shown, name)
            values[at] = self._memory.recorded(name, steps)[0, new, : values.shape[1]]
        self.shown.center[at] = self._memory["q_c"][0]
        self._filled = steps
        self.sample = max(self._begin + steps - 1, 0)

    def _last(self) -> FrameData:
        """The last cycle of it."""
        part: Any = {name: getattr(self.shown, name)[self._begin :] for name in OF_SAMPLES}
        return replace(self.shown, **part)


def _most(*values: np.ndarray) -> np.ndarray:
    return np.max(values, axis=0)
