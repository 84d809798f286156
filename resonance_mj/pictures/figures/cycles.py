"""Torque² beside its bounds and the tracking error, cycle by cycle."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...results.metrics import OPTIMUM_BAND, cycles_to_optimum
from ...results.run import Run
from ..palette import MEASURED, OPTIMAL
from . import cycle_axis
from .naming import heading, letters, torque_squared_unit
from .sheet import Row, Sheet
from .sizes import PAGE
from .style import LINES, STYLE, logarithmic

LEGEND = {
    **{name: line for name, line in LINES.items() if name != "desired"},
    f"within {OPTIMUM_BAND:.0%} of the optimum": Line2D(
        [], [], color=OPTIMAL, alpha=0.2, linewidth=5
    ),
    "within it from here on": Line2D([], [], color=OPTIMAL, marker="D", mfc="white", ms=4, ls=""),
}


def draw(runs: Sequence[Run], width: float = PAGE) -> Figure:
    """Torque² with the optimum's and that without springs, and tracking RMS, of each cycle.

    Args:
        runs: one run with at least one whole cycle.
        width: of the figure [in].
    """
    (run,) = runs
    errors = {"tracking RMS of the tool's position [mm]": 1e3 * run.data["tracking_rms"].values}
    if "rotation_rms" in run.data:
        errors["tracking RMS of the tool's rotation [rad]"] = run.data["rotation_rms"].values
    with matplotlib.rc_context(STYLE):
        rows = [Row(1.7), *[Row(1.1)] * len(errors)]
        sheet = Sheet(width, rows, 1, heading=heading(run), legend=LEGEND)
        names = letters()
        torque = sheet.panel(0)
        sheet.title(
            torque, f"({next(names)}) mean of τᵀτ per cycle [{torque_squared_unit(run.data)}]"
        )
        cycle_axis.torque_squared(torque, run)
        cycle_axis.motions(torque, run.experiment)
        cycle_axis.reductions(torque, run.data)
        _band(torque, run)
        for row, (title, values) in enumerate(errors.items(), start=1):
            ax = sheet.panel(row)
            sheet.title(ax, f"({next(names)}) {title}")
            cycle_axis.curve(ax, run, values, color=MEASURED)
            logarithmic(ax)
            cycle_axis.motions(ax, run.experiment, named=True)
    return sheet.figure


def _band(ax: Axes, run: Run) -> None:
    """What counts as at the optimum, and from which cycle on the run is there to stay."""
    for mine, one in cycle_axis.of_motions(run.data):
        optimal = float(one["torque_squared_optimal"])
        ends = (mine[0] - 0.5, mine[-1] + 0.5)
        low, high = (1 - OPTIMUM_BAND) * optimal, (1 + OPTIMUM_BAND) * optimal
        ax.fill_between(ends, low, high, color=OPTIMAL, alpha=0.2, linewidth=0)
        squared = run.data["torque_squared"].sel(cycle=mine).values
        first = cycles_to_optimum(squared, optimal)
        if first is not None:
            at = mine[first - 1], squared[first - 1]
            ax.plot(*at, "D", color=OPTIMAL, markerfacecolor="white", ms=4)
