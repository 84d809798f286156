"""A figure laid out in inches: heading, legend, and rows of panels.

Margins are fixed and text is measured beforehand: matplotlib's own layout draws all texts to
measure them, which takes longer than the simulation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..palette import NOTE
from .style import FONT, HEADING, SMALL, breadth
from .text import fitting, width_of, wrapped

EDGE, RIGHT = 0.08, 0.12
"""Above the heading, and right of the panels [in]."""

TITLE = 0.2
"""Above a panel, for its title [in]."""

HANDLE, GAP = 1.8, 1.4
"""Length of a legend's line, and space between its columns, in font sizes."""


class Row(NamedTuple):
    """A row of panels."""

    height: float
    """Of the panels [in]."""
    below: float = 0.32
    """What numbers and label of the abscissa take [in]."""
    above: float = TITLE
    """What the panels' titles take [in]."""


class Sheet:
    """A figure with panels in rows and columns.

    Args:
        width: of the figure [in].
        rows: of panels, from above.
        columns: of panels.
        heading: wrapped to the width.
        legend: handles by what they mean; as many beside each other as there is room for.
        left: what numbers and label of an ordinate take [in].
        right: what is left free beside the panels [in].
    """

    def __init__(
        self,
        width: float,
        rows: Sequence[Row],
        columns: int,
        *,
        heading: str,
        legend: Mapping[str, Line2D] | None = None,
        left: float = 0.5,
        right: float = RIGHT,
    ) -> None:
        self._rows, self._left = rows, left
        self._across = (width - columns * left - right) / columns
        lines = wrapped(heading, HEADING, width - left - RIGHT)
        entries = _packed(legend or {}, width - left - RIGHT)
        line, small = 1.35 * HEADING / 72, 1.6 * SMALL / 72
        words = EDGE + line * len(lines)
        self._top = words + small * len(entries) + 0.04
        height = self._top + sum(sum(row) for row in rows) + 0.05
        self.figure = Figure(figsize=(width, height))
        self.figure.suptitle(
            "\n".join(lines),
            x=left / width,
            y=1 - EDGE / height,
            ha="left",
            va="top",
            fontsize=HEADING,
        )
        for number, row in enumerate(entries):
            self.figure.legend(
                list(row.values()),
                list(row),
                loc="upper left",
                bbox_to_anchor=(left / width, 1 - (words + 0.02 + number * small) / height),
                ncols=len(row),
                borderaxespad=0,
                borderpad=0,
                handlelength=HANDLE,
                handletextpad=0.5,
                columnspacing=GAP,
            )

    def panel(self, row: int, column: int = 0, span: int = 1, down: int = 1) -> Axes:
        """Axes in a row and a column.

        Args:
            row: index of the (first) row.
            column: index of the (first) column.
            span: columns that it takes.
            down: rows that it takes.
        """
        width, height = self.figure.get_size_inches()
        above = self._top + sum(sum(each) for each in self._rows[:row]) + self._rows[row].above
        last = self._rows[row + down - 1]
        tall = sum(sum(each) for each in self._rows[row : row + down])
        tall -= self._rows[row].above + last.below
        left = self._left + column * (self._across + self._left)
        wide = span * self._across + (span - 1) * self._left
        return self.figure.add_axes(
            (left / width, 1 - (above + tall) / height, wide / width, tall / height)
        )

    @property
    def room(self) -> float:
        """Width that every panel has for its title, those at the right edge too [in]."""
        return self._across + min(self._left - 0.1, RIGHT - 0.03)

    def title(self, ax: Axes, *wordings: str, notes: Sequence[str] = ()) -> None:
        """Write above a panel, in the longest wording that fits.

        Args:
            ax: the panel.
            wordings: from long to short.
            notes: lines in small letters between title and panel.
        """
        room = breadth(ax) + self._left - 0.1  # the gap to the next panel, but for a space
        right = (1 - float(ax.get_position().x0)) * float(self.figure.get_size_inches()[0])
        room = min(room, right - 0.03)
        pitch = 1.35 * SMALL  # of the notes [pt]
        ax.set_title(fitting(wordings, FONT, room), pad=4 + pitch * len(notes))
        for line, note in enumerate(reversed(notes)):
            ax.annotate(
                fitting([note], SMALL, room),
                (0, 1),
                xytext=(0, 4 + pitch * line),
                xycoords="axes fraction",
                textcoords="offset points",
                fontsize=SMALL,
                color=NOTE,
            )


def _packed(legend: Mapping[str, Line2D], room: float) -> list[dict[str, Line2D]]:
    """The entries of a legend in rows, as many in each as there is room for [in]."""
    rows: list[dict[str, Line2D]] = []
    size, used = SMALL / 72, room
    for label, line in legend.items():
        wide = width_of(label, SMALL) + (HANDLE + 0.5) * size
        if used + wide > room:
            rows.append({})
            used = 0.0
        rows[-1][label] = line
        used += wide + GAP * size
    return rows
