"""The robustness map as a picture: what each law keeps under each imperfection."""

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from ...evaluation.robustness import Cell, RobustnessMap, described, written
from ...status import Status
from ..palette import DESIRED
from .style import enlarged, if_titled, small, styled

STEPS = (0.0, 0.5, 0.9, 0.97)
"""Shares of the possible reduction at which a cell's colour changes."""

COLOURS = ("#f2c9b8", "#f7e3c0", "#d9e8d2", "#b5d8c4", "#7fc0a0")
"""From a law that costs torque to one that is as good as the optimum's springs."""

ROW, LEFT, TOP = 0.21, 2.0, 0.55
"""Height of a row, room for its name, and above the map [in]."""


@styled()
def figure(found: RobustnessMap, width: float) -> Figure:
    """A row for each imperfection and strength, a column for each law.

    Each cell has the reduction of torque² that the motors gave, in percent of what is possible, or
    how the run ended if not well.

    Args:
        found: what is drawn.
        width: of the figure [in].
    """
    laws = list(found.titles)
    rows = [found.cells[at : at + len(laws)] for at in range(0, len(found.cells), len(laws))]
    by = enlarged()
    height = by * (TOP + ROW * len(rows) + 0.15)
    drawn = Figure(figsize=(width, height))
    ax = drawn.add_axes(
        (
            by * LEFT / width,
            0.1 / height,
            1 - by * (LEFT + 0.1) / width,
            ROW * by * len(rows) / height,
        )
    )
    levels = np.array([[_level(cell) for cell in row] for row in rows])
    shades = ListedColormap(["0.88", *COLOURS])
    ax.pcolormesh(levels, cmap=shades, vmin=-1.5, vmax=len(COLOURS) - 0.5, edgecolors="white")
    ax.invert_yaxis()
    ax.grid(visible=False)
    for y, row in enumerate(rows):
        for x, cell in enumerate(row):
            ax.annotate(
                written(cell), (x + 0.5, y + 0.5), ha="center", va="center", fontsize=small()
            )
    names = [described(row[0].imperfection, row[0].strength) for row in rows]
    ax.set_yticks(np.arange(len(rows)) + 0.5, names)
    titles = ["\n".join(_broken(title)) for title in found.titles.values()]
    ax.xaxis.tick_top()
    ax.set_xticks(np.arange(len(laws)) + 0.5, titles)
    ax.tick_params(length=0)
    for side in ax.spines.values():
        side.set_visible(False)
    for y in range(1, len(rows), 3):
        ax.axhline(y, color=DESIRED, linewidth=0.5)
    if heading := if_titled(f"{found.experiment.name}: reduction kept [% of what is possible]"):
        drawn.suptitle(heading, x=0.01, ha="left")
    return drawn


def _level(cell: Cell) -> int:
    """Which colour: -1 for a run that did not come to its end on its path."""
    if cell.kept is None or cell.status != Status.OK:
        return -1
    return int(np.searchsorted(STEPS, cell.kept, side="right"))


def _broken(title: str) -> list[str]:
    """A title in lines of at most a dozen letters or so."""
    lines = [""]
    for word in title.split():
        if len(lines[-1]) + len(word) > 12 and lines[-1]:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
