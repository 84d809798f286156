"""How all figures look: fonts that can be read in print, thin axes, text that stays text."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from threading import RLock
from typing import Any, NamedTuple

import matplotlib
from matplotlib.axes import Axes

from ..palette import DESIRED, MEASURED, MUTED, NOTE, OPTIMAL, SERIES

FONT, SMALL, HEADING = 8.0, 7.0, 9.0
"""Sizes of titles and labels, of numbers at the axes and remarks, and of the heading [pt], where no
other size of the first is asked for."""

HANDLE, GAP = 1.8, 1.4
"""Length of a legend's line, and space between its columns, in font sizes."""

LABEL_BOX = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 1}
"""Behind words that stand on lines."""

Line = Mapping[str, Any]
"""How a line is drawn, in matplotlib's words."""

BAND: Line = {"color": OPTIMAL, "alpha": 0.2}
"""What counts as at the optimum."""

STYLE: Any = {
    "font.size": FONT,
    "text.parse_math": False,  # a joint may be called $\bad$
    "axes.titlesize": FONT,
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # given, or matplotlib measures every text above the axes to find it
    "axes.titlepad": 4,
    "axes.labelsize": SMALL,
    "axes.labelpad": 1,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.major.pad": 2,
    "ytick.major.pad": 2,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.fontsize": SMALL,
    "legend.borderaxespad": 0.0,
    "legend.borderpad": 0.0,
    "legend.handlelength": HANDLE,
    "legend.handletextpad": 0.5,
    "legend.columnspacing": GAP,
    "svg.fonttype": "none",
    "svg.hashsalt": "resonance-mj",  # the same figure gives the same file
    "pdf.fonttype": 42,  # TrueType, embedded: journals refuse matplotlib's Type 3
}

SIZES = (
    *("font.size", "axes.titlesize", "axes.labelsize", "xtick.labelsize", "ytick.labelsize"),
    *("legend.fontsize", "axes.titlepad"),
)
"""Those that follow the size of letters."""

LINES: Mapping[str, Line] = {
    "measured": {"color": MEASURED},
    "desired": {"color": DESIRED, "linestyle": "--"},
    "with optimal springs": {"color": OPTIMAL, "linestyle": "--"},
    "without springs": {"color": MUTED, "linestyle": ":"},
}
"""What lines mean in every figure, and how each is drawn."""

_DRAWING = RLock()


class Look(NamedTuple):
    """What a journal may ask of a figure.

    Attributes:
        titled: whether what was run stands above it.
        font: family of its letters; matplotlib's own if None.
        font_size: of titles and labels [pt]; all other sizes follow.
        height: of the figure [in]; what its panels need if None.
    """

    titled: bool = False
    font: str | None = None
    font_size: float = FONT
    height: float | None = None


USUAL = Look()
_LOOK = ContextVar("look", default=USUAL)


def look() -> Look:
    """How what is being drawn is to look."""
    return _LOOK.get()


def if_titled(text: str) -> str:
    """A heading where one is asked for, else nothing."""
    return text if look().titled else ""


def enlarged() -> float:
    """How much larger letters are than usual, and with them all that they need room for."""
    return look().font_size / FONT


def small() -> float:
    """Size of numbers at the axes and of remarks [pt]."""
    return SMALL * enlarged()


def one_of(i: int) -> Line:
    """How the line of one of many joints or runs is drawn: the dashes change when colours recur."""
    again, colour = divmod(i, len(SERIES))
    return {"color": SERIES[colour], "linestyle": ("-", "--", ":", "-.")[again % 4]}


def remark(ax: Axes, text: str, at: tuple[float, float], **settings: Any) -> None:
    """Write small print at a place, in shares of the panel if nothing else is told."""
    usual = {"xycoords": "axes fraction", "color": NOTE, "fontsize": small()}
    ax.annotate(text, at, **{**usual, **settings})


@contextmanager
def styled(settings: Any = STYLE, asked: Look | None = None) -> Iterator[None]:
    """Draw or write in a style, one thread at a time: matplotlib has one for the whole process.

    Args:
        settings: matplotlib's, by name.
        asked: how it is to look; as what is being drawn around it if None.
    """
    asked = asked or look()
    by_size = {name: settings[name] for name in SIZES if name in settings}
    more: Any = {name: value * asked.font_size / FONT for name, value in by_size.items()}
    if asked.font:
        more["font.family"] = [asked.font]
    token = _LOOK.set(asked)
    try:
        with _DRAWING, matplotlib.rc_context({**settings, **more}):
            yield
    finally:
        _LOOK.reset(token)
