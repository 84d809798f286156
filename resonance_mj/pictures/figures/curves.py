"""Where the curves of a figure are and what they mean, so that a page can read values off them."""

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from .time_axes import pieces


def curves(figure: Figure) -> list[dict[str, Any]]:
    """Of each panel where it is, its scales, and its curves, by ids that the SVG will have.

    A panel's `box` is left, right, top and bottom [points from the top left]; `x` and `y` are the
    ends of its scales and whether they are logarithmic, or of a broken time axis its pieces.
    """
    width, height = 72 * figure.get_size_inches()
    names = _legend(figure)
    found = []
    for number, ax in enumerate(figure.axes):
        box = ax.get_position()
        ids = {}
        for index, drawn in enumerate(_drawn(ax)):
            drawn.set_gid(f"curve{number}-{index}")
            ids[f"curve{number}-{index}"] = names.get(_look(drawn), "")
        if ids:
            found.append(
                {
                    "box": [
                        *(round(float(width * at), 3) for at in (box.x0, box.x1)),
                        *(round(float(height * (1 - at)), 3) for at in (box.y1, box.y0)),
                    ],
                    "x": [*ax.get_xlim(), ax.get_xscale() == "log"],
                    "y": [*ax.get_ylim(), ax.get_yscale() == "log"],
                    "times": pieces(ax) if ax.get_xlabel().startswith("time") else [],
                    "of": ax.get_xlabel(),
                    "title": ax.get_title(loc="left") or ax.get_ylabel(),
                    "curves": ids,
                }
            )
    return found


def _drawn(ax: Axes) -> list[Artist]:
    """Curves that have values: lines of at least two points in the data's own coordinates."""
    lines: list[Artist] = [
        line
        for line in ax.lines
        if line.get_transform() == ax.transData and np.size(line.get_xdata()) > 1
    ]
    return lines + [one for one in ax.collections if isinstance(one, LineCollection)]


def _look(drawn: Artist) -> tuple[str, str]:
    """Colour and dashes, by which the legend tells curves apart."""
    if isinstance(drawn, LineCollection):
        colour: Any = drawn.get_color()
        return to_hex(colour[0]), _dashes(drawn.get_linestyle()[0])
    line: Any = drawn
    return to_hex(line.get_color()), _dashes(line._unscaled_dash_pattern)


def _dashes(pattern: Any) -> str:
    _, lengths = pattern
    return "solid" if lengths is None else f"{len(lengths)}-{'dots' if lengths[0] < 1.5 else ''}"


def _legend(figure: Figure) -> dict[tuple[str, str], str]:
    """What a legend says of each look."""
    return {
        _look(handle): text.get_text()
        for legend in figure.legends
        for handle, text in zip(legend.get_lines(), legend.get_texts(), strict=False)
    }
