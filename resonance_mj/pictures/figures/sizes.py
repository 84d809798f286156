"""How wide and how fine a figure is, and as what it is written."""

from __future__ import annotations

from collections.abc import Sequence

from ...errors import PictureError
from ...text import shown

COLUMN, PAGE = 3.5, 7.16
"""Widths of a column and of a page with two columns in IEEE's journals [in]."""

NARROWEST, WIDEST = 3.0, 20.0
KINDS, FORMATS = ("svg", "png", "pdf"), ("svg", "png")
"""As what a figure can be written, and is if nothing else is asked for."""

DPI, DRAFT = 300.0, 170.0
"""Pixels per inch of a PNG, and of the one that each run leaves: in print, and on a screen."""

COARSEST, FINEST = 50, 1200


def inches(width: str | float) -> float:
    """A width that a user gave [in].

    Args:
        width: "column", "page", or inches as a number or in words, such as "5.5".

    Raises:
        PictureError: it is none of these, or too narrow or too wide to draw in.
    """
    try:
        found = float({"column": COLUMN, "page": PAGE}.get(str(width), width))
    except (TypeError, ValueError):
        found = float("nan")
    if not NARROWEST <= found <= WIDEST:
        raise PictureError(
            f"width {shown(width)}: give column, page, or inches from {NARROWEST:g} to {WIDEST:g}"
        )
    return found


def kinds(formats: Sequence[str]) -> list[str]:
    """The formats that a user gave, each once.

    Raises:
        PictureError: one of them is unknown, or none is given.
    """
    unknown = [kind for kind in formats if kind not in KINDS]
    if unknown or not formats:
        what = f"format {shown(unknown[0])} is unknown" if unknown else "no format is given"
        raise PictureError(f"{what}; there are {', '.join(KINDS)}")
    return list(dict.fromkeys(formats))


def fine(dpi: float) -> float:
    """A resolution that a user gave [pixels per inch].

    Raises:
        PictureError: it is too coarse or too fine.
    """
    if not COARSEST <= dpi <= FINEST:
        raise PictureError(f"dpi {dpi:g}: give pixels per inch from {COARSEST} to {FINEST}")
    return dpi
