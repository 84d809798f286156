"""Panels over the cycles of a run: where its motions change, torque² beside its bounds, errors."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ...experiments.experiment import Experiment
from ...results.metrics import LEAST_REDUCTION
from ...results.run import Run, Status
from ...text import length
from ..palette import DESIRED, MUTED
from .measuring import fitting
from .style import LABEL_BOX, LINES, SMALL, remark
from .ticks import breadth, counted, logarithmic


def motions(ax: Axes, experiment: Experiment, *, named: bool = False) -> None:
    """Mark which cycles belong to which motion, and in grey those of the passage into it.

    The abscissa is set to all cycles of the experiment; `named` writes the motions' numbers at
    the top.
    """
    first = 0
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
        first += motion.cycles
    ax.set_xlim(0.5, first + 0.5)
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
    ):
        if any(name in run.data for run in runs):
            found[title] = [
                scale * run.data.get(name, np.nan * run.data["tracking_rms"]).values for run in runs
            ]
    return found


def torque_squared_title(run: Run) -> str:
    """Of the panel `torque_squared`, with the unit, whose terms differ from joint to joint."""
    slides = run.data["slides"].values.astype(bool)
    unit = "N²" if slides.all() else "N² m² + N²" if slides.any() else "N² m²"
    return f"mean of τᵀτ per cycle [{unit}]"


def torque_squared(ax: Axes, run: Run) -> None:
    """Torque² of each cycle, with the optimum's and that without springs of each motion.

    At the line without springs stands by how much less each motion ended.
    """
    for motion in run.motions:
        if motion.cycles.size:
            ends = motion.cycles[0] - 0.5, motion.cycles[-1] + 0.5
            without, best = motion.torque_squared_without_springs, motion.torque_squared_optimal
            ax.hlines(without, *ends, **LINES["without springs"])
            if best > LEAST_REDUCTION * without:  # the rounding of none at all has no height
                ax.hlines(best, *ends, **LINES["with optimal springs"])
    curve(ax, run, run.data["torque_squared"].values, **LINES["measured"])
    logarithmic(ax)
    if ax.get_yscale() == "log":
        low, high = ax.get_ylim()
        ax.set_ylim(low, high * (high / low) ** 0.15)  # room for words at the line without springs
    motions(ax, run.experiment)
    _reductions(ax, run)


def _reductions(ax: Axes, run: Run) -> None:
    width = breadth(ax) / (ax.get_xlim()[1] - ax.get_xlim()[0])
    for motion in run.motions:
        if not motion.cycles.size:
            continue
        share, best = float(motion.torque_reduction[-1]), motion.torque_reduction_optimal
        of = f"optimum {best:.1%} less" if best > LEAST_REDUCTION else "no spring helps"
        if not motion.tracks[-1]:
            off = f"RMS {length(motion.tracking_rms[-1])}"
            wordings = [f"the tool is off its path ({off})", f"off its path ({off})", "off path"]
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
        height = motion.torque_squared_without_springs or ax.get_ylim()[0]
        remark(
            ax,
            fitting(wordings, SMALL, width * motion.cycles.size - 0.06),
            (motion.cycles[-1] + 0.5, height),
            **{"xycoords": "data", "xytext": (-2, 3), "textcoords": "offset points"},
            **{"ha": "right", "color": DESIRED, "bbox": LABEL_BOX},
        )


def ratio(run: Run) -> np.ndarray:
    """Torque² of each cycle as a multiple of the optimum's (cycles,); NaN where that is 0."""
    sizes, best = zip(
        *((motion.cycles.size, motion.torque_squared_optimal) for motion in run.motions),
        strict=True,
    )
    whole = np.repeat(best, sizes)
    return run.data["torque_squared"].values / np.where(whole > 0, whole, np.nan)
