"""Several runs in one figure: how fast each comes to its own optimum, and onto its path."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...results.metrics import OPTIMUM_BAND
from ...results.run import Run, Status
from ..palette import MUTED, OPTIMAL, SERIES
from . import cycle_axis
from .naming import labels
from .sheet import Row, Sheet
from .sizes import PAGE
from .style import STYLE, counted, like, logarithmic

DASHES: tuple[Any, ...] = ("-", "--", ":", "-.")
"""Of the first runs, of those whose colours come again, and so on."""


def draw(runs: Sequence[Run], width: float = PAGE) -> Figure:
    """Torque² as a multiple of each run's own optimum, and tracking RMS, of each cycle.

    Args:
        runs: with at least one whole cycle each.
        width: of the figure [in].
    """
    names = [
        name + (" (diverged)" if run.status is Status.DIVERGED else "")
        for name, run in zip(labels(runs), runs, strict=True)
    ]
    n = len(SERIES)
    lines = [
        Line2D([], [], color=SERIES[i % n], linestyle=DASHES[i // n % len(DASHES)], linewidth=1.0)
        for i in range(len(runs))
    ]
    errors = [("tracking RMS of the tool's position [mm]", "tracking_rms", 1e3)]
    if any("rotation_rms" in run.data for run in runs):
        errors.append(("tracking RMS of the tool's rotation [rad]", "rotation_rms", 1.0))
    with matplotlib.rc_context(STYLE):
        rows = [Row(1.7), *[Row(1.3)] * len(errors)]
        legend = dict(zip(names, lines, strict=True))
        sheet = Sheet(width, rows, 1, heading=f"Convergence of {len(runs)} runs", legend=legend)
        torque = sheet.panel(0)
        sheet.title(
            torque,
            "(a) mean of τᵀτ per cycle, as a multiple of the optimum's [1]",
            "(a) mean of τᵀτ / that of the optimum [1]",
        )
        for run, line in zip(runs, lines, strict=True):
            cycle_axis.curve(torque, run, cycle_axis.ratio(run), **like(line))
        torque.axhspan(1 - OPTIMUM_BAND, 1 + OPTIMUM_BAND, color=OPTIMAL, alpha=0.2, linewidth=0)
        torque.axhline(1.0, color=OPTIMAL, linestyle="--")
        for row, (title, name, scale) in enumerate(errors, start=1):
            ax = sheet.panel(row)
            sheet.title(ax, f"({'abc'[row]}) {title}")
            for run, line in zip(runs, lines, strict=True):
                if name in run.data:
                    cycle_axis.curve(ax, run, scale * run.data[name].values, **like(line))
        for ax in sheet.figure.axes:
            logarithmic(ax)
            _changes(ax, runs)
    return sheet.figure


def _changes(ax: Axes, runs: Sequence[Run]) -> None:
    """Mark the changes of motion if all runs have them in common."""
    cycles = {tuple(motion.cycles for motion in run.experiment.motion) for run in runs}
    if len(cycles) == 1:
        cycle_axis.motions(ax, runs[0].experiment)
        return
    ax.set_xlim(0.5, max(int(run.data["cycle"].values[-1]) for run in runs) + 0.5)
    counted(ax)
    low, high = ax.get_ylim()
    for run in runs:
        changes = [mine[0] for mine, _ in cycle_axis.of_motions(run.data)][1:]
        ax.vlines([at - 0.5 for at in changes], low, high, color=MUTED, linewidth=0.5)
    ax.set_ylim(low, high)
