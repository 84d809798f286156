"""How all figures look: fonts that can be read in print, thin axes, text that stays text."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from ..palette import DESIRED, MEASURED, MUTED, OPTIMAL
from .text import width_of

FONT, SMALL, HEADING = 8.0, 7.0, 9.0
"""Sizes of titles and labels, of numbers at the axes and remarks, and of the heading [pt]."""

LABEL_BOX = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 1}
"""Behind words that stand on lines."""

STYLE: Any = {
    "font.size": FONT,
    "axes.titlesize": FONT,
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # given, or matplotlib measures every text above the axes to find it
    "axes.titlepad": 4,
    "axes.labelsize": SMALL,
    "axes.labelpad": 1,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.major.pad": 2,
    "ytick.major.pad": 2,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.fontsize": SMALL,
    "svg.fonttype": "none",
    "svg.hashsalt": "resonance-mj",  # the same figure gives the same file
    "pdf.fonttype": 42,  # TrueType, embedded: journals refuse matplotlib's Type 3
}

LINES = {
    "measured": Line2D([], [], color=MEASURED, linewidth=1.0),
    "desired": Line2D([], [], color=DESIRED, linestyle="--", linewidth=1.0),
    "with optimal springs": Line2D([], [], color=OPTIMAL, linestyle="--", linewidth=1.0),
    "without springs": Line2D([], [], color=MUTED, linestyle=":", linewidth=1.0),
}
"""What lines mean in every figure."""


def logarithmic(ax: Axes) -> None:
    """A logarithmic ordinate whose ticks are plain numbers, two at least."""
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    near = high / low < 400  # decades alone would leave an axis without numbers
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if near else (1.0,), numticks=7))
    ax.yaxis.set_major_formatter(FuncFormatter(_number))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_minor_formatter(NullFormatter())


def like(line: Line2D) -> dict[str, Any]:
    """Colour, dashes and width of a line in a legend, to draw what it means."""
    return {
        "color": line.get_color(),
        "linestyle": line.get_linestyle(),
        "linewidth": line.get_linewidth(),
    }


def abscissa(ax: Axes) -> None:
    """An abscissa whose ticks are written in full, as many as do not touch."""
    low, high = ax.get_xlim()
    scale = breadth(ax) / (high - low)  # inches per unit
    for nbins in (6, 5, 4, 3, 2, 1):
        placed = MaxNLocator(nbins=nbins).tick_values(low, high)
        ticks = [float(tick) for tick in placed if low <= tick <= high]
        widest = max((width_of(_number(tick), SMALL) for tick in ticks), default=0.0)
        if len(ticks) < 2 or (ticks[1] - ticks[0]) * scale > widest + 0.08:
            break
    # The last number must not stand out of the figure.
    ticks = [
        tick for tick in ticks if (high - tick) * scale + 0.1 > width_of(_number(tick), SMALL) / 2
    ]
    ax.set_xticks(ticks, [_number(tick) for tick in ticks])


def breadth(ax: Axes) -> float:
    """Width of axes [in]."""
    figure = ax.get_figure()
    assert isinstance(figure, Figure)
    return float(figure.get_size_inches()[0] * ax.get_position().width)


def plain(ax: Axes, nbins: int = 4) -> None:
    """An ordinate whose ticks are written in full: a common factor would stand in the title."""
    ax.yaxis.set_major_locator(MaxNLocator(nbins=nbins))
    ax.yaxis.set_major_formatter(FuncFormatter(_number))


def _number(value: float, _: object = None) -> str:
    return f"{value:.6g}".replace("e-0", "e-").replace("-", "−")


def counted(ax: Axes, what: str = "cycle") -> None:
    """An abscissa that counts."""
    ax.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=[1, 2, 5, 10], integer=True))
    ax.set_xlabel(what)
