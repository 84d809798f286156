"""Of which cycles of a long run the samples are kept."""

from collections.abc import Mapping

import numpy as np

from ..plan.plan import Plan

LAST = 2
"""Whole cycles before an early end whose samples are kept in any case."""

Signals = dict[str, np.ndarray]
"""What a cycle's control steps recorded, by the names of `COLUMNS`, and x_desired (N, ·)."""


class Samples:
    """The samples that are kept of a run: those of `kept_cycles`, and what led to an early end.

    Args:
        plan: of the run.
        shapes: of each variable, but for its time steps.
    """

    def __init__(self, plan: Plan, shapes: Mapping[str, tuple[int, ...]]) -> None:
        self._kept, self._cycles = kept_cycles(plan), len(plan.schedule)
        # Made at once, and touched: it does not grow. What diverges keeps part of a cycle more.
        steps = [plan.steps(segment) for segment in plan.schedule]
        room = sum(steps[cycle] for cycle in self._kept) + max(steps)
        self._arrays = {name: np.full((room, *shape), 0.0) for name, shape in shapes.items()}
        self._filled = 0
        self._recent: dict[int, Signals] = {}

    @property
    def names(self) -> list[str]:
        """Of the variables."""
        return list(self._arrays)

    @property
    def thinned(self) -> bool:
        """Whether cycles of a whole run are left out."""
        return len(self._kept) < self._cycles

    def take(self, cycle: int, signals: Signals, *, whole: bool = True) -> None:
        """Keep the samples of a cycle, from 0, or hold them as long as it is one of the last."""
        if whole and cycle not in self._kept:
            last = {one: each for one, each in self._recent.items() if one > cycle - LAST}
            # A copy: the motion and the springs' centers are views of what the next cycle changes.
            self._recent = last | {cycle: {name: each.copy() for name, each in signals.items()}}
            return
        end = self._filled + len(signals["time"])
        for name, array in self._arrays.items():
            array[self._filled : end] = signals[name]
        self._filled = end

    def so_far(self, done: int) -> Signals:
        """The samples that are kept, and where it is not the end those of the last cycles.

        Args:
            done: whole cycles so far.
        """
        found = {name: array[: self._filled].copy() for name, array in self._arrays.items()}
        recent = [each for cycle, each in self._recent.items() if cycle >= done - LAST]
        if done == self._cycles or not recent:
            return found
        for name, kept in found.items():
            like = [np.empty((len(each["time"]), *kept.shape[1:])) for each in recent]
            for part, each in zip(like, recent, strict=True):
                part[:] = each[name]
            found[name] = np.concatenate([kept, *like])
        in_order = np.argsort(found["time"], kind="stable")
        return {name: array[in_order] for name, array in found.items()}


def kept_cycles(plan: Plan) -> set[int]:
    """Cycles whose samples are kept: all, or pairs in a row over each motion with both ends.

    What is learned from a cycle shows in the next.
    """
    motions, budget = plan.experiment.motion, plan.experiment.simulation.samples
    total = sum(motion.cycles * plan.steps(i) for i, motion in enumerate(motions))
    share = min(1.0, budget / total)
    kept: set[int] = set()
    first = 0
    for motion in motions:
        pairs = max(4, int(share * motion.cycles)) // 2
        if share == 1.0 or 2 * pairs >= motion.cycles:
            kept.update(range(first, first + motion.cycles))
        else:
            begins = first + np.linspace(0, motion.cycles - 2, pairs).round().astype(int)
            kept.update(begins, begins + 1)
        first += motion.cycles
    return {int(cycle) for cycle in kept}
