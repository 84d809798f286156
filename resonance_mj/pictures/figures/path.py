"""The desired path in the task space, and where the tool went in the first and the last cycle."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...results.cycles import Cycle, kept
from ...results.run import Run
from ...text import joined, length, minus
from ..palette import DESIRED, EARLY, MEASURED
from .sheet import TITLE, Row, Sheet, abscissa_of_the_panel_below, heading
from .style import LINES, Line
from .ticks import abscissa, equal, even, logarithmic

HEIGHT, BESIDE = 2.3, 5.0
"""Height of a path, and width of a figure from which other panels stand beside it [in]."""

LEFT = 0.6
"""What numbers and label of an ordinate take [in]."""

FLAT = 0.02
"""Share of the longest side of a path below which it does not leave a plane of the axes."""

FIRST, LAST, START = "first cycle", "last cycle", "start of a cycle"
LEGEND: dict[str, Line] = {
    "desired": LINES["desired"],
    FIRST: {"color": EARLY},
    LAST: {"color": MEASURED, "linewidth": 1.2},
    START: {"color": DESIRED, "marker": "o", "markersize": 3, "linestyle": ""},
}


Pair = dict[str, Cycle]
"""The cycles of a motion that are drawn, by what the legend calls them; `LAST` is always there."""


def draw(run: Run, width: float) -> Figure:
    """Of each motion the path in its own plane; beside it error and rotation over the cycle."""
    axes = run.data["axis"].values.tolist()
    places = [name for name in axes if not name.startswith("r")]
    m = len(places)
    pairs = first_and_last(run)
    beside = width >= BESIDE
    over = 1 + len(axes) - m  # panels over the cycle
    block = _rows(over, beside)
    columns = 2 if beside else 1
    sheet = Sheet(
        width, block * len(pairs), columns, heading=heading(run), legend=LEGEND, left=LEFT
    )
    for index, pair in enumerate(pairs):
        top = index * len(block)
        numbers = [cycle.number for cycle in pair.values()]
        rms = [length(float(run.data["tracking_rms"].sel(cycle=one))) for one in numbers]
        ax = sheet.panel(
            top,
            0,
            f"motion {pair[LAST].motion + 1}: cycle{'s' * (len(numbers) > 1)} "
            f"{joined([*map(str, numbers)])}",
            notes=[f"tracking RMS {joined(rms)}"],
            down=len(block) if beside else 1,
        )
        _path(ax, pair, places)
        off = {
            label: 1e3 * np.linalg.norm((one.x - one.x_desired)[:, :m], axis=1)
            for label, one in pair.items()
        }
        panels = {"distance from where it should be [mm]": off}
        panels |= {f"tool rotation {axes[i]} [rad]": _both(pair, i) for i in range(m, len(axes))}
        for row, (title, signals) in enumerate(panels.items(), start=len(block) - over):
            ax = sheet.panel(top + row, int(beside), title)
            _over_the_cycle(ax, signals)
            (logarithmic if signals is off else even)(ax)
            if row < len(block) - 1:
                abscissa_of_the_panel_below(ax)
    return sheet.figure


def _rows(over: int, beside: bool) -> list[Row]:
    """The rows of a motion: its path beside panels over the cycle, or above them."""
    gap, below = 0.06, 0.34
    if not beside:
        return [Row(HEIGHT, below, below), *[Row(0.7, gap)] * (over - 1), Row(0.7, below)]
    each = max(0.5, (HEIGHT - (over - 1) * (gap + TITLE)) / over)
    rows = [Row(each, gap)] * (over - 1) + [Row(each, below)]
    return [rows[0]._replace(above=below), *rows[1:]]


def first_and_last(run: Run) -> list[Pair]:
    """Of each motion that was reached, the first kept cycle after the passage, and the last."""
    motions: dict[int, Pair] = {}
    for cycle in kept(run):
        pair = motions.setdefault(cycle.motion, {})
        first = pair.get(FIRST)
        if not first or (first.passage and not cycle.passage):
            pair[FIRST] = cycle
        pair[LAST] = cycle
    return [
        {label: one for label, one in pair.items() if label == LAST or one is not pair[LAST]}
        for pair in motions.values()
    ]


def plane_of(path: np.ndarray, names: Sequence[str]) -> tuple[np.ndarray, list[str]]:
    """The plane that a path lies in: of two axes where it does not leave it, else the nearest.

    Args:
        path: positions (N, m) [m], m at least 2.
        names: of the axes (m,).

    Returns:
        Its two directions, orthonormal (2, m), and what each is called.
    """
    extent = np.ptp(path, axis=0)
    if len(names) == 2 or extent.min() <= FLAT * extent.max():
        chosen = sorted(np.argsort(-extent, kind="stable")[:2])
        return np.eye(len(names))[chosen], [names[i] for i in chosen]
    directions = np.linalg.svd(path - path.mean(axis=0), full_matrices=False)[2][:2]
    largest = np.abs(directions).argmax(axis=1)
    directions = directions * np.sign(directions[np.arange(2), largest])[:, None]
    return directions, [
        minus(f"along ({', '.join(f'{part:.2f}' for part in each + 0.0)})") for each in directions
    ]


def _path(ax: Axes, pair: Pair, names: Sequence[str]) -> None:
    m = len(names)
    if m == 1:
        _over_the_cycle(ax, _both(pair, 0))
        even(ax)
        ax.set_ylabel(f"{names[0]} [m]")
        return
    directions, labels = plane_of(pair[LAST].x_desired[:, :m], names)
    for label, cycle in pair.items():
        points = cycle.x[:, :m] @ directions.T
        # One that is not periodic yet stays open.
        ax.plot(*(_closed(points) if cycle is pair[LAST] else points).T, **LEGEND[label])
    desired = pair[LAST].x_desired[:, :m] @ directions.T
    ax.plot(*_closed(desired).T, **LEGEND["desired"])
    ax.plot(*desired[0], **LEGEND[START])
    equal(ax)
    ax.set(xlabel=f"{labels[0]} [m]", ylabel=f"{labels[1]} [m]")
    abscissa(ax)
    even(ax, 6)


def _both(pair: Pair, axis: int) -> dict[str, np.ndarray]:
    """A coordinate as it was made, and as it is desired, by what the legend calls them."""
    found = {label: cycle.x[:, axis] for label, cycle in pair.items()}
    return {**found, "desired": pair[LAST].x_desired[:, axis]}


def _over_the_cycle(ax: Axes, signals: Mapping[str, np.ndarray]) -> None:
    """Signals (N,) over the cycle, by what the legend calls them."""
    for label, values in signals.items():
        ax.plot(np.arange(len(values)) / len(values), values, **LEGEND[label])
    ax.set(xlim=(0, 1), xlabel="share of the cycle t/T [1]")


def _closed(points: np.ndarray) -> np.ndarray:
    """A path (N, 2) that ends where it begins."""
    return np.concatenate([points, points[:1]])
