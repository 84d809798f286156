"""The figure of a comparison: torque² and tracking of every law per cycle, and in the long run."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from ..comparison.comparison import Comparison
from ..palette import MUTED
from ..results.run import Status
from . import cycle_axis
from .style import STYLE

# Hues of Okabe and Ito, one for each family of laws; within a family the dashes differ.
LINES: dict[str, tuple[str, Any, float]] = {
    "feedback": ("#7F7F7F", ":", 1.2),
    "learning": ("#7F7F7F", "--", 1.2),
    "fixed": ("#56B4E9", "-", 1.4),
    "joint-space": ("#CC79A7", "-", 1.4),
    "printed": ("#D55E00", "-", 1.4),
    "printed-transpose": ("#D55E00", ":", 1.4),
    "printed-lead": ("#D55E00", "--", 1.4),
    "transfer": ("#0072B2", "-", 2.2),
    "computed-torque": ("#000000", (0, (4, 3)), 1.2),
    "own": ("#009E73", "-", 2.2),
}
"""Colour, dashes and width of each law's line."""


def figure(comparison: Comparison) -> Figure:
    """Torque² per cycle as a multiple of the optimum's, tracking RMS, and the long run.

    Args:
        comparison: of runs with at least one whole cycle.
    """
    with matplotlib.rc_context(STYLE):
        return _draw(comparison)


def _draw(comparison: Comparison) -> Figure:
    long = bool(comparison.long)
    width, height = 11.0, 8.4 if long else 6.2
    drawn = Figure(figsize=(width, height))
    grid = GridSpec(
        3 if long else 2,
        1,
        figure=drawn,
        left=0.62 / width,
        right=1 - 3.25 / width,
        bottom=0.5 / height,
        top=1 - 0.75 / height,
        hspace=0.38,
    )
    torque, tracking = (drawn.add_subplot(grid[row]) for row in (0, 1))
    torque.set_title("(a) mean of τᵀτ per cycle, as a multiple of the optimum's")
    tracking.set_title("(b) tracking RMS per cycle [mm]")
    for name, run in comparison.runs.items():
        cycles = run.data["cycle"].values
        _line(torque, name, cycles, cycle_axis.ratio(run))
        _line(tracking, name, cycles, 1e3 * run.data["tracking_rms"].values)
    for ax in (torque, tracking):
        _motions(ax, comparison)
    torque.axhline(1.0, color="#000000", linewidth=0.6)
    if long:
        lasting = drawn.add_subplot(grid[2])
        lasting.set_title(
            "(c) the last motion repeated: mean of τᵀτ, as a multiple of the optimum's (× diverged)"
        )
        for name, run in comparison.long.items():
            mine = (run.data["segment_of_cycle"] == run.data["segment"].values[-1]).values
            values = cycle_axis.ratio(run)[mine]
            _line(lasting, name, np.arange(1, len(values) + 1), values)
            if run.status is Status.DIVERGED and len(values):
                lasting.plot(len(values), values[-1], "x", color=LINES[name][0], ms=7, mew=1.6)
        lasting.axhline(1.0, color="#000000", linewidth=0.6)
        lasting.set_xscale("log")
        lasting.set_xlim(left=1)
        lasting.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        lasting.set_xlabel("cycle of the last motion", labelpad=1)
    tracking.set_xlabel("cycle", labelpad=1)
    for ax in drawn.axes:
        ax.set_yscale("log")
        ax.yaxis.set_major_locator(LogLocator(numticks=6))
        ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        ax.yaxis.set_minor_locator(NullLocator())
    _legend(drawn, comparison, 1 - 3.1 / width, 1 - 0.72 / height)
    drawn.suptitle(
        f"{comparison.experiment.name}: the same motions under {len(comparison.runs)} laws",
        x=0.62 / width,
        y=1 - 0.16 / height,
        ha="left",
        va="top",
        fontsize=11,
    )
    return drawn


def _line(ax: Axes, name: str, cycles: np.ndarray, values: np.ndarray) -> None:
    colour, dashes, width = LINES[name]
    ax.plot(cycles, values, color=colour, linestyle=dashes, linewidth=width)


def _motions(ax: Axes, comparison: Comparison) -> None:
    """Say which cycles belong to which motion."""
    first = 0
    motions = comparison.experiment.motion
    for number, motion in enumerate(motions, start=1):
        if first:
            ax.axvline(first + 0.5, color=MUTED, linewidth=0.8)
        ax.annotate(
            f"motion {number}",
            (first + 0.5 + motion.cycles / 2, 0.98),
            xycoords=("data", "axes fraction"),
            ha="center",
            va="top",
            color=MUTED,
        )
        first += motion.cycles
    ax.set_xlim(0.5, first + 0.5)


def _legend(drawn: Figure, comparison: Comparison, left: float, top: float) -> None:
    """Every law, and below its name what became of it in the long run."""
    handles, labels = [], []
    for name, title in comparison.titles.items():
        colour, dashes, width = LINES[name]
        handles.append(Line2D([], [], color=colour, linestyle=dashes, linewidth=width))
        verdict = comparison.verdict(name)
        labels.append(title + (f"\n{verdict}" if verdict else ""))
    drawn.legend(
        handles,
        labels,
        loc="upper left",
        bbox_to_anchor=(left, top),
        title="law, and its long run" if comparison.long else "law",
        alignment="left",
        handlelength=3.2,
        labelspacing=0.9,
        borderaxespad=0.0,
    )
