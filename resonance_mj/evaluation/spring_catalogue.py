"""A catalogue of springs that can be bought, as a CSV file."""

from __future__ import annotations

import csv
import math
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from ..errors import OutputError
from ..files import read_text
from ..text import listed, shown

COLUMNS = ("part", "rate", "torque", "travel")
"""Columns that a catalogue has; those of `OPTIONAL` may stand beside them."""

OPTIONAL = ("price", "least_preload", "most_preload", "fits")


class Bought(NamedTuple):
    """A spring that can be bought. Units are those of a joint, or of an element's length."""

    part: str
    rate: float
    """Stiffness [N m/rad]."""
    torque: float
    """Largest torque that it bears [N m]."""
    travel: float
    """Furthest that it may be turned from rest [rad]."""
    price: float = 0.0
    preload: tuple[float, float] = (-math.inf, math.inf)
    """Least and greatest torque that it can be mounted to exert at home [N m]."""
    fits: tuple[str, ...] = ()
    """Names of the joints and elements that it fits; all if empty."""

    def rests(self, low: float, high: float, home: float) -> tuple[float, float] | None:
        """Between which angles it may rest on a joint that moves from low to high [rad].

        Returns:
            None where it would be loaded or turned further than it bears, wherever it rests.
        """
        away = min(self.travel, self.torque / self.rate)
        first, last = (home + torque / self.rate for torque in self.preload)
        least, most = max(high - away, first), min(low + away, last)
        return (least, most) if least <= most else None


def read(path: Path) -> tuple[Bought, ...]:
    """A catalogue from a CSV file with a header.

    Raises:
        OutputError: it cannot be read, lacks a column, or a cell is no number that is valid there.
    """
    text = read_text(str(path), needed=f"a CSV file with the columns {listed(COLUMNS)} is needed")
    rows = csv.DictReader(StringIO(text))
    header = [(name or "").strip() for name in rows.fieldnames or ()]
    rows.fieldnames = header
    if missing := [name for name in COLUMNS if name not in header]:
        raise OutputError(
            f"{path}: has no column {listed(missing)}; its columns are {listed(header, 'none')}"
        )
    found = [_part(row, header, f"{path}: line {line}") for line, row in enumerate(rows, start=2)]
    if not found:
        raise OutputError(f"{path}: has no parts, only a header")
    return tuple(found)


def _part(row: dict[str, str], header: list[str], where: str) -> Bought:
    rate, torque, travel = (_number(row[name], f"{where}: {name}") for name in COLUMNS[1:])
    price = _number(row["price"], f"{where}: price", least=0.0) if "price" in header else 0.0
    ends = []
    for name, none in (("least_preload", -math.inf), ("most_preload", math.inf)):
        given = (row.get(name) or "").strip()
        ends.append(_number(given, f"{where}: {name}", least=-math.inf) if given else none)
    if ends[0] > ends[1]:
        raise OutputError(
            f"{where}: least_preload = {ends[0]:g} is above most_preload = {ends[1]:g}"
        )
    fits = tuple((row.get("fits") or "").split())
    name = str(row["part"]).strip()
    return Bought(name, rate, torque, travel, price, (ends[0], ends[1]), fits)


def _number(cell: object, where: str, least: float | None = None) -> float:
    """A finite number of at least so much, or above 0."""
    try:
        value = float(str(cell))
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or (value <= 0 if least is None else value < least):
        what = {None: "a number above 0", 0.0: "a number of 0 or more"}.get(least, "a number")
        raise OutputError(f"{where} = {shown(cell)}: {what} is needed")
    return value
