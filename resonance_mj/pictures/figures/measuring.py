"""How much room text takes, known before anything is drawn."""

from collections.abc import Sequence
from functools import lru_cache
from textwrap import wrap

from matplotlib.font_manager import FontProperties, findfont, get_font

from ...text import cut

FINE, HINTED = 1200, 1.05
"""Dots per inch at which text is measured, and how much wider it may be on coarse pixels."""


@lru_cache(maxsize=4096)
def width_of(text: str, size: float) -> float:
    """Width of a line of text without mathematics, with a margin [in]; `size` of the font [pt]."""
    font = get_font(findfont(FontProperties()))
    font.set_size(size, FINE)
    font.set_text(text)
    width, _ = font.get_width_height()
    return HINTED * float(width) / 64 / FINE


def fitting(wordings: Sequence[str], size: float, width: float, name: str = "") -> str:
    """The first of some wordings that fits; where none does the last, cut, or its name cut.

    Args:
        wordings: from long to short, with {} where the name is put.
        size: of the font [pt].
        width: there is [in].
        name: such as a joint's, which may be long.
    """
    for wording in wordings:
        text = wording.replace("{}", name)
        if width_of(text, size) <= width:
            return text
    whole, frame = (name, wordings[-1]) if "{}" in wordings[-1] else (text, "{}")
    for length in range(len(whole) - 1, 0, -1):
        text = frame.replace("{}", cut(whole, length))
        if width_of(text, size) <= width:
            break
    return text


def wrapped(text: str, size: float, width: float) -> list[str]:
    """A paragraph as lines that fit `width` [in]; `size` of the font [pt]."""
    longest = len(text)
    while True:
        lines = wrap(text, longest) or [""]
        if longest <= 10 or all(width_of(line, size) <= width for line in lines):
            return lines
        longest -= 1
