"""The paper's Fig. 4 (a)-(h) for any number of joints, and torque² per cycle below."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...results.run import Run
from ..palette import DESIRED, MEASURED, MUTED, OPTIMAL
from . import cycle_axis
from .naming import heading, letters, of_joint, torque_squared_unit
from .sheet import Row, Sheet
from .sizes import PAGE
from .style import FONT, LABEL_BOX, LINES, SMALL, STYLE, breadth, plain
from .text import alike, fitting, naming
from .windows import Windows

TITLES = {
    "x": ("tool position {} [m]", "tool {} [m]", "{} [m]"),
    "rotation": ("tool rotation {} [rad]", "tool {} [rad]", "{} [rad]"),
    "stiffness": ("stiffness k of {} [N m/rad]", "k of {} [N m/rad]", "k {} [N m/rad]"),
    "offset": ("offset torque q̄ₑ of {} [N m]", "q̄ₑ of {} [N m]", "q̄ₑ {} [N m]"),
    "tau": ("motor torque τ of {} [N m]", "τ of {} [N m]", "τ {} [N m]"),
}
"""Wordings from long to short."""

SIDE_BY_SIDE = 1.5
"""Width below which panels are not drawn three in a row [in]."""


def draw(runs: Sequence[Run], width: float = PAGE) -> Figure:
    """Tool position, stiffness, offset torque, motor torque and torque², beside the optimum.

    Signals that repeat with the motion are shown where something happens: at the start, around
    each change of motion and at the end.

    Args:
        runs: one run with at least one recorded sample.
        width: of the figure [in].
    """
    (run,) = runs
    with matplotlib.rc_context(STYLE):
        return _draw(run, width)


def _draw(run: Run, width: float) -> Figure:
    data = run.data
    axes, joints = data["axis"].values.tolist(), data["joint"].values.tolist()
    places, rows, columns = _places(len(axes), len(joints), width)
    sheet = Sheet(width, rows, columns, heading=heading(run), legend=LINES)
    windows = Windows(data)
    names = letters()
    for (name, index), (row, column) in places.items():
        ax = sheet.panel(row, column)
        of = axes[index] if name == "x" else joints[index]
        slides = name != "x" and bool(data["slides"].values[index])
        kind = "rotation" if name == "x" and of.startswith("r") else name
        wordings = alike(TITLES[kind], axes if name == "x" else joints, FONT, sheet.room)
        letter = next(names)
        sheet.title(ax, *naming((f"({letter}) {of_joint(each, slides)}" for each in wordings), of))
        one = data.sel(axis=of) if name == "x" else data.sel(joint=of)
        if name == "x":
            windows.plot(ax, data, one["x"], MEASURED, "-")
            windows.plot(ax, data, one["x_desired"], DESIRED, "--")
            windows.label(ax)
        elif name == "tau":
            windows.plot(ax, data, one["tau"], MEASURED, "-")
            windows.plot(ax, data, one["tau_optimal"], OPTIMAL, "--")
            windows.label(ax)
            _steady_limits(ax, data, one, of_joint("N m", slides))
        else:
            _against_optimum(ax, one, name)
        plain(ax)
        if rows[row].below < Row(0).below:  # the abscissa is that of the panel below
            ax.set_xlabel("")
            ax.tick_params(labelbottom=False)
    ax = sheet.panel(len(rows) - 1, 0, columns)
    sheet.title(ax, f"({next(names)}) mean of τᵀτ per cycle [{torque_squared_unit(data)}]")
    cycle_axis.torque_squared(ax, run)
    cycle_axis.motions(ax, run.experiment)
    cycle_axis.reductions(ax, data)
    return sheet.figure


def _places(
    axes: int, joints: int, width: float
) -> tuple[dict[tuple[str, int], tuple[int, int]], list[Row], int]:
    """Row and column of each panel, the rows, the last of which is torque², and the columns.

    Two joints stand side by side as in the paper, more of them below each other with a column each
    for k, q̄_e and τ; where that is too narrow, in two columns.
    """
    per_joint = ("stiffness", "offset", "tau")
    if joints > 2 and width / 3 > SIDE_BY_SIDE:
        columns, above = 3, -(-axes // 3)
        places = {("x", i): divmod(i, columns) for i in range(axes)}
        for column, name in enumerate(per_joint):
            places |= {(name, j): (above + j, column) for j in range(joints)}
        tall = 0.75 if joints <= 4 else 0.54
        rows = [Row(0.8)] * above
        rows += [Row(tall, 0.06)] * (joints - 1) + [Row(tall)]
    else:
        columns = min(2, max(axes, joints))
        places, rows = {}, []
        for name in ("x", *per_joint):
            many = axes if name == "x" else joints
            places |= {(name, i): (len(rows) + i // columns, i % columns) for i in range(many)}
            tall = 1.0 if name in ("x", "tau") else 0.8
            rows += [Row(tall)] * -(-many // columns)
    return places, [*rows, Row(1.1)], columns


def _steady_limits(ax: Axes, data: xr.Dataset, one: xr.Dataset, unit: str) -> None:
    """Scale an axis to the motion's own torque; a peak at its start or change is said in words."""
    signals = one["tau"].values, one["tau_optimal"].values
    cycle = data["cycle_of_sample"].values
    segment = data["segment_of_cycle"].values
    first = np.flatnonzero(np.diff(segment, prepend=0)) + 1
    steady = ~np.isin(cycle, np.concatenate([first, first + 1])) & (cycle <= len(segment))
    if not steady.any():
        return
    high = max(float(signal[steady].max()) for signal in signals)
    low = min(float(signal[steady].min()) for signal in signals)
    margin = 0.25 * max(high - low, 1e-9)
    ax.set_ylim(low - margin, high + margin)
    largest = int(np.argmax(np.abs(signals[0])))
    peak, when = signals[0][largest], data["time"].values[largest]
    if not low - margin <= peak <= high + margin:
        said = f"peak {peak:.3g} {unit}".replace("-", "−")
        ax.annotate(
            fitting([f"{said} at {when:.2f} s", said], SMALL, breadth(ax)),
            (0.01, 0.03),
            xycoords="axes fraction",
            color=MUTED,
            fontsize=SMALL,
            bbox=LABEL_BOX,
        )


def _against_optimum(ax: Axes, one: xr.Dataset, name: str) -> None:
    """An adapted parameter over the whole run, with its optimum dashed."""
    keep = slice(None, None, max(1, one.sizes["time"] // 1000))
    ax.plot(one["time"].values[keep], one[name].values[keep], color=MEASURED)
    optimal, starts, ends = (one[key].values for key in (f"{name}_optimal", "start", "end"))
    ax.hlines(optimal, starts, ends, color=OPTIMAL, linestyle="--")
    ax.set_xlim(0, ends[-1])
    ax.set_xlabel("time [s]")
