"""The desired path in the task space, and where the tool went in the first and the last cycle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter

from ...results.cycles import Cycle, kept
from ...results.run import Run
from ..palette import DESIRED, EARLY, MEASURED
from .naming import heading, letters
from .sheet import TITLE, Row, Sheet
from .sizes import PAGE
from .style import STYLE, abscissa, like, logarithmic, plain

HEIGHT, BESIDE = 2.3, 5.0
"""Height of a path, and width of a figure from which other panels stand beside it [in]."""

LEFT = 0.6
"""What numbers and label of an ordinate take [in]."""

FLAT = 0.02
"""Share of the longest side of a path below which it does not leave a plane of the axes."""

LEGEND = {
    "desired": Line2D([], [], color=DESIRED, linestyle="--", linewidth=1.0),
    "first cycle": Line2D([], [], color=EARLY, linewidth=1.0),
    "last cycle": Line2D([], [], color=MEASURED, linewidth=1.2),
    "start of a cycle": Line2D([], [], color=DESIRED, marker="o", markersize=3, linestyle=""),
}


def draw(runs: Sequence[Run], width: float = PAGE) -> Figure:
    """Of each motion the path in its own plane; beside it error and rotation over the cycle.

    The first cycle is the first after the passage into the motion, where it was kept.

    Args:
        runs: one run with a whole cycle whose samples were kept.
        width: of the figure [in].
    """
    (run,) = runs
    axes = run.data["axis"].values.tolist()
    places = [name for name in axes if not name.startswith("r")]
    turns = [i for i, name in enumerate(axes) if name.startswith("r")]
    pairs = first_and_last(run)
    over = {"distance from where it should be [mm]": -1}
    over |= {f"tool rotation {axes[i]} [rad]": i for i in turns}
    pairs = first_and_last(run)
    beside = width >= BESIDE
    block = _rows(len(over), beside)
    with matplotlib.rc_context(STYLE):
        sheet = Sheet(
            width,
            block * len(pairs),
            2 if beside else 1,
            heading=heading(run),
            legend=LEGEND,
            left=LEFT,
        )
        names = letters()
        for index, pair in enumerate(pairs):
            top = index * len(block)
            ax = sheet.panel(top, down=len(block) if beside else 1)
            sheet.title(ax, f"({next(names)}) {_cycles(pair)}", notes=[_errors(run, pair)])
            _path(ax, pair, places)
            for row, (title, axis) in enumerate(over.items(), start=len(block) - len(over)):
                ax = sheet.panel(top + row, int(beside))
                sheet.title(ax, f"({next(names)}) {title}")
                if axis < 0:
                    _over_the_cycle(ax, pair, lambda one: _distance(one, len(places)))
                    logarithmic(ax)
                else:
                    _coordinate(ax, pair, axis)
                if row < len(block) - 1:  # the abscissa is that of the panel below
                    ax.tick_params(labelbottom=False)
                    ax.set_xlabel("")
    return sheet.figure


def _rows(over: int, beside: bool) -> list[Row]:
    """The rows of a motion: its path beside panels over the cycle, or above them."""
    gap, below = 0.06, 0.34
    if not beside:
        rows = [Row(0.7, gap)] * (over - 1) + [Row(0.7, below)]
        return [Row(HEIGHT, below, below), *rows]
    each = max(0.5, (HEIGHT - (over - 1) * (gap + TITLE)) / over)
    if over == 1:
        return [Row(each, below, below)]
    return [Row(each, gap, below), *[Row(each, gap)] * (over - 2), Row(each, below)]


def first_and_last(run: Run) -> list[tuple[Cycle, Cycle]]:
    """Of each motion that was reached, the first kept cycle after the passage, and the last."""
    motions: dict[int, list[Cycle]] = {}
    for cycle in kept(run):
        motions.setdefault(cycle.motion, []).append(cycle)
    return [
        (next((cycle for cycle in mine if not cycle.passage), mine[0]), mine[-1])
        for mine in motions.values()
    ]


class Plane(NamedTuple):
    """A plane of the task space to draw a path in."""

    directions: np.ndarray
    """Its two directions, orthonormal (2, m)."""
    labels: tuple[str, str]
    """What they are called."""


def plane_of(path: np.ndarray, names: Sequence[str]) -> Plane:
    """The plane that a path lies in: of two axes where it does not leave it, else the nearest.

    Args:
        path: positions (N, m) [m], m at least 2.
        names: of the axes (m,).
    """
    extent = np.ptp(path, axis=0)
    if len(names) == 2 or extent.min() < FLAT * extent.max():
        chosen = sorted(np.argsort(-extent, kind="stable")[:2])
        labels = names[chosen[0]], names[chosen[1]]
        return Plane(np.eye(len(names))[chosen], labels)
    directions = np.linalg.svd(path - path.mean(axis=0), full_matrices=False)[2][:2]
    largest = np.abs(directions).argmax(axis=1)
    directions = directions * np.sign(directions[np.arange(2), largest])[:, None]
    first, second = (
        "along (" + ", ".join(f"{part:.2f}" for part in each + 0.0) + ")" for each in directions
    )
    return Plane(directions, (first.replace("-", "−"), second.replace("-", "−")))


def _path(ax: Axes, pair: tuple[Cycle, Cycle], names: Sequence[str]) -> None:
    m = len(names)
    if m == 1:
        _coordinate(ax, pair, 0)
        ax.set_ylabel(f"{names[0]} [m]")
        return
    plane = plane_of(pair[1].x_desired[:, :m], names)
    for cycle, label in _told_apart(pair):
        points = cycle.x[:, :m] @ plane.directions.T
        ax.plot(*_closed(points, cycle is pair[1]).T, **like(LEGEND[label]))
    desired = pair[1].x_desired[:, :m] @ plane.directions.T
    ax.plot(*_closed(desired).T, **like(LEGEND["desired"]))
    ax.plot(*desired[0], "o", color=DESIRED, ms=3)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    ax.set_xlabel(f"{plane.labels[0]} [m]")
    ax.set_ylabel(f"{plane.labels[1]} [m]")
    ax.apply_aspect()  # widens the limits, on which the ticks depend
    abscissa(ax)
    plain(ax, 6)


def _coordinate(ax: Axes, pair: tuple[Cycle, Cycle], axis: int) -> None:
    """A coordinate over the cycle, with what is desired."""
    _over_the_cycle(ax, pair, lambda one: one.x[:, axis])
    desired = pair[1].x_desired[:, axis]
    ax.plot(np.arange(len(desired)) / len(desired), desired, **like(LEGEND["desired"]))
    plain(ax)


def _over_the_cycle(
    ax: Axes, pair: tuple[Cycle, Cycle], signal: Callable[[Cycle], np.ndarray]
) -> None:
    """A signal (N,) over the cycle."""
    for cycle, label in _told_apart(pair):
        values = signal(cycle)
        ax.plot(np.arange(len(values)) / len(values), values, **like(LEGEND[label]))
    ax.set_xlim(0, 1)
    ax.set_xlabel("share of the cycle t/T [1]")


def _told_apart(pair: tuple[Cycle, Cycle]) -> list[tuple[Cycle, str]]:
    """The cycles and what the legend calls them; one that is both is the last."""
    found = [(pair[0], "first cycle"), (pair[1], "last cycle")]
    return found if pair[0].number != pair[1].number else found[1:]


def _distance(cycle: Cycle, m: int) -> np.ndarray:
    """How far the tool is from where it should be (N,) [mm]."""
    return 1e3 * np.linalg.norm(cycle.x[:, :m] - cycle.x_desired[:, :m], axis=1)


def _closed(points: np.ndarray, close: bool = True) -> np.ndarray:
    """A path (N, 2) that ends where it begins; one that is not periodic yet stays open."""
    return np.concatenate([points, points[:1]]) if close else points


def _cycles(pair: tuple[Cycle, Cycle]) -> str:
    first, last = pair
    if first.number == last.number:
        return f"motion {last.motion + 1}: cycle {last.number}"
    return f"motion {last.motion + 1}: cycles {first.number} and {last.number}"


def _errors(run: Run, pair: tuple[Cycle, Cycle]) -> str:
    """The position's error in these cycles."""
    numbers = dict.fromkeys(cycle.number for cycle in pair)
    rms = [float(run.data["tracking_rms"].sel(cycle=number)) for number in numbers]
    return "tracking RMS " + " and ".join(map(EngFormatter("m", places=1), rms))
