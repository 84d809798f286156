"""Numbers at the axes: written in full, as many as there is room for."""

from math import isfinite

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from ...text import minus
from .sheet import width_of
from .style import enlarged, small

LINE = 0.11
"""Height that a number at an ordinate takes [in]."""


def logarithmic(ax: Axes) -> None:
    """A logarithmic ordinate, two ticks at least; an even one if nothing drawn is above zero."""
    if not isfinite(ax.dataLim.minposy):
        even(ax)
        return
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    room = max(2, min(7, int(_inches(ax)[1] / LINE / enlarged())))
    # Over few decades these alone would leave an axis without numbers.
    near = high / low < max(100.0, 10 ** (room / 3))
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if near else (1.0,), numticks=room))
    ax.yaxis.set_major_formatter(_number)
    ax.yaxis.set_minor_locator(NullLocator())


def even(ax: Axes, nbins: int = 4, least: float = 0.0) -> None:
    """An ordinate without a common factor, which would stand in the title, `least` high at least.

    What is small beside that is seen as what it is, and rounding errors as a line.
    """
    ax.set_ylim(_told_apart(*ax.get_ylim(), least))
    ax.yaxis.set_major_locator(MaxNLocator(nbins=nbins))
    ax.yaxis.set_major_formatter(_number)


def abscissa(ax: Axes) -> None:
    """An abscissa whose ticks are as many as do not touch."""
    low, high = _told_apart(*ax.get_xlim())
    ax.set_xlim(low, high)
    scale = breadth(ax) / (high - low)  # inches per unit
    for nbins in (6, 5, 4, 3, 2, 1):
        placed = MaxNLocator(nbins).tick_values(low, high)
        ticks = [float(tick) for tick in placed if low <= tick <= high]
        widest = max((width_of(_number(tick), small()) for tick in ticks), default=0.0)
        if len(ticks) < 2 or (ticks[1] - ticks[0]) * scale > widest + 0.08:
            break
    # The last number must not stand out of the figure.
    ticks = [
        tick for tick in ticks if (high - tick) * scale + 0.1 > width_of(_number(tick), small()) / 2
    ]
    ax.set_xticks(ticks, [_number(tick) for tick in ticks])


def counted(ax: Axes, what: str = "cycle") -> None:
    """An abscissa that counts."""
    ax.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10], integer=True, min_n_ticks=1))
    ax.set_xlabel(what)


def equal(ax: Axes) -> None:
    """Both axes at the same scale, with room about what was drawn (before their ticks are set)."""
    inches = _inches(ax)
    ends = np.array([_told_apart(*each) for each in ax.dataLim.get_points().T])
    reach = 0.58 * (np.diff(ends, axis=1)[:, 0] / inches).max() * inches
    (left, right), (low, high) = zip(*(ends.mean(axis=1) + np.outer([-1, 1], reach)), strict=True)
    ax.set(xlim=(left, right), ylim=(low, high))


def breadth(ax: Axes) -> float:
    """Width of axes [in]."""
    return float(_inches(ax)[0])


def _inches(ax: Axes) -> np.ndarray:
    """Width and height of axes [in]."""
    figure = ax.get_figure()
    assert isinstance(figure, Figure)
    return np.asarray(figure.get_size_inches() * ax.get_position().size)


def _told_apart(low: float, high: float, least: float = 0.0) -> tuple[float, float]:
    """The ends of an axis, so far apart that its ticks differ in the digits that are written."""
    middle, half = (low + high) / 2, max(high - low, 1e-3 * max(abs(low), abs(high)), least) / 2
    return middle - half, middle + half


def _number(value: float, _: object = None) -> str:
    return minus(f"{value:.6g}".replace("e-0", "e-"))
