"""A figure laid out in inches: heading, legend, and rows of panels with their titles.

Margins are fixed and text is measured beforehand: matplotlib's own layout draws all texts to
measure them, which takes longer than the simulation.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import chain, product
from pathlib import Path
from string import ascii_lowercase
from textwrap import wrap
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.lines import Line2D

from ...errors import PictureError
from ...results.run import Run, Status
from ...text import cut
from .style import FONT, GAP, HANDLE, HEADING, Line, enlarged, look, remark, small

EDGE, RIGHT = 0.08, 0.12
"""Above the heading, and right of the panels [in]."""

TITLE = 0.2
"""Above a panel, for its title [in]."""

LOWEST = 0.35
"""Height of the lowest panel where a height is asked for [in]."""

FINE, HINTED = 1200, 1.05
"""Dots per inch at which text is measured, and how much wider it may be on coarse pixels."""


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
        legend: what each line means, and how it is drawn; as many beside each other as fit.
        left: what numbers and label of an ordinate take [in].
        right: what is left free beside the panels [in].
        lettered: whether each panel's title begins with a letter.
    """

    def __init__(
        self,
        width: float,
        rows: Sequence[Row],
        columns: int = 1,
        *,
        heading: str,
        legend: Mapping[str, Line] | None = None,
        left: float = 0.5,
        right: float = RIGHT,
        lettered: bool = True,
    ) -> None:
        by = enlarged()
        rows = [Row(row.height, by * row.below, by * row.above) for row in rows]
        left, right, edge = by * left, by * right, by * EDGE
        self._left = left
        self._across = (width - columns * left - right) / columns
        self._beyond = min(left - 0.1, RIGHT - 0.03)  # a title may be wider than its panel
        letters = chain(ascii_lowercase, map("".join, product(ascii_lowercase, repeat=2)))
        self._letters = (f"({letter}) " if lettered else "" for letter in letters)
        lines = _wrapped(heading, width - left - RIGHT) if heading else []
        entries = _packed(legend or {}, width - left - RIGHT)
        pitch = 1.6 * small() / 72
        words = edge + 1.35 * by * HEADING / 72 * len(lines)
        self._top = words + pitch * len(entries) + 0.04
        self._rows = _as_high(rows, look().height, self._top + 0.05)
        height = self._top + sum(map(sum, self._rows)) + 0.05
        self.figure = Figure(figsize=(width, height))
        at = {"x": left / width, "y": 1 - edge / height}
        if lines:
            self.figure.suptitle("\n".join(lines), **at, ha="left", va="top", fontsize=by * HEADING)
        for number, row in enumerate(entries):
            self.figure.legend(
                [Line2D([], [], **line) for line in row.values()],
                list(row),
                loc="upper left",
                bbox_to_anchor=(left / width, 1 - (words + 0.02 + number * pitch) / height),
                ncols=len(row),
            )

    def panel(
        self,
        row: int,
        column: int,
        *wordings: str,
        name: str = "",
        notes: Sequence[str] = (),
        span: int = 1,
        down: int = 1,
    ) -> Axes:
        """Axes with a title above.

        Args:
            row: index of the (first) row.
            column: index of the (first) column.
            wordings: of the title, from long to short, with {} for `name`.
            name: of what is shown, such as a joint.
            notes: lines in small letters between title and panel.
            span: columns that it takes.
            down: rows that it takes.
        """
        width, height = self.figure.get_size_inches()
        rows = self._rows[row : row + down]
        above = self._top + sum(map(sum, self._rows[:row])) + rows[0].above
        tall = sum(map(sum, rows)) - rows[0].above - rows[-1].below
        left = self._left + column * (self._across + self._left)
        wide = span * self._across + (span - 1) * self._left
        ax = self.figure.add_axes(
            (left / width, 1 - (above + tall) / height, wide / width, tall / height)
        )
        letter, room = next(self._letters), wide + self._beyond
        pitch = 1.35 * small()  # of the notes [pt]
        titles = [letter + wording for wording in wordings]
        size = enlarged() * FONT
        if not any(width_of(title.replace("{}", name), size) <= room for title in titles):
            size = small()
        title = fitting(titles, size, room, name)
        ax.set_title(title, fontsize=size, pad=4 + pitch * len(notes))
        for line, note in enumerate(reversed(notes)):
            up = (0, 4 + pitch * line)
            text = fitting([note], small(), room)
            remark(ax, text, (0, 1), xytext=up, textcoords="offset points")
        return ax

    def alike(self, wordings: Sequence[str], names: Sequence[str]) -> Sequence[str]:
        """The wordings of a title from the first on that has room for each name.

        Args:
            wordings: from long to short, with {} for the name.
            names: in panels of one kind and one column wide, which are to be called alike.
        """
        room = self._across + self._beyond
        for i, wording in enumerate(wordings):
            titles = (f"(m) {wording.replace('{}', name)}" for name in names)
            if all(width_of(title, enlarged() * FONT) <= room for title in titles):
                return wordings[i:]
        return wordings[-1:]


def abscissa_of_the_panel_below(ax: Axes) -> None:
    """Leave out an abscissa that is that of the panel below."""
    ax.tick_params(labelbottom=False)
    ax.set_xlabel("")


def heading(run: Run) -> str:
    """What was run, under which law, and how it ended; nothing of an ok run if it is not asked."""
    if not look().titled and run.status is Status.OK:
        return ""
    law, motions = run.experiment.law, run.experiment.motion
    periods = ", ".join(
        f"{motion.cycles}\u00a0×\u00a0{motion.period:g}\u00a0s" for motion in motions
    )
    form = f" (J {law.jacobian})" if law.jacobian else ""
    return (
        f"{run.experiment.name}: {Path(run.experiment.robot.mjcf).stem}, "
        f"law {Path(law.kind).stem}{form}, cycles {periods}; {run.status}"
    )


def width_of(text: str, size: float) -> float:
    """Width of a line of text without mathematics, with a margin [in]; `size` of the font [pt]."""
    return _width(text, size, findfont(FontProperties()))


@lru_cache(maxsize=4096)
def _width(text: str, size: float, file: str) -> float:
    font = get_font(file)
    font.set_size(size, FINE)
    font.set_text(text)
    return HINTED * float(font.get_width_height()[0]) / 64 / FINE


def fitting(wordings: Sequence[str], size: float, width: float, name: str = "") -> str:
    """The first of some wordings that fits; where none does the last, cut, or its name cut.

    Args:
        wordings: from long to short, with {} where the name is put.
        size: of the font [pt].
        width: there is [in].
        name: such as a joint's, which may be long.
    """
    frame, whole = (wordings[-1], name) if "{}" in wordings[-1] else ("{}", wordings[-1])
    shortened = (cut(whole, length) for length in range(len(whole) - 1, 0, -1))
    texts = [wording.replace("{}", name) for wording in wordings]
    for text in chain(texts, (frame.replace("{}", short) for short in shortened)):
        if width_of(text, size) <= width:
            break
    return text


def _wrapped(heading: str, width: float) -> list[str]:
    """A heading as lines that fit `width` [in]."""
    for longest in range(max(len(heading), 10), 9, -1):
        lines = wrap(heading, longest) or [""]
        if all(width_of(line, enlarged() * HEADING) <= width for line in lines):
            break
    return lines


def _as_high(rows: Sequence[Row], height: float | None, besides: float) -> list[Row]:
    """Rows with panels that together make a figure so high [in], of which `besides` is not theirs.

    Raises:
        PictureError: its panels would be too low to be read.
    """
    if height is None:
        return list(rows)
    fixed = besides + sum(row.below + row.above for row in rows)
    panels = sum(row.height for row in rows)
    lowest = fixed + LOWEST * panels / min(row.height for row in rows)
    if height < lowest:
        raise PictureError(
            f"height {height:g}: this figure's panels need at least {lowest:.1f} in at this width"
        )
    return [row._replace(height=row.height * (height - fixed) / panels) for row in rows]


def _packed(legend: Mapping[str, Line], room: float) -> list[dict[str, Line]]:
    """The entries of a legend in rows, as many in each as there is room for [in]."""
    rows: list[dict[str, Line]] = []
    used, handle, gap = room, (HANDLE + 0.5) * small() / 72, GAP * small() / 72
    for label, line in legend.items():
        shown = fitting(["{}"], small(), room - handle, label)
        wide = width_of(shown, small()) + handle
        if used + wide > room:
            rows.append({})
            used = 0.0
        rows[-1][shown] = line
        used += wide + gap
    return rows
