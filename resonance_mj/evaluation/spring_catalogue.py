"""Springs that can be bought: which of a catalogue leaves the motors least, joint by joint."""

from __future__ import annotations

import csv
import math
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import OutputError
from ..files import read_text
from ..springs.bounds import JointBounds
from ..springs.fit import fit
from ..text import listed, shown
from .spring_parts import SpringParts

COLUMNS = ("part", "rate", "torque", "travel")
"""Columns that a catalogue has; price may stand beside them."""


class Bought(NamedTuple):
    """A spring that can be bought, mounted at any rest angle."""

    part: str
    rate: float
    """Stiffness [N m/rad]."""
    torque: float
    """Largest torque that it bears [N m]."""
    travel: float
    """Furthest that it may be turned from rest [rad]."""
    price: float
    """0 if the catalogue has none."""


class Choice(NamedTuple):
    """The best part for a joint in a motion."""

    motion: int
    joint: str
    part: Bought | None
    """None where none bears the motion, or none leaves less than no spring."""
    rest: float
    """Rest angle at which it is mounted [rad]."""
    left: float
    """Mean square of the motor's torque with it [N² m²]."""
    without: float
    """The same without a spring [N² m²]."""
    best: float
    """The same with the best spring within its bounds [N² m²]."""


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
    found = []
    for line, row in enumerate(rows, start=2):
        numbers = {
            name: _number(row.get(name), f"{path}: line {line}: {name}")
            for name in (*COLUMNS[1:], *(("price",) if "price" in header else ()))
        }
        found.append(Bought(str(row["part"]).strip(), **{"price": 0.0} | numbers))
    if not found:
        raise OutputError(f"{path}: has no parts, only a header")
    return tuple(found)


def choices(found: SpringParts, catalogue: tuple[Bought, ...]) -> tuple[Choice, ...]:
    """The part of a catalogue for each joint and motion that leaves the motor least.

    Each part is tried on each joint at the rest angle that is best for it: torque² is a sum over
    joints, so that this is the best of all combinations. Of parts that are equally good the
    cheapest is taken. Elements over several joints stay as the run's optimum has them.
    """
    return tuple(
        _choice(motion.motion, joint, motion.q[:, j], motion.needed[:, j], catalogue, float(left))
        for motion in found.motions
        for j, (joint, left) in enumerate(zip(found.joints, motion.rms[1] ** 2, strict=True))
    )


def _choice(
    motion: int,
    joint: str,
    q: np.ndarray,
    needed: np.ndarray,
    catalogue: tuple[Bought, ...],
    best: float,
) -> Choice:
    without = float((needed**2).mean())
    found = Choice(motion, joint, None, math.nan, without, without, best)
    for part in catalogue:
        rate = np.array([part.rate])
        free = np.array([-np.inf]), np.array([np.inf])
        bounds = JointBounds((rate, rate), free, np.array([False]))
        spring = fit(q[:, None], needed[:, None], bounds, np.zeros(1))
        exerted = spring.torque(q[:, None])[:, 0]
        rest = float(spring.offset[0] / part.rate)
        if np.abs(exerted).max() > part.torque or np.abs(q - rest).max() > part.travel:
            continue
        left = float(((needed - exerted) ** 2).mean())
        price = found.part.price if found.part else 0.0
        if (left, part.price) < (found.left, price):
            found = found._replace(part=part, rest=rest, left=left)
    return found


def _number(cell: object, where: str) -> float:
    try:
        value = float(str(cell))
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0 and (value > 0 or where.endswith("price"))):
        raise OutputError(f"{where} = {shown(cell)}: a number above 0 is needed")
    return value
