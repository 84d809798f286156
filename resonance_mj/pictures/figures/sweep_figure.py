"""A sweep as a figure: a line over one key, a map over two, or all runs over each of more keys."""

import textwrap
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from ...errors import PictureError
from ...text import listed, minus, shown
from ..palette import DESIRED, SERIES
from .style import HEADING, Look, enlarged, if_titled, look, styled

LABELS = {
    "torque_share": "share of the possible reduction",
    "cost_share": "share of the possible reduction",
    "cycles_to_optimum": "cycles to the optimum",
    "tracking_rms": "tracking RMS [m]",
}
"""What axes are called, where the variable's name and unit would say less."""

SHARES = ("torque_share", "cost_share")
"""Metrics that are the reduction over that of the optimum."""

SEED = "reality.seed"
"""Of a grid over it the median is drawn, and over one other key the spread."""

PREDICTED = "predicted_to_diverge"
"""Of a sweep with `predict`: what the linear analysis says."""

LETTERS = 14
"""Of a heading, on an inch."""

CROWDED = 30
"""Letters of the words along an axis from which on they stand aslant."""

BAD = "0.85"
"""Colour of runs without a value: that never got there, diverged or were refused."""


def figure(data: xr.Dataset, metric: str, width: float, asked: Look | None = None) -> Figure:
    """A panel for each motion, and each key where there are more than two.

    Args:
        data: from `sweep`.
        metric: one of the dataset's figures per motion, or torque_share or cost_share: the
            reduction over that of the optimum. Runs that are not ok have none.
        width: of the figure [in].
        asked: what else is asked of it.

    Raises:
        PictureError: the dataset has no such figure.
    """
    with styled(asked=asked):
        return _figure(data, metric, width)


def _figure(data: xr.Dataset, metric: str, width: float) -> Figure:
    values, well = _values(data, metric), data["status"] == "ok"
    keys = [str(name) for name in data.coords if name not in ("motion", "joint", "cycle", "run")]
    ends: list[xr.DataArray] = []
    if SEED in data.dims and len(keys) > 1:
        keys.remove(SEED)
        ends, well = [values.min(SEED), values.max(SEED)], well.all(SEED)
        values = values.median(SEED, skipna=False)
    grid = all(key in data.dims for key in keys)
    panels = 1 if grid and len(keys) < 3 else len(keys)
    motions = data.sizes["motion"]
    height = look().height or enlarged() * (0.3 + 2.3 * panels)
    drawn = Figure(figsize=(width, height), layout="constrained")
    mapped = grid and len(keys) == 2
    words = [if_titled(data.attrs["title"].removeprefix("resonance-mj "))]
    words += ["grey where a run is not ok, or never gets there"] * mapped
    words += [f"median{'' if mapped else ' and spread'} over seeds"] * bool(ends)
    predicts = mapped and PREDICTED in data
    words += ["the linear analysis: diverges beyond the line"] * predicts
    if heading := "; ".join(filter(None, words)):
        lines = textwrap.fill(heading, int(LETTERS * width / enlarged()))
        drawn.suptitle(lines, x=0.01, ha="left", fontsize=enlarged() * HEADING)
    axes = drawn.subplots(panels, motions, squeeze=False, sharey="row")
    for column, motion in enumerate(data["motion"].values):
        of_motion = values.sel(motion=motion)
        if mapped:
            cells = _map(axes[0, column], of_motion, keys, _norm(values))
            if predicts:
                told = data[PREDICTED].max(SEED) if ends else data[PREDICTED]
                _boundary(axes[0, column], told.transpose(*keys).values.T)
            if column == motions - 1:
                bar = drawn.colorbar(cells, ax=list(axes[0]))
                bar.set_label(label(data, metric), labelpad=8)
                bar.formatter = _plain()
        else:
            for row, key in enumerate(keys[:panels]):
                ax, alone = axes[row, column], grid and len(keys) == 1
                _over(ax, of_motion, ~well, key, joined=alone)
                if alone and ends and values[key].dtype.kind == "f":
                    low, high = (end.sel(motion=motion).values for end in ends)
                    ax.fill_between(values[key].values, low, high, color=SERIES[0], alpha=0.2, lw=0)
                axes[row, 0].set_ylabel(label(data, metric))
        axes[0, column].set_title(f"motion {motion}")
    return drawn


def known(data: xr.Dataset, metric: str) -> bool:
    """Whether any run that is ok has a metric."""
    return bool(np.isfinite(_values(data, metric).values).any())


def label(data: xr.Dataset, metric: str) -> str:
    """What the axis of a metric is called."""
    if metric in LABELS:
        return LABELS[metric]
    units = data[metric].attrs.get("units", "1")
    units = units.replace("^2", "²").replace(" / ", "/")
    return metric.replace("_", " ") + (f" [{units}]" if units != "1" else "")


def _values(data: xr.Dataset, metric: str) -> xr.DataArray:
    if metric in SHARES:
        reduction = data[metric.replace("share", "reduction")]
        found = reduction / data[metric.replace("share", "reduction_optimal")]
    elif metric in data and "motion" in data[metric].dims and "joint" not in data[metric].dims:
        found = data[metric]
    else:
        per_motion = [str(n) for n in data if {"motion"} == set(data[n].dims) & {"motion", "joint"}]
        raise PictureError(
            f"metric {shown(metric)} is unknown; there are {listed([*SHARES, *per_motion])}"
        )
    return found.where(data["status"] == "ok")


def _norm(values: xr.DataArray) -> Normalize:
    """One scale of colours for the maps of all motions."""
    known = values.values[np.isfinite(values.values)]
    low, high = (known.min(), known.max()) if known.size else (0.0, 1.0)
    return LogNorm(low, high) if 0 < 30 * low < high else Normalize(low, high)


def _map(ax: Axes, values: xr.DataArray, keys: list[str], norm: Normalize) -> QuadMesh:
    """A map over two keys, the cells numbered along their values."""
    table = np.ma.masked_invalid(values.transpose(*keys).values.T)
    cells = ax.pcolormesh(table, cmap="viridis", norm=norm, edgecolors="white", linewidth=0.5)
    ax.set_facecolor(BAD)
    ax.grid(visible=False)
    for axis, key in zip((ax.xaxis, ax.yaxis), keys, strict=True):
        ticks = values[key].values
        step = max(1, -(-len(ticks) // 9))
        words = [_tick(tick) for tick in ticks[::step]]
        axis.set_ticks(np.arange(len(ticks))[::step] + 0.5, words)
        axis.set_label_text(key)
        if axis is ax.xaxis and sum(map(len, words)) > CROWDED:
            axis.set_tick_params(rotation=30)
            for word in axis.get_ticklabels():
                word.set(horizontalalignment="right", rotation_mode="anchor")
    return cells


def _boundary(ax: Axes, diverges: np.ndarray) -> None:
    """A line between cells of which one is predicted to diverge (rows, columns) and one is not."""
    line: dict[str, Any] = {"color": DESIRED, "linewidth": 1.6, "solid_capstyle": "round"}
    for row, column in np.argwhere(diverges[:, 1:] != diverges[:, :-1]):
        ax.plot([column + 1, column + 1], [row, row + 1], **line)
    for row, column in np.argwhere(diverges[1:] != diverges[:-1]):
        ax.plot([column, column + 1], [row + 1, row + 1], **line)


def _over(ax: Axes, values: xr.DataArray, failed: xr.DataArray, key: str, *, joined: bool) -> None:
    """Values over a key; crosses at the bottom where runs are not ok."""
    place = xr.broadcast(values[key], values)[0].values.ravel()
    number = place.dtype.kind == "f"
    if not number:
        names = list(dict.fromkeys(place.tolist()))
        place = np.array([names.index(one) for one in place])
        ax.set_xticks(range(len(names)), [_tick(name) for name in names])
    y = values.values.ravel()
    ax.plot(place, y, "o-" if joined else "o", markersize=3, color=SERIES[0])
    bad = failed.values.ravel()
    across = ax.get_xaxis_transform()
    ax.plot(place[bad], np.full(bad.sum(), 0.03), "x", color=DESIRED, transform=across)
    ratios = np.diff(np.log(np.unique(place))) if number and (place > 0).all() else np.zeros(0)
    if len(ratios) > 1 and np.ptp(ratios) < 0.5 * ratios.mean():
        ax.set_xscale("log")
        swept = np.unique(place)
        some = swept[:: max(1, -(-len(swept) // 9))]
        ax.set_xticks(some, [_tick(value) for value in some])
        ax.set_xticks([], minor=True)
    known = y[np.isfinite(y)]
    if known.size and known.min() > 0 and known.max() > 30 * known.min():
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(_plain())
        ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(f"{key}  (×: not ok)" if bad.any() else key)


def _plain() -> FuncFormatter:
    """Numbers along a logarithmic axis; matplotlib's own are mathematics, which is not parsed."""
    return FuncFormatter(lambda value, _: minus(f"{value:g}"))


def _tick(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)[:20]
