"""Numbers as a page shows them: a text to read, and the value itself for programs."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

MINUS, NARROW = "−", "\u202f"
"""A real minus sign, and the space between a number and its unit."""


class Number(NamedTuple):
    """A number of a run."""

    value: float | int | None
    """As in summary.json; None where the run did not come so far."""
    text: str
    """As it is read."""


def plain(value: float | None, digits: int = 3) -> Number:
    """A number with a fixed count of decimals; the very large ones with three digits."""
    if value is None or not math.isfinite(value):
        return Number(None, "–")
    text = f"{value:.{digits}f}" if abs(value) < 1e6 else f"{value:.3g}"
    if not float(text):
        text = text.removeprefix("-")
    return Number(value, text.replace("-", MINUS))


def percent(share: float | None) -> Number:
    """A share in percent."""
    number = plain(None if share is None else 100 * share, 1)
    return Number(share, f"{number.text}{NARROW}%") if number.value is not None else number


def length(metres: float | None) -> Number:
    """A length with three digits, in the unit that suits it."""
    return _scaled(metres, (("m", 1.0), ("mm", 1e-4), ("µm", 1e-7), ("nm", 0.0)), "m")


def angle(radians: float | None) -> Number:
    """An angle with three digits, in the unit that suits it."""
    return _scaled(radians, (("rad", 1.0), ("mrad", 1e-4), ("µrad", 0.0)), "rad")


def _scaled(value: float | None, units: tuple[tuple[str, float], ...], base: str) -> Number:
    if value is None or not math.isfinite(value):
        return Number(None, "–")
    unit = next(name for name, least in units if value >= least)
    scale = {base: 1.0, f"m{base}": 1e3, f"µ{base}": 1e6, f"n{base}": 1e9}[unit]
    shown = value * scale
    digits = max(0, 2 - math.floor(math.log10(shown))) if 1e-3 < shown < 1e3 else 0
    return Number(value, f"{shown:.{digits}f}{NARROW}{unit}")


def minus(text: str) -> str:
    """Numbers in words with a real minus sign before them."""
    return re.sub(r"(?<![\w-])-(?=[\d.])", MINUS, text)


def listed(parts: list[str]) -> str:
    """Words in a row: `a, b and c`."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def seconds(value: float) -> str:
    """A time of a run."""
    return f"{value:.6g}{NARROW}s"
