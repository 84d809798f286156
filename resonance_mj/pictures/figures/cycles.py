"""Torque² beside its bounds and the tracking error, cycle by cycle."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...results.metrics import OPTIMUM_BAND
from ...results.run import Run
from ..palette import OPTIMAL
from . import cycle_axis
from .sheet import Row, Sheet, heading
from .style import BAND, LINES, Line
from .ticks import logarithmic

REACHED: Line = {"color": OPTIMAL, "marker": "D", "mfc": "white", "ms": 4, "linestyle": ""}
LEGEND: dict[str, Line] = {
    **{name: line for name, line in LINES.items() if name != "desired"},
    f"within {OPTIMUM_BAND:.0%} of the optimum": {**BAND, "linewidth": 5},
    "within it from here on": REACHED,
}


def draw(run: Run, width: float) -> Figure:
    """Torque² with the optimum's and that without springs, and tracking RMS, of each cycle."""
    errors = cycle_axis.errors([run])
    rows = [Row(1.7), *[Row(1.1)] * len(errors)]
    sheet = Sheet(width, rows, heading=heading(run), legend=LEGEND)
    torque = sheet.panel(0, 0, cycle_axis.torque_squared_title(run))
    cycle_axis.torque_squared(torque, run)
    _optimum(torque, run)
    for row, (title, (values,)) in enumerate(errors.items(), start=1):
        ax = sheet.panel(row, 0, title)
        cycle_axis.curve(ax, run, values, **LINES["measured"])
        logarithmic(ax)
        cycle_axis.motions(ax, run.experiment, named=True)
    return sheet.figure


def _optimum(ax: Axes, run: Run) -> None:
    """What counts as at the optimum, and from which cycle on the run is there to stay."""
    for motion in run.motions:
        best, first = motion.torque_squared_optimal, motion.cycles_to_optimum
        if motion.cycles.size and best > 0:
            ends = motion.cycles[0] - 0.5, motion.cycles[-1] + 0.5
            low, high = (1 - OPTIMUM_BAND) * best, (1 + OPTIMUM_BAND) * best
            ax.fill_between(ends, low, high, **BAND, linewidth=0)
        if first is not None:
            ax.plot(motion.cycles[first - 1], motion.torque_squared[first - 1], **REACHED)
