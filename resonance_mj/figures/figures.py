"""Figures of a run: the layout of the paper's Fig. 4 (a)-(h), and torque² per cycle below."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullLocator

from ..files import replacing
from ..forking import meanwhile
from ..results.run import Run

# Okabe and Ito's palette: told apart by colour-blind readers.
MEASURED = "#0072B2"
OPTIMAL = "#D55E00"
DESIRED = "#000000"
MUTED = "#7F7F7F"
LABEL_BOX = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 1}

STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # given, or matplotlib measures every text above the axes to find it
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "svg.fonttype": "none",
}


def figure(run: Run) -> Figure:
    """The paper's Fig. 4 for a run, and torque² per cycle against the optimum.

    Tip position with its reference, stiffness and offset torque with their optimum, motor torque
    with the optimum's. Signals that repeat with the motion are shown where something happens: at
    the start, around each change of motion and at the end.

    Args:
        run: a run with at least one recorded sample.
    """
    with matplotlib.rc_context(STYLE):
        return _draw(run)


def save(drawn: Figure, folder: Path, name: str = "figure") -> list[Path]:
    """Write a figure as NAME.svg and NAME.png into `folder`.

    Raises:
        OutputError: a file cannot be written.
    """
    svg, png = folder / f"{name}.svg", folder / f"{name}.png"

    # Each canvas is told to print itself: Figure.savefig draws everything twice.
    def as_svg() -> None:
        with matplotlib.rc_context(STYLE), replacing(svg) as path:
            FigureCanvasSVG(drawn).print_svg(path, metadata={"Date": None})

    def as_png() -> None:
        drawn.set_dpi(130)
        with matplotlib.rc_context(STYLE), replacing(png) as path:
            FigureCanvasAgg(drawn).print_png(path, pil_kwargs={"compress_level": 3})

    with meanwhile(as_png) as done:
        as_svg()
    if not done():
        as_png()
    return [svg, png]


def _draw(run: Run) -> Figure:
    """Two joints side by side as in the paper; more of them a row each."""
    data = run.data
    axes, joints = list(data["axis"].values), list(data["joint"].values)
    if len(joints) <= 2:
        columns = max(len(axes), len(joints))
        places = {("x", i): (0, i) for i in range(len(axes))}
        for row, name in enumerate(("stiffness", "offset", "tau"), start=1):
            places |= {(name, j): (row, j) for j in range(len(joints))}
        heights = [1.0, 0.8, 0.8, 1.0]
    else:
        columns = 3
        above = -(-len(axes) // columns)
        places = {("x", i): divmod(i, columns) for i in range(len(axes))}
        for column, name in enumerate(("stiffness", "offset", "tau")):
            places |= {(name, j): (above + j, column) for j in range(len(joints))}
        heights = [1.0] * above + [0.75] * len(joints)
    heights.append(1.1)
    width, height = 4.6 * columns, 2.3 * sum(heights) + 0.2
    fig = Figure(figsize=(width, height))
    # Fixed margins in inches: laying out by measuring every text takes longer than the simulation.
    grid = GridSpec(
        len(heights),
        columns,
        figure=fig,
        height_ratios=heights,
        left=0.5 / width,
        right=1 - 0.15 / width,
        bottom=0.5 / height,
        top=1 - 0.85 / height,
        hspace=0.42,
        wspace=0.16,
    )
    windows = _Windows(data)
    for letter, ((name, index), (row, column)) in zip(_letters(), places.items(), strict=False):
        ax = fig.add_subplot(grid[row, column])
        of = axes[index] if name == "x" else joints[index]
        title = f"({letter}) {TITLES[name].format(of)}"
        if name != "x" and data["slides"].values[index]:
            title = title.replace("N m/rad", "N/m").replace("N m", "N")
        ax.set_title(title)
        if name == "x":
            if of.startswith("r"):
                ax.set_title(
                    title.replace("tool position", "tool rotation").replace("[m]", "[rad]")
                )
            one = data.sel(axis=of)
            windows.plot(ax, data, one["x"], MEASURED, "-")
            windows.plot(ax, data, one["x_desired"], DESIRED, "--")
            windows.label(ax)
        elif name == "tau":
            one = data.sel(joint=of)
            windows.plot(ax, data, one["tau"], MEASURED, "-")
            windows.plot(ax, data, one["tau_optimal"], OPTIMAL, "--")
            windows.label(ax)
            _steady_limits(ax, data, one["tau"].values, one["tau_optimal"].values)
        else:
            _against_optimum(ax, data.sel(joint=of), name)
        ax.yaxis.set_major_locator(MaxNLocator(nbins=4))
    ax = fig.add_subplot(grid[-1, :])
    ax.set_title("mean of τᵀτ per cycle [N² m²]")
    _torque_squared(ax, data)
    heading = _heading(run)
    fig.suptitle(heading, x=0.5 / width, y=1 - 0.18 / height, ha="left", va="top", fontsize=10)
    _legend(fig, 0.5 / width, 1 - 0.42 / height)
    return fig


TITLES = {
    "x": "tool position {} [m]",
    "stiffness": "stiffness k of {} [N m/rad]",
    "offset": "offset torque q̄ₑ of {} [N m]",
    "tau": "motor torque τ of {} [N m]",
}


def _letters() -> Iterator[str]:
    for first in ("", *ascii_lowercase):
        for second in ascii_lowercase:
            yield first + second


def _heading(run: Run) -> str:
    law, motions = run.experiment.law, run.experiment.motion
    periods = ", ".join(f"{motion.cycles} × {motion.period:g} s" for motion in motions)
    form = f" (J {law.jacobian})" if law.jacobian else ""
    return (
        f"{run.experiment.name}: {Path(run.experiment.robot.mjcf).stem}, law {law.kind}{form}, "
        f"cycles {periods}; {run.status}"
    )


class _Windows:
    """A time axis that shows only where something happens, and breaks in between.

    That is the start, two cycles on either side of each change of motion, and the end.
    """

    def __init__(self, data: xr.Dataset) -> None:
        time = data["time"].values
        starts, ends, period = (data[name].values for name in ("start", "end", "period"))
        last = float(min(time[-1] + np.diff(time[-2:]).sum(), ends[-1]))
        reached = int(np.searchsorted(starts, last, side="right")) - 1
        wanted = [(0.0, 2 * period[0])]
        wanted += [
            (starts[i] - 2 * period[i - 1], starts[i] + 2 * period[i])
            for i in range(1, reached + 1)
        ]
        wanted.append((last - 2 * period[reached], last))
        self.spans: list[tuple[float, float]] = []
        for low, high in wanted:
            low, high = max(low, 0.0), min(high, last)
            if self.spans and low <= self.spans[-1][1]:
                self.spans[-1] = (self.spans[-1][0], high)
            else:
                self.spans.append((low, high))
        self._gap = 0.06 * max(sum(high - low for low, high in self.spans), 1e-9)
        widths = [high - low + self._gap for low, high in self.spans]
        self.left = np.concatenate([[0.0], np.cumsum(widths)])

    def plot(
        self, ax: Axes, data: xr.Dataset, values: xr.DataArray, colour: str, dash: str
    ) -> None:
        """Draw a signal over the windows."""
        for (low, high), left in zip(self.spans, self.left, strict=False):
            for time, piece in _pieces(data["time"].values, values.values, low, high):
                ax.plot(time - low + left, piece, color=colour, linestyle=dash)

    def label(self, ax: Axes) -> None:
        """Put the times on the axis, and mark where it breaks."""
        places: list[float] = []
        names: list[str] = []
        bins = max(1, min(4, 12 // len(self.spans)))
        for index, ((low, high), left) in enumerate(zip(self.spans, self.left, strict=False)):
            ticks: Any = MaxNLocator(
                nbins=bins, steps=[1, 2, 5, 10], integer=high - low >= 1, min_n_ticks=1
            ).tick_values(low, high)
            ticks = ticks[(ticks >= low - 1e-9) & (ticks <= high + 1e-9)]
            places += list(ticks - low + left)
            names += [f"{tick:g}" for tick in ticks]
            if index:
                ax.axvspan(left - self._gap, left, color="0.93", linewidth=0, zorder=3)
        ax.set_xticks(places, names)
        ax.set_xlim(0, max(self.left[-1] - self._gap, 1e-3))
        ax.set_xlabel("time [s]", labelpad=1)


def _steady_limits(ax: Axes, data: xr.Dataset, *signals: np.ndarray) -> None:
    """Scale an axis to the motion's own torque; a peak at its start or change is said in words."""
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
    peak = signals[0][np.argmax(np.abs(signals[0]))]
    if not low - margin <= peak <= high + margin:
        when = data["time"].values[np.argmax(np.abs(signals[0]))]
        ax.annotate(
            f"peak {peak:.0f} N m at {when:.2f} s",
            (0.01, 0.03),
            xycoords="axes fraction",
            color=MUTED,
            bbox=LABEL_BOX,
        )


def _pieces(
    time: np.ndarray, values: np.ndarray, low: float, high: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """A signal between two times, cut where cycles were left out, at most 800 points in all."""
    inside = np.flatnonzero((time >= low) & (time <= high))
    if not inside.size:
        return
    gap = 1.5 * np.median(np.diff(time[inside])) if inside.size > 1 else np.inf
    for piece in np.split(inside, np.flatnonzero(np.diff(time[inside]) > gap) + 1):
        thin = piece[:: max(1, inside.size // 800)]
        yield time[thin], values[thin]


def _against_optimum(ax: Axes, data: xr.Dataset, name: str) -> None:
    """An adapted parameter over the whole run, with its optimum dashed."""
    keep = slice(None, None, max(1, data.sizes["time"] // 1000))
    ax.plot(data["time"].values[keep], data[name].values[keep], color=MEASURED)
    optimal, starts, ends = (data[key].values for key in (f"{name}_optimal", "start", "end"))
    ax.hlines(optimal, starts, ends, color=OPTIMAL, linestyle="--")
    ax.set_xlim(0, ends[-1])
    ax.set_xlabel("time [s]", labelpad=1)


def _torque_squared(ax: Axes, data: xr.Dataset) -> None:
    cycles, segment = data["cycle"].values, data["segment_of_cycle"].values
    for number in data["segment"].values:
        mine = cycles[segment == number]
        if not mine.size:
            continue
        one = data.sel(segment=number)
        without = float(one["torque_squared_without_springs"])
        optimal = float(one["torque_squared_optimal"])
        ends = (mine[0] - 0.5, mine[-1] + 0.5)
        ax.hlines(without, *ends, color=MUTED, linestyle=":")
        ax.hlines(optimal, *ends, color=OPTIMAL, linestyle="--")
        last = float(data["torque_squared"].sel(cycle=mine[-1]))
        found = f"{1 - last / without:.1%} less than without springs"
        if last > without:
            found = f"{last / without:.3g} times that without springs"
        said = f"{found} (optimum {1 - optimal / without:.1%} less)"
        if data.sizes["segment"] > 2:  # where there is no room for more
            said = f"{1 - last / without:.1%} (of {1 - optimal / without:.1%})"
        ax.annotate(
            said,
            (mine[-1], without),
            xytext=(-4, 4),
            textcoords="offset points",
            ha="right",
            bbox=LABEL_BOX,
        )
    ax.plot(cycles, data["torque_squared"].values, "o-", ms=2.5, color=MEASURED)
    ax.set_yscale("log")
    ax.margins(y=0.12)
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.set_xlim(0.5, max(cycles[-1], 2) + 0.5 if cycles.size else 1)
    ax.set_xlabel("cycle", labelpad=1)


def _legend(fig: Figure, left: float, top: float) -> None:
    """One legend for all axes: a colour means the same in each."""
    lines = [
        Line2D([], [], color=MEASURED, linestyle="-", label="measured"),
        Line2D([], [], color=DESIRED, linestyle="--", label="desired"),
        Line2D([], [], color=OPTIMAL, linestyle="--", label="with optimal springs"),
        Line2D([], [], color=MUTED, linestyle=":", label="without springs"),
    ]
    fig.legend(
        handles=lines,
        loc="upper left",
        bbox_to_anchor=(left, top),
        ncols=len(lines),
        borderaxespad=0,
        borderpad=0,
        handlelength=1.8,
        handletextpad=0.5,
        columnspacing=1.4,
    )
