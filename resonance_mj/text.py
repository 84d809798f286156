"""Words and numbers as people read them."""

import difflib
import math
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from typing import Any, Self

MINUS, NARROW, NOTHING = "−", "\u202f", "–"
"""A real minus sign, the space between a number and its unit, and a number that there is not."""


class Note(str):
    """What is said of an arm, a motion or a run: a line, whole wherever a text is.

    Args:
        head: what all need to know, a short line.
        more: the rest, behind the head.
        whole: the whole line, where it is not the head and the rest.

    Attributes:
        head: alone, where notes are to be short.
    """

    head: str

    def __new__(cls, head: str, more: str = "", *, whole: str = "") -> Self:
        """The whole line."""
        note = super().__new__(cls, whole or f"{head}{more}")
        note.head = getattr(head, "head", str(head))
        return note


class Caution(Note):
    """A note that lets one expect trouble, of which users are warned."""


def shown(value: Any, longest: int = 60) -> str:
    """A value as a message shows it: lists as in a file, with their length where they are cut."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, StrEnum):
        value = str(value)
    if isinstance(value, list | tuple | Mapping) and longest < 6:
        return "[…]"
    longest = max(longest, 12)
    if isinstance(value, list | tuple):
        items: list[str] = []
        for item in value:
            items.append(shown(item, longest // 3))
            if sum(map(len, items)) + 2 * len(items) > longest:
                return f"[{', '.join(items[:-1])}, … {len(value)} in all]"
        return f"[{', '.join(items)}]"
    if isinstance(value, Mapping):
        pairs = (f"{key} = {shown(item, longest // 3)}" for key, item in value.items())
        return cut(f"{{ {', '.join(pairs)} }}" if len(value) < longest else "{ … }", longest)
    if isinstance(value, int) and value.bit_length() > 64:
        return f"an integer of {value.bit_length()} bits"
    return cut(repr(value[: longest + 1] if isinstance(value, str | bytes) else value), longest)


def cut(text: str, longest: int = 60) -> str:
    """A text that is no longer than that, with an ellipsis in its middle where it was."""
    if len(text) <= longest:
        return text
    return f"{text[: longest // 2]}…{text[len(text) - (longest - longest // 2 - 1) :]}"


def one_line(text: str, longest: int = 2000) -> str:
    """A text as a line that every terminal can show."""
    return cut(
        "".join(letter if _visible(letter) else ascii(letter)[1:-1] for letter in text), longest
    )


def _visible(letter: str) -> bool:
    return letter.isprintable() or unicodedata.category(letter) == "Zs"


def listed(names: Iterable[str], none: str = "none", most: int = 40) -> str:
    """Names in a row, the empty ones left out; of very many, the first and how many there are."""
    there = [cut(name) for name in names if name]
    more = f", … {len(there)} in all" if len(there) > most else ""
    return ", ".join(there[:most]) + more or none


def joined(parts: Sequence[str]) -> str:
    """Words in a row as in a sentence: `a, b and c`."""
    return " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def nearest(name: str, names: Iterable[str]) -> str:
    """A hint at the name that was likely meant, to be put behind a message; empty for none."""
    close = difflib.get_close_matches(name[:100], list(names), n=1)
    return f" (did you mean {close[0]!r}?)" if close else ""


def number(value: float | None, digits: int = 3) -> str:
    """A number with a fixed count of decimals, the very large ones with three digits."""
    if value is None or not math.isfinite(value):
        return NOTHING
    text = f"{value:.{digits}f}" if abs(value) < 1e6 else f"{value:.3g}"
    return text if float(text) else text.removeprefix("-")


def percent(share: float | None, digits: int = 1) -> str:
    """A share in percent."""
    text = number(None if share is None else 100 * share, digits)
    return text if text == NOTHING else f"{text}{NARROW}%"


def length(metres: float | None) -> str:
    """A length with three digits, in the unit that suits it."""
    return _scaled(metres, "m", ("", "m", "µ", "n"))


def angle(radians: float | None) -> str:
    """An angle with three digits, in the unit that suits it."""
    return _scaled(radians, "rad", ("", "m", "µ"))


def duration(seconds: float) -> str:
    """A length of time, as `12 s`, `5.2 min`, `3 h` or `12 days`."""
    for unit, size in (("years", 3.156e7), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.6g} s"


def _scaled(value: float | None, base: str, prefixes: Sequence[str]) -> str:
    """From 1 of the base unit on it is used, from 0.1 of each smaller one that."""
    if value is None or not math.isfinite(value):
        return NOTHING
    at = 0
    while value and abs(value) * 1e3**at < (0.1 if at else 1.0) and at < len(prefixes) - 1:
        at += 1
    scaled = value * 1e3**at
    digits = max(0, 2 - math.floor(math.log10(abs(scaled)))) if 1e-3 < abs(scaled) < 1e3 else 0
    return f"{scaled:.{digits}f}{NARROW}{prefixes[at]}{base}"


def minus(text: str) -> str:
    """Numbers in words with a real minus sign before them."""
    return re.sub(r"(?<![\w-])-(?=[\d.])|(?<=\de)-", MINUS, text)


def of_joint(text: str, slides: bool) -> str:
    """A text with units of a hinge joint, as it is for a joint that slides or does not."""
    if not slides:
        return text
    return text.replace("N m/rad", "N/m").replace("N m", "N").replace("rad", "m")


def told_apart(names: Sequence[str], settings: Sequence[Mapping[str, Any]]) -> list[str]:
    """Labels of runs: their names, and where these are the same the settings that differ.

    Args:
        names: of the runs.
        settings: the tables of each run's experiment.
    """
    tables = [flat(one) for one in settings]
    told = []
    for name, mine in zip(names, tables, strict=True):
        alike = [other for other, its in zip(tables, names, strict=True) if its == name]
        keys = [key for key in mine if any(one.get(key) != mine[key] for one in alike)]
        told.append(", ".join([name, *(f"{key} {_short(mine[key])}" for key in keys[:2])]))
    return [
        f"{label} ({told[: i + 1].count(label)})" if told.count(label) > 1 else label
        for i, label in enumerate(told)
    ]


def flat(value: Any, key: str = "") -> dict[str, Any]:
    """Nested tables as one with dotted keys, without the run's name and what it must show."""
    if isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value):
        value = dict(enumerate(value))
    if not isinstance(value, Mapping):
        return {key: value}
    found: dict[str, Any] = {}
    for name, item in value.items():
        if key or name not in ("name", "expect"):
            found |= flat(item, f"{key}.{name}".removeprefix("."))
    return found


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple):
        return cut(" ".join(map(_short, value[:20])), 40)
    return cut(str(value), 40)
