"""A time axis that shows only where something happens, and breaks in between."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ...results.run import Run
from ..spans import spans
from .measuring import width_of
from .style import SMALL
from .ticks import breadth


class Windows:
    """The start, two cycles on either side of each change of motion, and the end of a run.

    Args:
        run: with at least one sample.
    """

    def __init__(self, run: Run) -> None:
        self._time = run.data["time"].values
        step = float(np.diff(self._time[-2:]).sum())
        self._spans = spans(run, float(self._time[-1]) + step)
        self._gap = 0.06 * max(sum(high - low for low, high in self._spans), 1e-9)
        widths = [high - low + self._gap for low, high in self._spans]
        self._left = np.concatenate([[0.0], np.cumsum(widths)])

    def plot(self, ax: Axes, values: np.ndarray, **style: Any) -> None:
        """Draw a signal (N,), given at each sample, over the windows in a style."""
        for (low, high), left in zip(self._spans, self._left, strict=False):
            for piece in _pieces(self._time, low, high):
                ax.plot(self._time[piece] - low + left, values[piece], **style)

    def label(self, ax: Axes) -> None:
        """Put the times on the axis, and mark where it breaks."""
        end = max(self._left[-1] - self._gap, 1e-3)
        room = breadth(ax) / end  # inches per second
        places: list[float] = []
        names: list[str] = []
        taken = -np.inf
        for index, ((low, high), left) in enumerate(zip(self._spans, self._left, strict=False)):
            if index:
                ax.axvspan(left - self._gap, left, color="0.93", linewidth=0, zorder=3)
            for tick in _ticks(low, high, room):
                place, name = float(tick - low + left), f"{tick:g}"
                half = width_of(name, SMALL) / 2 / room
                if place - half > taken + 0.04 / room:
                    places.append(place)
                    names.append(name)
                    taken = place + half
        ax.set_xticks(places, names)
        ax.set_xlim(0, end)
        ax.set_xlabel("time [s]")


def _ticks(low: float, high: float, room: float) -> np.ndarray:
    """Times of a window at which its ticks stand."""
    bins = max(1, min(4, int((high - low) * room / 0.25)))
    locator: Any = MaxNLocator(
        nbins=bins, steps=[1, 2, 5, 10], integer=high - low >= 1, min_n_ticks=1
    )
    ticks = np.asarray(locator.tick_values(low, high))
    return ticks[(ticks >= low - 1e-9) & (ticks <= high + 1e-9)]


def _pieces(time: np.ndarray, low: float, high: float) -> Iterator[np.ndarray]:
    """Samples between two times, cut where cycles were left out, at most 800 in all."""
    inside = np.flatnonzero((time >= low) & (time <= high))
    if not inside.size:
        return
    gap = 1.5 * np.median(np.diff(time[inside])) if inside.size > 1 else np.inf
    for piece in np.split(inside, np.flatnonzero(np.diff(time[inside]) > gap) + 1):
        yield piece[:: max(1, inside.size // 800)]
