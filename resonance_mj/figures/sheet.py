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
    ) -> None:
        self._rows, self._left = rows, left
        self._across = (width - columns * left - RIGHT) / columns
        lines = wrapped(heading, HEADING, width - left - RIGHT)
        legend = legend or {}
        per_row = self._beside(legend, width - left - RIGHT)
        line, small = 1.35 * HEADING / 72, 1.6 * SMALL / 72
        words = EDGE + line * len(lines)
        self._top = words + small * -(-len(legend) // per_row) + 0.04
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
        if legend:
            # Filled row by row: matplotlib fills a legend column by column.
            order = [i for c in range(per_row) for i in range(c, len(legend), per_row)]
            self.figure.legend(
                [list(legend.values())[i] for i in order],
                [list(legend)[i] for i in order],
                loc="upper left",
                bbox_to_anchor=(left / width, 1 - (words + 0.02) / height),
                ncols=per_row,
                borderaxespad=0,
                borderpad=0,
                labelspacing=0.35,
                handlelength=HANDLE,
                handletextpad=0.5,
                columnspacing=GAP,
            )

    def panel(self, row: int, column: int = 0, span: int = 1) -> Axes:
        """Axes in a row and a column.

        Args:
            row: index of the row.
            column: index of the (first) column.
            span: columns that it takes.
        """
        width, height = self.figure.get_size_inches()
        above = self._top + sum(sum(each) for each in self._rows[:row]) + self._rows[row].above
        tall = self._rows[row].height
        left = self._left + column * (self._across + self._left)
        wide = span * self._across + (span - 1) * self._left
        return self.figure.add_axes(
            (left / width, 1 - (above + tall) / height, wide / width, tall / height)
        )

    def title(self, ax: Axes, *wordings: str) -> None:
        """Write above a panel, in the longest wording that fits."""
        room = breadth(ax) + self._left - 0.1  # the gap to the next panel, but for a space
        right = (1 - float(ax.get_position().x0)) * float(self.figure.get_size_inches()[0])
        ax.set_title(fitting(wordings, FONT, min(room, right - 0.03)))

    @staticmethod
    def _beside(legend: Mapping[str, Line2D], room: float) -> int:
        """How many entries of a legend fit beside each other."""
        size = SMALL / 72
        each = [width_of(label, SMALL) + (HANDLE + 0.5 + GAP) * size for label in legend]
        widest = max(each, default=0.0)
        return max(1, min(len(legend), int((room + GAP * size) / widest) if widest else 1))
