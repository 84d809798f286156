"""Torque² beside its bounds and the tool's errors, cycle by cycle: the figure, and its panels."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...experiments.experiment import Experiment
from ...results.metrics import LEAST_REDUCTION, OPTIMUM_BAND
from ...results.run import Run, Status
from ..palette import DESIRED, MUTED, OPTIMAL
from .sheet import Row, Sheet, fitting, heading
from .style import BAND, LABEL_BOX, LINES, Line, remark, small
from .ticks import breadth, counted, logarithmic
from .time_axes import Piece, timed

REACHED: Line = {"color": OPTIMAL, "marker": "D", "mfc": "white", "ms": 4, "linestyle": ""}
LEGEND: dict[str, Line] = {
    **{name: line for name, line in LINES.items() if name != "desired"},
    f"within {OPTIMUM_BAND:.0%} of the optimum": {**BAND, "linewidth": 5},
    "within it from here on": REACHED,
}


def draw(run: Run, width: float) -> Figure:
    """Torque² with the optimum's and that without springs, and tracking RMS, of each cycle."""
    found = errors([run])
    sheet = Sheet(width, [Row(1.7), *[Row(1.1)] * len(found)], heading=heading(run), legend=LEGEND)
    torque = cost(sheet, 0, run)
    for motion in run.motions:
        best, first = motion.cost_optimal, motion.cycles_to_optimum
        if motion.cycles.size and best > 0:
            ends = motion.cycles[0] - 0.5, motion.cycles[-1] + 0.5
            low, high = (1 - OPTIMUM_BAND) * best, (1 + OPTIMUM_BAND) * best
            torque.fill_between(ends, low, high, **BAND, linewidth=0)
        if first is not None:
            torque.plot(motion.cycles[first - 1], motion.cost[first - 1], **REACHED)
    for row, (title, (values,)) in enumerate(found.items(), start=1):
        ax = sheet.panel(row, 0, title)
        curve(ax, run, values, **LINES["measured"])
        logarithmic(ax)
        motions(ax, run.experiment, named=True)
    return sheet.figure


def motions(ax: Axes, experiment: Experiment, *, named: bool = False) -> None:
    """Mark which cycles belong to which motion, and in grey those of the passage into it.

    The abscissa is set to all cycles of the experiment; `named` writes the motions' numbers at
    the top.
    """
    first, begin, pieces = 0, 0.0, []
    for number, motion in enumerate(experiment.motion, start=1):
        if first:
            ax.axvline(first + 0.5, color=MUTED, linewidth=0.8)
        if motion.passage:
            ax.axvspan(
                first + 0.5, first + motion.passage + 0.5, color="0.93", linewidth=0, zorder=0
            )
        if named:
            middle, across = (first + 0.5 + motion.cycles / 2, 0.98), ("data", "axes fraction")
            remark(ax, f"motion {number}", middle, xycoords=across, ha="center", va="top")
        ends = first + 0.5, first + motion.cycles + 0.5
        pieces.append(Piece(begin, begin + motion.duration, *ends))
        first, begin = first + motion.cycles, begin + motion.duration
    ax.set_xlim(0.5, first + 0.5)
    timed(ax, pieces)
    counted(ax)


def curve(
    ax: Axes, run: Run, values: np.ndarray, cycles: np.ndarray | None = None, **style: Any
) -> None:
    """Draw a value of each whole cycle (cycles,); a cross marks where the run diverged."""
    cycles = run.data["cycle"].values if cycles is None else cycles
    (line,) = ax.plot(cycles, values, **{"marker": ".", "ms": 3.5, **style})
    if run.status is Status.DIVERGED:
        ax.plot(cycles[-1:], values[-1:], "x", color=line.get_color(), ms=6, mew=1.5)


def errors(runs: Sequence[Run]) -> dict[str, list[np.ndarray]]:
    """The tool's errors by their panels' titles, each run's (cycles,); NaN for one without."""
    found = {}
    for title, name, scale in (
        ("tracking RMS of the tool's position [mm]", "tracking_rms", 1e3),
        ("tracking RMS of the tool's rotation [rad]", "rotation_rms", 1.0),
        ("tracking RMS of the joints [rad]", "joint_rms", 1.0),
    ):
        if any(name in run.data for run in runs):
            found[title] = [
                scale * run.data.get(name, np.nan * run.data["tracking_rms"]).values for run in runs
            ]
    return found


def ratio(run: Run) -> np.ndarray:
    """Cost of each cycle as a multiple of the optimum's (cycles,); NaN where that is 0."""
    best = np.array([motion.cost_optimal for motion in run.motions])
    best = best[run.data["segment_of_cycle"].values - 1]
    return np.concatenate([one.cost for one in run.motions]) / np.where(best > 0, best, np.nan)


def cost(sheet: Sheet, row: int, run: Run, span: int = 1) -> Axes:
    """A panel of each cycle's cost, with the optimum's and that without springs of each motion.

    At the line without springs stands by how much less each motion ended.
    """
    slides = run.data["slides"].values.astype(bool)
    # The terms of the sum differ in unit from joint to joint.
    unit = "N²" if slides.all() else "N² m² + N²" if slides.any() else "N² m²"
    title = f"mean of τᵀτ per cycle [{unit}]"
    if run.experiment.springs.cost != "torque-squared":
        title = f"{run.cost.name} per cycle [{run.cost.unit}]"
    ax = sheet.panel(row, 0, title, span=span)
    for motion in run.motions:
        if motion.cycles.size:
            ends = motion.cycles[0] - 0.5, motion.cycles[-1] + 0.5
            without, best = motion.cost_without_springs, motion.cost_optimal
            ax.hlines(without, *ends, **LINES["without springs"])
            if best > LEAST_REDUCTION * without:  # the rounding of none at all has no height
                ax.hlines(best, *ends, **LINES["with optimal springs"])
    values = np.concatenate([motion.cost for motion in run.motions])
    curve(ax, run, values, **LINES["measured"])
    logarithmic(ax)
    if ax.get_yscale() == "log":
        low, high = ax.get_ylim()
        ax.set_ylim(low, high * (high / low) ** 0.15)  # room for words at the line without springs
    motions(ax, run.experiment)
    _reductions(ax, run)
    return ax


def _reductions(ax: Axes, run: Run) -> None:
    width = breadth(ax) / (ax.get_xlim()[1] - ax.get_xlim()[0])
    for motion in run.motions:
        if not motion.cycles.size:
            continue
        share, best = float(motion.reduction[-1]), motion.reduction_optimal
        of = f"optimum {best:.1%} less" if best > LEAST_REDUCTION else "no spring helps"
        if not motion.tracks[-1]:
            wordings = [motion.off, "off path"]
        elif np.isnan(share):
            wordings = ["needs no torque without springs", "needs no torque"]
        elif share < 0:
            wordings = [f"{1 - share:.3g} times that without springs ({of})", f"{1 - share:.3g} ×"]
        else:
            wordings = [
                f"{share:.1%} less than without springs ({of})",
                f"{share:.1%} less ({of.replace('optimum', 'of').removesuffix(' less')})",
                f"{share:.1%}",
            ]
        height = motion.cost_without_springs or ax.get_ylim()[0]
        remark(
            ax,
            fitting(wordings, small(), width * motion.cycles.size - 0.06),
            (motion.cycles[-1] + 0.5, height),
            **{"xycoords": "data", "xytext": (-2, 3), "textcoords": "offset points"},
            **{"ha": "right", "color": DESIRED, "bbox": LABEL_BOX},
        )
