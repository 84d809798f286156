"""What a user may ask of how a figure looks: sizes and letters, and what is valid."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import PictureError
from ...text import listed, nearest, shown

if TYPE_CHECKING:
    from .style import Look

COLUMN, PAGE = 3.5, 7.16
"""Widths of a column and of a page with two columns in IEEE's journals [in]."""

NARROWEST, WIDEST = 3.0, 20.0
"""Widths of a figure [in]."""

LOWEST, SMALLEST, LARGEST = 1.0, 5.0, 16.0
"""Least height of a figure [in], and sizes of its letters [pt]."""

GENERIC = ("serif", "sans-serif", "monospace")
"""Families of which matplotlib chooses the font."""


def inches(width: str | float) -> float:
    """A width that a user gave [in]."""
    try:
        found = float({"column": COLUMN, "page": PAGE}.get(str(width), width))
    except (TypeError, ValueError):
        found = float("nan")
    if not NARROWEST <= found <= WIDEST:
        raise PictureError(
            f"width {shown(width)}: give column, page, or inches from {NARROWEST:g} to {WIDEST:g}"
        )
    return found


def look(height: float | None, title: bool, font: str | None, size: float) -> Look:
    """What a user asks of a figure."""
    from matplotlib.font_manager import fontManager

    from .style import Look

    if height is not None and not LOWEST <= height <= WIDEST:
        raise PictureError(f"height {shown(height)}: give inches from {LOWEST:g} to {WIDEST:g}")
    if not SMALLEST <= size <= LARGEST:
        raise PictureError(f"font size {shown(size)}: give points from {SMALLEST:g} to {LARGEST:g}")
    known = [*GENERIC, *sorted({one.name for one in fontManager.ttflist})]
    if font is not None and font not in known:
        there = f"{nearest(font, known)}; there are {listed(known)}"
        raise PictureError(f"font {shown(font)} is not installed{there}")
    return Look(title, font, size, height)
