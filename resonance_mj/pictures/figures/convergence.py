"""Several runs in one figure: how fast each comes to its own optimum, and onto its path."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...results.metrics import OPTIMUM_BAND
from ...results.run import Run, Status
from ...text import told_apart
from . import cycles
from .sheet import Row, Sheet
from .style import BAND, LINES, Line, if_titled, one_of
from .ticks import counted, logarithmic


def draw(runs: Sequence[Run], width: float) -> Figure:
    """Torque² as a multiple of each run's own optimum, and the tool's errors, of each cycle."""
    lines = [one_of(i) for i in range(len(runs))]
    names = told_apart(
        [run.experiment.name for run in runs], [run.experiment.model_dump() for run in runs]
    )
    for i, run in enumerate(runs):
        if run.status is Status.DIVERGED:
            names[i] += " (diverged)"
        if np.isnan(cycles.ratio(run)).all():
            names[i] += " (its optimum is 0)"
    sheet = Sheet(
        width,
        [Row(1.7), *[Row(1.3)] * len(cycles.errors(runs))],
        heading=if_titled(f"Convergence of {len(runs)} runs"),
        legend=dict(zip(names, lines, strict=True)),
    )
    torque, *_ = panels(sheet, runs, lines)
    torque.axhspan(1 - OPTIMUM_BAND, 1 + OPTIMUM_BAND, **BAND, linewidth=0)
    torque.axhline(1.0, **LINES["with optimal springs"])
    alike = len({tuple(motion.cycles for motion in run.experiment.motion) for run in runs}) == 1
    for ax in sheet.figure.axes:
        logarithmic(ax)
        if alike:
            cycles.motions(ax, runs[0].experiment)
        else:
            ax.set_xlim(0.5, max(run.data.sizes["cycle"] for run in runs) + 0.5)
            counted(ax)
    return sheet.figure


def panels(sheet: Sheet, runs: Sequence[Run], lines: Sequence[Line]) -> list[Axes]:
    """Panels of torque² as a multiple of the optimum's and of errors, a line for each run."""
    kinds = {run.experiment.springs.cost: run.cost.name for run in runs}
    what = "mean of τᵀτ" if [*kinds] == ["torque-squared"] else " or ".join(kinds.values())
    full = f"{what} per cycle, as a multiple of the optimum's [1]"
    short = f"{what} / that of the optimum [1]"
    shown = {full: [cycles.ratio(run) for run in runs], **cycles.errors(runs)}
    axes = []
    for row, (title, values) in enumerate(shown.items()):
        axes.append(sheet.panel(row, 0, title, title if row else short))
        for run, each, line in zip(runs, values, lines, strict=True):
            cycles.curve(axes[-1], run, each, **line)
    return axes
