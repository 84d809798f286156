"""How much room text takes, known before anything is drawn."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from textwrap import wrap

from matplotlib.font_manager import FontProperties, findfont, get_font

FINE, HINTED = 1200, 1.05
"""Dots per inch at which text is measured, and how much wider it may be on coarse pixels."""


@lru_cache(maxsize=4096)
def width_of(text: str, size: float) -> float:
    """Width of a line in the default font, with a margin [in].

    Args:
        text: without mathematics.
        size: of the font [pt].
    """
    font = get_font(findfont(FontProperties()))
    font.set_size(size, FINE)
    font.set_text(text)
    width, _ = font.get_width_height()
    return HINTED * float(width) / 64 / FINE


def fitting(candidates: Iterable[str], size: float, width: float) -> str:
    """The first of some wordings, from long to short, that fits; the last one cut if none does.

    Args:
        candidates: wordings.
        size: of the font [pt].
        width: there is [in].
    """
    text = ""
    for text in candidates:
        if width_of(text, size) <= width:
            return text
    while len(text) > 1 and width_of(text + "…", size) > width:
        text = text[:-1]
    return text + "…"


def naming(wordings: Iterable[str], name: str) -> Iterator[str]:
    """Wordings with a name put in, and the last of them with ever less of the name.

    Args:
        wordings: from long to short, with {} for the name.
        name: such as a joint's, which may be long.
    """
    wording = "{}"
    for wording in wordings:
        yield wording.format(name)
    for length in range(len(name) - 1, 0, -1):
        yield wording.format(name[:length] + "…")


def alike(
    wordings: Sequence[str], names: Sequence[str], size: float, width: float
) -> Sequence[str]:
    """The wordings of a panel's title from the first on that has room for each of some names.

    Args:
        wordings: from long to short, with {} for a name.
        names: that stand in panels of one kind, which are to be called alike.
        size: of the font [pt].
        width: there is [in].
    """
    for i, wording in enumerate(wordings):
        if all(width_of(f"(m) {wording.format(name)}", size) <= width for name in names):
            return wordings[i:]
    return wordings[-1:]


def wrapped(text: str, size: float, width: float) -> list[str]:
    """A text as lines that fit.

    Args:
        text: of one paragraph.
        size: of the font [pt].
        width: there is [in].
    """
    longest = len(text)
    while True:
        lines = wrap(text, longest) or [""]
        if longest <= 10 or all(width_of(line, size) <= width for line in lines):
            return lines
        longest -= 1
