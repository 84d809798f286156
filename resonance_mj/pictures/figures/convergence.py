"""Several runs in one figure: how fast each comes to its own optimum, and onto its path."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...results.metrics import OPTIMUM_BAND
from ...results.run import Run, Status
from ...text import told_apart
from . import cycle_axis
from .sheet import Row, Sheet
from .style import BAND, LINES, Line, one_of
from .ticks import counted, logarithmic


def draw(runs: Sequence[Run], width: float) -> Figure:
    """Torque² as a multiple of each run's own optimum, and the tool's errors, of each cycle."""
    lines = [one_of(i) for i in range(len(runs))]
    rows = [Row(1.7), *[Row(1.3)] * len(cycle_axis.errors(runs))]
    legend = dict(zip(_labels(runs), lines, strict=True))
    sheet = Sheet(width, rows, heading=f"Convergence of {len(runs)} runs", legend=legend)
    torque, *_ = panels(sheet, runs, lines)
    torque.axhspan(1 - OPTIMUM_BAND, 1 + OPTIMUM_BAND, **BAND, linewidth=0)
    torque.axhline(1.0, **LINES["with optimal springs"])
    for ax in sheet.figure.axes:
        logarithmic(ax)
        _changes(ax, runs)
    return sheet.figure


def panels(sheet: Sheet, runs: Sequence[Run], lines: Sequence[Line]) -> list[Axes]:
    """Panels of torque² as a multiple of the optimum's and of errors, a line for each run."""
    torque = sheet.panel(
        0,
        0,
        "mean of τᵀτ per cycle, as a multiple of the optimum's [1]",
        "mean of τᵀτ / that of the optimum [1]",
    )
    shown = [(torque, [cycle_axis.ratio(run) for run in runs])]
    for row, (title, values) in enumerate(cycle_axis.errors(runs).items(), start=1):
        shown.append((sheet.panel(row, 0, title), values))
    for ax, values in shown:
        for run, each, line in zip(runs, values, lines, strict=True):
            cycle_axis.curve(ax, run, each, **line)
    return [ax for ax, _ in shown]


def _labels(runs: Sequence[Run]) -> list[str]:
    """The runs told apart, and why one ends early or is not there."""
    names = told_apart(
        [run.experiment.name for run in runs], [run.experiment.model_dump() for run in runs]
    )
    for i, run in enumerate(runs):
        if run.status is Status.DIVERGED:
            names[i] += " (diverged)"
        if np.isnan(cycle_axis.ratio(run)).all():
            names[i] += " (its optimum is 0)"
    return names


def _changes(ax: Axes, runs: Sequence[Run]) -> None:
    """Mark the changes of motion if all runs have them in common."""
    cycles = {tuple(motion.cycles for motion in run.experiment.motion) for run in runs}
    if len(cycles) == 1:
        cycle_axis.motions(ax, runs[0].experiment)
        return
    ax.set_xlim(0.5, max(run.data.sizes["cycle"] for run in runs) + 0.5)
    counted(ax)
