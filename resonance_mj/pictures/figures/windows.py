"""A time axis that shows only where something happens, and breaks in between."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from .style import SMALL, breadth
from .text import width_of


class Windows:
    """The start, two cycles on either side of each change of motion, and the end of a run.

    Args:
        data: `Run.data` with at least one sample.
    """

    def __init__(self, data: xr.Dataset) -> None:
        time = data["time"].values
        starts, ends, period = (data[name].values for name in ("start", "end", "period"))
        last = float(min(time[-1] + np.diff(time[-2:]).sum(), ends[-1]))
        reached = int(np.searchsorted(starts, last, side="right")) - 1
        wanted = [(0.0, 2 * period[0])]
        wanted += [
            (starts[i] - 2 * period[i - 1], starts[i] + 2 * period[i])
            for i in range(1, reached + 1)
        ]
        wanted.append((last - 2 * period[reached], last))
        self.spans: list[tuple[float, float]] = []
        for low, high in wanted:
            low, high = max(low, 0.0), min(high, last)
            if self.spans and low <= self.spans[-1][1]:
                self.spans[-1] = (self.spans[-1][0], high)
            else:
                self.spans.append((low, high))
        self._gap = 0.06 * max(sum(high - low for low, high in self.spans), 1e-9)
        widths = [high - low + self._gap for low, high in self.spans]
        self.left = np.concatenate([[0.0], np.cumsum(widths)])

    def plot(
        self, ax: Axes, data: xr.Dataset, values: xr.DataArray, colour: str, dash: str
    ) -> None:
        """Draw a signal over the windows."""
        for (low, high), left in zip(self.spans, self.left, strict=False):
            for time, piece in _pieces(data["time"].values, values.values, low, high):
                ax.plot(time - low + left, piece, color=colour, linestyle=dash)

    def label(self, ax: Axes) -> None:
        """Put the times on the axis, and mark where it breaks."""
        end = max(self.left[-1] - self._gap, 1e-3)
        room = breadth(ax) / end  # inches per second
        places: list[float] = []
        names: list[str] = []
        for index, ((low, high), left) in enumerate(zip(self.spans, self.left, strict=False)):
            if index:
                ax.axvspan(left - self._gap, left, color="0.93", linewidth=0, zorder=3)
            for tick in _ticks(low, high, room):
                place, name = float(tick - low + left), f"{tick:g}"
                half = width_of(name, SMALL) / 2 / room
                before = places[-1] + width_of(names[-1], SMALL) / 2 / room if places else -np.inf
                if place - half > before + 0.04 / room:
                    places.append(place)
                    names.append(name)
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


def _pieces(
    time: np.ndarray, values: np.ndarray, low: float, high: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """A signal between two times, cut where cycles were left out, at most 800 points in all."""
    inside = np.flatnonzero((time >= low) & (time <= high))
    if not inside.size:
        return
    gap = 1.5 * np.median(np.diff(time[inside])) if inside.size > 1 else np.inf
    for piece in np.split(inside, np.flatnonzero(np.diff(time[inside]) > gap) + 1):
        thin = piece[:: max(1, inside.size // 800)]
        yield time[thin], values[thin]
