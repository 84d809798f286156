"""The figure of a comparison: torque² and tracking of every law per cycle, and in the long run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from ...evaluation.comparison.comparison import Comparison
from ...results.run import Run, Status
from ..palette import DESIRED, EARLY, MEASURED, MUTED, OPTIMAL, SERIES
from . import cycle_axis
from .sheet import Row, Sheet
from .sizes import PAGE
from .style import SMALL, STYLE, logarithmic

LEGEND = 1.75
"""Width of the legend beside the panels [in]."""

# Hues of Okabe and Ito, one for each family of laws; within a family the dashes differ.
LINES: dict[str, tuple[str, Any, float]] = {
    "feedback": (MUTED, ":", 0.9),
    "learning": (MUTED, "--", 0.9),
    "fixed": (EARLY, "-", 1.1),
    "joint-space": (SERIES[2], "-", 1.1),
    "printed": (OPTIMAL, "-", 1.1),
    "printed-transpose": (OPTIMAL, ":", 1.1),
    "printed-lead": (OPTIMAL, "--", 1.1),
    "transfer": (MEASURED, "-", 1.8),
    "computed-torque": (DESIRED, (0, (4, 3)), 0.9),
    "own": (SERIES[1], "-", 1.8),
}
"""Colour, dashes and width of each law's line."""


def figure(comparison: Comparison, width: float = PAGE) -> Figure:
    """Torque² per cycle as a multiple of the optimum's, tracking RMS, and the long run.

    Args:
        comparison: of runs with at least one whole cycle.
        width: of the figure [in].
    """
    experiment, long = comparison.experiment, comparison.long
    with matplotlib.rc_context(STYLE):
        sheet = Sheet(
            width,
            [Row(1.7)] * (3 if long else 2),
            1,
            heading=f"{experiment.name}: the same motions under {len(comparison.runs)} laws",
            right=LEGEND,
        )
        torque, tracking = sheet.panel(0), sheet.panel(1)
        sheet.title(torque, "(a) mean of τᵀτ per cycle, as a multiple of the optimum's [1]")
        sheet.title(tracking, "(b) tracking RMS of the tool's position [mm]")
        for name, run in comparison.runs.items():
            cycle_axis.curve(torque, run, cycle_axis.ratio(run), marker="", **_style(name))
            errors = 1e3 * run.data["tracking_rms"].values
            cycle_axis.curve(tracking, run, errors, marker="", **_style(name))
        for ax in (torque, tracking):
            cycle_axis.motions(ax, experiment, named=True)
        torque.axhline(1.0, color=DESIRED, linewidth=0.6)
        if long:
            lasting = sheet.panel(2)
            sheet.title(
                lasting,
                "(c) the last motion repeated: as (a) [1]; a cross where a law diverged",
                "(c) the last motion repeated [1]",
            )
            _long_runs(lasting, long)
        for ax in sheet.figure.axes:
            logarithmic(ax)
        _legend(sheet.figure, comparison, 1 - (LEGEND - 0.12) / width)
    return sheet.figure


def _long_runs(ax: Axes, long: Mapping[str, Run]) -> None:
    """Torque² of the last motion, repeated, as a multiple of the optimum's."""
    for name, run in long.items():
        mine = (run.data["segment_of_cycle"] == run.data["segment"].values[-1]).values
        values = cycle_axis.ratio(run)[mine]
        ax.plot(np.arange(1, len(values) + 1), values, **_style(name))
        if run.status is Status.DIVERGED and len(values):
            ax.plot(len(values), values[-1], "x", color=LINES[name][0], ms=6, mew=1.5)
    ax.axhline(1.0, color=DESIRED, linewidth=0.6)
    ax.set_xscale("log")
    ax.set_xlim(left=1)
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.set_xlabel("cycle of the last motion")


def _style(name: str) -> dict[str, Any]:
    colour, dashes, width = LINES[name]
    return {"color": colour, "linestyle": dashes, "linewidth": width}


def _legend(drawn: Figure, comparison: Comparison, left: float) -> None:
    """Every law, and below its name what became of it in the long run."""
    labels = []
    for name, title in comparison.titles.items():
        verdict = comparison.verdict(name)
        labels.append(title + (f"\n{verdict}" if verdict else ""))
    drawn.legend(
        [Line2D([], [], **_style(name)) for name in comparison.titles],
        labels,
        loc="upper left",
        bbox_to_anchor=(left, drawn.axes[0].get_position().y1),
        title="law, and its long run" if comparison.long else "law",
        title_fontsize=SMALL,
        alignment="left",
        handlelength=3.0,
        labelspacing=0.8,
        borderaxespad=0.0,
        borderpad=0.0,
    )
