"""The plots below the scene: torque² per cycle and stiffness over time, drawn once for a video."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator
from PIL import ImageColor

from ...results.run import Run
from .. import stiffnesses
from ..figures.style import styled
from ..palette import MEASURED, MUTED, OPTIMAL
from .frame_data import cycle_ends
from .frames import PlotPicture
from .options import RenderOptions


def pictures(runs: tuple[Run, ...], options: RenderOptions) -> tuple[PlotPicture | None, ...]:
    """The plots of each run of a picture; None where the options have none."""
    if not options.plots:
        return (None,) * len(runs)
    columns = options.columns(len(runs))
    return tuple(
        draw(run, options, right - left) for run, (left, right) in zip(runs, columns, strict=True)
    )


def draw(run: Run, options: RenderOptions, width: int) -> PlotPicture:
    """The plots of a run, `width` pixels wide and as high as the options have them."""
    height = options.plots_height
    size = max(6.0, min(height / 18, width / 68, 15.0))
    style: Any = {
        "font.size": size,
        "text.parse_math": False,
        "axes.titlesize": size,
        "axes.titlelocation": "left",
        "axes.titlepad": 0.35 * size,
        "axes.linewidth": 0.8,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.facecolor": options.paper,
        "figure.facecolor": options.paper,
        **dict.fromkeys(
            ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"),
            options.ink,
        ),
        "xtick.major.pad": 2,
        "ytick.major.pad": 2,
        "xtick.major.size": 3,
        "ytick.major.size": 3,
    }
    with styled(style):
        figure = Figure(figsize=(width / 72, height / 72), dpi=72)
        canvas, drawn = FigureCanvasAgg(figure), []
        measured = _plots(figure, run, width, height, size)
        for strength in (1.0, 0.22):
            for line in measured:
                line.set_alpha(strength)
            canvas.draw()
            drawn.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
        boxes = [ax.get_window_extent() for ax in figure.axes]
    panels = tuple(
        (round(height - b.y1), round(height - b.y0), round(b.x0) + 1, round(b.x1)) for b in boxes
    )
    ink = np.array(ImageColor.getrgb(options.ink), np.uint8)
    before, after = drawn
    return PlotPicture(before, after, panels, (0.0, float(run.data["end"].values[-1])), ink)


class _Spring(NamedTuple):
    """The stiffness of a joint's spring, or of an elastic element."""

    name: str
    unit: str
    time: np.ndarray
    k: np.ndarray
    best: np.ndarray
    """In each motion."""
    drawstyle: str = "default"


def _springs(run: Run) -> list[_Spring]:
    """Those that a run has."""
    data = run.data
    keep = slice(None, None, max(1, data.sizes["time"] // 1500))
    time, k = data["time"].values[keep], data["stiffness"].values[keep]
    best = data["stiffness_optimal"].values
    found = []
    for j in stiffnesses.joints(run):
        unit = _UNITS[0 if data["slides"].values[j] else 1]
        found.append(_Spring(data["joint"].values[j], unit, time, k[:, j], best[:, j]))
    for one in stiffnesses.elements(run):
        unit = _UNITS[0 if one.metric else 1]
        found.append(_Spring(one.name, unit, one.time, one.k, one.best, "steps-pre"))
    return found


_UNITS = "N/m", "N m/rad"


def _plots(figure: Figure, run: Run, width: int, height: int, size: float) -> list[Line2D]:
    """Draw the plots in a font of so many pixels; the lines of what was measured."""
    springs = _springs(run)
    count = len(springs)
    columns = count if count <= 3 else -(-count // 2)
    rows = -(-count // columns)
    gap, line = 3.6 * size / width, 1.5 * size / height
    share = 0.4 if columns <= 2 else 0.3
    each = (1 - 1.3 * size / width - share) / columns
    tall = (1 - 0.9 * line) / rows
    ax = figure.add_axes((gap, 1.9 * line, share - gap - 0.02, 1 - 3.1 * line))
    measured = _cost(ax, run, roomy=(share - gap) * width > 26 * size)
    for at, spring in enumerate(springs):
        row, column = divmod(at, columns)
        bottom = 1 - (row + 1) * tall + (1.0 if rows == 1 else 0.95) * line
        box = (share + column * each + gap, bottom, each - gap, tall - 2.15 * line)
        alike = [one for one in springs if one.unit == spring.unit]
        measured += _stiffness(ax := figure.add_axes(box), run, spring, alike, few=count <= 3)
        if at < count - columns:
            ax.set_xticklabels([])
    return measured


def _cost(ax: Axes, run: Run, roomy: bool) -> list[Line2D]:
    data = run.data
    starts, stops = data["start"].values, data["end"].values
    without = [motion.cost_without_springs for motion in run.motions]
    best = [motion.cost_optimal for motion in run.motions]
    ax.hlines(without, starts, stops, color=MUTED, linestyle=":")
    ax.hlines(best, starts, stops, color=OPTIMAL, linestyle="--")
    time = cycle_ends(run.experiment)[: data.sizes["cycle"]]
    cost = np.concatenate([motion.cost for motion in run.motions])
    measured = ax.plot(time, cost, color=MEASURED, linewidth=2, marker="o", markersize=3)
    ax.set_yscale("log")
    ax.set_title(f"{'motor ' * (run.cost.name == 'torque²')}{run.cost.name} [{run.cost.unit}]")
    if roomy:
        # What the lines are, in their colours, at the right of the title.
        for at, text, colour in ((-8.2, "- - optimum", OPTIMAL), (0, "··· no springs", MUTED)):
            ax.annotate(
                text,
                (1.0, 1.0),
                xytext=(at, 0.35),
                xycoords="axes fraction",
                textcoords="offset fontsize",
                ha="right",
                va="bottom",
                color=colour,
            )
    ax.yaxis.set_major_locator(LogLocator(numticks=5))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_locator(NullLocator())
    _time_axis(ax, float(stops[-1]))
    ax.set_xlabel("time [s]", labelpad=0)
    return measured


def _stiffness(
    ax: Axes, run: Run, spring: _Spring, alike: list[_Spring], *, few: bool
) -> list[Line2D]:
    starts, ends = run.data["start"].values, run.data["end"].values
    ax.hlines(spring.best, starts, ends, color=OPTIMAL, linestyle="--")
    how: Any = {"color": MEASURED, "linewidth": 2, "drawstyle": spring.drawstyle}
    measured = ax.plot(spring.time, spring.k, **how)
    title = f"k {spring.name} [{spring.unit}]"
    if 0.6 * len(title) * float(ax.title.get_fontsize()) > ax.bbox.width:
        title = title.partition(" [")[0]
    ax.set_title(title)
    ax.yaxis.set_major_locator(MaxNLocator(nbins=4 if few else 2))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    _ordinate(ax, spring, alike)
    _time_axis(ax, float(ends[-1]))
    return measured


def _ordinate(ax: Axes, spring: _Spring, alike: list[_Spring]) -> None:
    """Limits from the bulk of the values; next to nothing is not blown up."""
    low, high = np.quantile(spring.k, [0.005, 0.995])
    low, high = min(low, spring.best.min(), 0.0), max(high, spring.best.max(), 0.0)
    usual = max(np.quantile(np.abs(np.concatenate([one.k for one in alike])), 0.98), 0.0)
    least = 0.01 * max(usual, *(np.abs(one.best).max() for one in alike)) or 1.0
    high = max(high, low + least)
    margin = 0.08 * (high - low)
    ax.set_ylim(low - margin, high + margin)


def _time_axis(ax: Axes, end: float) -> None:
    ax.set_xlim(0, end)
    ax.xaxis.set_major_locator(MaxNLocator(nbins=4, integer=end >= 4))
