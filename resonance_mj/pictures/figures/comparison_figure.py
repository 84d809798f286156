"""The figure of a comparison: torque² and tracking of every law per cycle, and in the long run."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...evaluation.comparison import Comparison
from ..palette import DESIRED, EARLY, MEASURED, MUTED, OPTIMAL, SERIES
from . import convergence, cycles
from .asked import PAGE
from .sheet import Row, Sheet
from .style import if_titled, small, styled
from .ticks import logarithmic

LEGEND = 1.75
"""Width of the legend beside the panels [in]."""


def _line(color: str, linestyle: Any, linewidth: float) -> dict[str, Any]:
    return {"color": color, "linestyle": linestyle, "linewidth": linewidth, "marker": ""}


# Hues of Okabe and Ito, one for each family of laws; within a family the dashes differ.
LINES = {
    "feedback": _line(MUTED, ":", 0.9),
    "learning": _line(MUTED, "--", 0.9),
    "fixed": _line(EARLY, "-", 1.1),
    "joint-space": _line(SERIES[2], "-", 1.1),
    "printed": _line(OPTIMAL, "-", 1.1),
    "printed-transpose": _line(OPTIMAL, ":", 1.1),
    "printed-lead": _line(OPTIMAL, "--", 1.1),
    "transfer": _line(MEASURED, "-", 1.8),
    "computed-torque": _line(DESIRED, (0, (4, 3)), 0.9),
    "own": _line(SERIES[1], "-", 1.8),
}
"""Of each law."""


@styled()
def figure(comparison: Comparison) -> Figure:
    """Torque² per cycle as a multiple of the optimum's, the tool's errors, and the long run.

    Args:
        comparison: of runs with at least one whole cycle.
    """
    runs, long = [*comparison.runs.values()], comparison.long
    over_cycles = 1 + len(cycles.errors(runs))
    sheet = Sheet(
        PAGE,
        [Row(1.7)] * (over_cycles + bool(long)),
        heading=if_titled(f"{comparison.experiment.name}: the same motions, {len(runs)} laws"),
        right=LEGEND,
    )
    axes = convergence.panels(sheet, runs, [LINES[law] for law in comparison.runs])
    for ax in axes:
        cycles.motions(ax, comparison.experiment, named=True)
    axes[0].axhline(1.0, color=DESIRED, linewidth=0.6)
    if long:
        title = "the last motion repeated"
        full = f"{title}: as (a) [1]; a cross where a law diverged"
        ax = sheet.panel(over_cycles, 0, full, f"{title} [1]")
        for law, run in long.items():
            values = cycles.ratio(run)[run.data["segment_of_cycle"] == run.motions[-1].number]
            cycles.curve(ax, run, values, np.arange(1, len(values) + 1), **LINES[law])
        ax.axhline(1.0, color=DESIRED, linewidth=0.6)
        ax.set(xscale="log", xlabel="cycle of the last motion")
        ax.set_xlim(left=1)
        ax.xaxis.set_major_formatter("{x:g}")
    for ax in sheet.figure.axes:
        logarithmic(ax)
    # Every law, and below its name what became of it in the long run.
    sheet.figure.legend(
        [Line2D([], [], **LINES[law]) for law in comparison.titles],
        [
            f"{title}\n{comparison.verdict(law) or ''}".rstrip()
            for law, title in comparison.titles.items()
        ],
        loc="upper left",
        bbox_to_anchor=(1 - (LEGEND - 0.12) / PAGE, axes[0].get_position().y1),
        title="law, and its long run" if long else "law",
        title_fontsize=small(),
        alignment="left",
        handlelength=3.0,
        labelspacing=0.8,
    )
    return sheet.figure
