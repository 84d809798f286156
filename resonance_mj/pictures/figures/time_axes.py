"""Which abscissae of a figure are times, so that a page can show a moment in it."""

from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure


class Piece(NamedTuple):
    """A part of an abscissa: a span of the run [s], and where it begins and ends on the axis."""

    begin: float
    end: float
    left: float
    right: float


_NAME = "resonance_mj_times"


def timed(ax: Axes, pieces: Sequence[Piece]) -> None:
    """Say of an axis where which times of the run are."""
    setattr(ax, _NAME, tuple(pieces))


def pieces(ax: Axes) -> Sequence[Piece]:
    """What was said of an axis."""
    found: Sequence[Piece] = getattr(ax, _NAME, ())
    return found


def times(figure: Figure) -> list[list[float]]:
    """Of each piece begin and end [s], left, right, top and bottom [points from the top left]."""
    width, height = 72 * figure.get_size_inches()
    found = []
    for ax in figure.axes:
        low, high = ax.get_xlim()
        box = ax.get_position()
        for begin, end, left, right in pieces(ax):
            x = [width * (box.x0 + box.width * (at - low) / (high - low)) for at in (left, right)]
            y = [height * (1 - at) for at in (box.y1, box.y0)]
            found.append([round(float(value), 3) for value in (begin, end, *x, *y)])
    return found
