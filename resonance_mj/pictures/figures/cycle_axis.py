"""Panels over the cycles of a run: where its motions change, and torque² beside its bounds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from ...experiments.experiment import Experiment
from ...results.run import Run, Status
from ..palette import MEASURED, MUTED, OPTIMAL
from .style import LABEL_BOX, SMALL, breadth, counted, logarithmic
from .text import fitting


def motions(ax: Axes, experiment: Experiment, *, named: bool = False) -> None:
    """Mark which cycles belong to which motion, and in grey those of the passage into it.

    Args:
        ax: over cycles; its abscissa is set to all that the experiment has.
        experiment: that was run.
        named: write the motions' numbers at the top.
    """
    first = 0
    for number, motion in enumerate(experiment.motion, start=1):
        if first:
            ax.axvline(first + 0.5, color=MUTED, linewidth=0.8)
        if motion.blend:
            ax.axvspan(first + 0.5, first + motion.blend + 0.5, color="0.93", linewidth=0, zorder=0)
        if named:
            ax.annotate(
                f"motion {number}",
                (first + 0.5 + motion.cycles / 2, 0.98),
                xycoords=("data", "axes fraction"),
                ha="center",
                va="top",
                color=MUTED,
                fontsize=SMALL,
            )
        first += motion.cycles
    ax.set_xlim(0.5, first + 0.5)
    counted(ax)


def curve(ax: Axes, run: Run, values: np.ndarray, **style: Any) -> None:
    """Draw a value of each whole cycle (cycles,); a cross marks where the run diverged."""
    cycles = run.data["cycle"].values
    (line,) = ax.plot(cycles, values, **{"marker": ".", "ms": 3.5, **style})
    if run.status is Status.DIVERGED:
        ax.plot(cycles[-1:], values[-1:], "x", color=line.get_color(), ms=6, mew=1.5)


def torque_squared(ax: Axes, run: Run) -> None:
    """Torque² of each cycle, with the optimum's and that without springs of each motion."""
    data = run.data
    for mine, one in of_motions(data):
        ends = (mine[0] - 0.5, mine[-1] + 0.5)
        without = float(one["torque_squared_without_springs"])
        ax.hlines(without, *ends, color=MUTED, linestyle=":")
        ax.hlines(float(one["torque_squared_optimal"]), *ends, color=OPTIMAL, linestyle="--")
    curve(ax, run, data["torque_squared"].values, color=MEASURED)
    if not data.sizes["cycle"]:
        ax.text(0.5, 0.5, "no whole cycle", ha="center", color=MUTED, transform=ax.transAxes)
        return
    logarithmic(ax)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high * (high / low) ** 0.15)  # room for words at the line without springs


def reductions(ax: Axes, data: xr.Dataset) -> None:
    """Write at the line without springs by how much less torque² each motion ended.

    Args:
        ax: whose abscissa has its limits.
        data: `Run.data`.
    """
    width = breadth(ax)
    cycles = ax.get_xlim()[1] - ax.get_xlim()[0]
    for mine, one in of_motions(data):
        without = float(one["torque_squared_without_springs"])
        optimal = float(one["torque_squared_optimal"])
        last = float(data["torque_squared"].sel(cycle=mine[-1]))
        best = f"{1 - optimal / without:.1%}"
        wordings = [f"{1 - last / without:.1%} less than without springs (optimum {best} less)"]
        if last > without:
            wordings = [f"{last / without:.3g} times that without springs (optimum {best} less)"]
        wordings += [f"{1 - last / without:.1%} less (of {best})", f"{1 - last / without:.1%}"]
        ax.annotate(
            fitting(wordings, SMALL, width * mine.size / cycles - 0.06),
            (mine[-1] + 0.5, without),
            xytext=(-2, 3),
            textcoords="offset points",
            ha="right",
            fontsize=SMALL,
            bbox=LABEL_BOX,
        )


def ratio(run: Run) -> np.ndarray:
    """Torque² of each cycle as a multiple of the optimum's of its motion (cycles,)."""
    optimal = run.data["torque_squared_optimal"].sel(segment=run.data["segment_of_cycle"])
    return np.asarray(run.data["torque_squared"].values / optimal.values)


def of_motions(data: xr.Dataset) -> Iterator[tuple[np.ndarray, xr.Dataset]]:
    """The whole cycles of each motion that was reached, and what is known of it."""
    cycles, segment = data["cycle"].values, data["segment_of_cycle"].values
    for number in data["segment"].values:
        mine = cycles[segment == number]
        if mine.size:
            yield mine, data.sel(segment=number)
