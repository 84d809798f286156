"""A CSV of waypoints as a closed curve: what is valid in it, and the periodic cubic spline."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ExperimentError
from ..files import read_text
from ..text import cut, shown

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

JUMP = 5.0
"""The step over the seam may be this many times the largest other step between two rows."""

FEWEST, MOST = 3, 100_000
"""Waypoints that a cycle may have."""

LARGEST = 1e6
"""Size up to which a number is valid."""

UNITS = {"t": "s", "phase": "cycles", "x": "m", "y": "m", "z": "m"}
"""Of a column; the others are rotations [rad]."""


def read(file: str, axes: tuple[str, ...], period: float, name: str) -> CubicSpline:
    """The closed curve x(phase) through a CSV's waypoints, smooth to the second derivative.

    A header names the columns: each of the task's positions, its rotation if the tool is to turn,
    and `t` [s] or `phase` [cycles] if the rows are not equally spaced over the cycle; without a
    header the columns are the task's coordinates in order. The cycle begins with the first row.
    A last row that repeats the first closes the cycle; without one, the curve goes on to the first.
    Lines that begin with # are comments.

    Args:
        file: path of the CSV.
        axes: the task's coordinates, in whose order the waypoints are returned.
        period: cycle time [s].
        name: how messages call the motion.

    Raises:
        ExperimentError: the file cannot be read, or a row, a column or the seam is not valid.
    """
    where = f"{name}: {cut(file, 200)}"
    lines = _lines(file, name)
    if not lines:
        raise ExperimentError(f"{where}: has no rows; at least {FEWEST} waypoints are needed")
    first, cells = lines[0]
    top = f"{where}: line {first}"
    if any(map(_is_number, cells)):
        columns = _in_order(cells, axes, top)
        _row(cells, columns, top, quoted=False)
    else:
        columns = _header(cells, axes, top)
        del lines[0]
    if len(lines) > MOST:
        raise ExperimentError(f"{where}: has {len(lines)} waypoints; at most {MOST} are valid")
    rows = np.array([_row(cells, columns, f"{where}: line {at}") for at, cells in lines])
    if len(rows) < FEWEST:
        rows_are = "is 1 row" if len(rows) == 1 else f"are {len(rows)} rows"
        raise ExperimentError(
            f"{where}: there {rows_are} of numbers; at least {FEWEST} waypoints are needed"
        )
    numbers = [at for at, _ in lines]
    given = dict(zip(columns, rows.T, strict=True))
    x = np.stack([given.get(axis, np.zeros(len(rows))) for axis in axes], axis=1)
    clock = next((column for column in ("t", "phase") if column in columns), None)
    if clock is None:
        repeats = bool(np.abs(x[-1] - x[0]).max() <= 1e-6 * _largest_step(x))
        x = x[:-1] if repeats else x
        phase = np.arange(len(x)) / len(x)
    else:
        cycle = period if clock == "t" else 1.0
        time = given[clock]
        repeats = _check_clock(time, clock, cycle, numbers, where)
        if repeats:
            _check_repeats(x, axes, clock, cycle, f"{where}: line {numbers[-1]}")
            time, x = time[:-1], x[:-1]
        phase = (time - time[0]) / cycle
    if len(x) < FEWEST:
        raise ExperimentError(
            f"{where}: there are {len(x)} rows besides the last, which repeats the first; at least "
            f"{FEWEST} waypoints are needed"
        )
    _check_seam(x, axes, f"{where}: line {numbers[-2 if repeats else -1]}")
    # Imported here: no other motion needs it, and it takes longer than the rest of the start.
    from scipy.interpolate import CubicSpline

    closed = np.vstack([x, x[:1]])
    return CubicSpline(np.append(phase, 1.0), closed, bc_type="periodic")


def _lines(file: str, name: str) -> list[tuple[int, list[str]]]:
    """Number and cells of each line that is no comment, up to the last that is not empty."""
    needed = "give a CSV of waypoints, by a path that is absolute or from the experiment's folder"
    text = read_text(file, f"{name}: file = {cut(file, 200)!r}", needed)
    lines: list[tuple[int, list[str]]] = []
    empty: int | None = None
    for at, line in enumerate(text.splitlines(), start=1):
        if line.startswith("#"):
            continue
        cells = [cell.strip().strip('"').strip() for cell in line.split(",")]
        if cells == [""]:
            empty = empty or (at if lines else None)
            continue
        if empty is not None:
            raise ExperimentError(
                f"{name}: {file}: line {empty} is empty, between rows: a gap; give its waypoint, "
                "or take the line out"
            )
        lines.append((at, cells))
    return lines


def _header(cells: list[str], axes: tuple[str, ...], where: str) -> list[str]:
    valid = ["t", "phase", *axes]
    for cell in cells:
        if cell not in valid:
            # A file without any valid column is not a CSV of waypoints: what it holds stays there.
            what = f"column {shown(cell)}" if set(valid) & set(cells) else "columns"
            raise ExperimentError(
                f"{where}: unknown {what}; valid columns, separated by commas, are "
                f"{', '.join(valid)}"
            )
        if cells.count(cell) > 1:
            raise ExperimentError(f"{where}: column {cell} appears twice; once is valid")
    if "t" in cells and "phase" in cells:
        raise ExperimentError(
            f"{where}: columns t and phase are both given; give t [s] or phase [cycles]"
        )
    position = [axis for axis in axes if axis in "xyz"]
    needed = axes if any(axis in cells for axis in axes if axis not in position) else position
    for axis in needed:
        if axis not in cells:
            raise ExperimentError(
                f"{where}: column {axis} is missing, there are {', '.join(cells)}; the task needs "
                f"{', '.join(needed)}"
            )
    return cells


def _in_order(cells: list[str], axes: tuple[str, ...], where: str) -> list[str]:
    position = [axis for axis in axes if axis in "xyz"]
    for columns in (list(axes), position):
        if len(cells) == len(columns):
            return columns
    or_more = f", or {len(axes)}: {', '.join(axes)}" if len(axes) > len(position) else ""
    raise ExperimentError(
        f"{where}: has {len(cells)} columns and the file no header; without one {len(position)} "
        f"are needed, separated by commas: {', '.join(position)}{or_more}"
    )


def _row(cells: list[str], columns: list[str], where: str, quoted: bool = True) -> list[float]:
    """Numbers of a row; `quoted` in the error only if the file is known to be one of waypoints."""
    if len(cells) != len(columns):
        raise ExperimentError(
            f"{where}: has {len(cells)} columns; {len(columns)} are needed, separated by commas: "
            f"{', '.join(columns)}"
        )
    values = []
    for cell, column in zip(cells, columns, strict=True):
        unit = UNITS.get(column, "rad")
        at = f"{where}, column {column}"
        if not cell:
            raise ExperimentError(f"{at}: empty, a gap; a number in {unit} is needed")
        if not _is_number(cell):
            given = f" = {shown(cell)}" if quoted else ""
            raise ExperimentError(f"{at}{given}: not a number; a number in {unit} is needed")
        number = float(cell)
        if not math.isfinite(number):
            raise ExperimentError(f"{at} = {number}: a gap; a finite number in {unit} is needed")
        if abs(number) > LARGEST:
            raise ExperimentError(
                f"{at} = {number:g}: a number in {unit} from -{LARGEST:g} to {LARGEST:g} is needed"
            )
        values.append(number)
    return values


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _check_clock(
    time: np.ndarray, clock: str, cycle: float, numbers: list[int], where: str
) -> bool:
    """Check that the rows' times fit into a cycle, and say whether the last closes it."""
    unit = UNITS[clock]
    steps = np.diff(time)
    apart = steps > 1e-9 * cycle
    if not apart.all():
        i = int(np.argmin(apart))
        raise ExperimentError(
            f"{where}: line {numbers[i + 1]}, column {clock} = {time[i + 1]:g}: not after the "
            f"{time[i]:g} {unit} of the row before; increasing times are needed"
        )
    span = time[-1] - time[0]
    another = "; for times in shares of the cycle call the column phase" if clock == "t" else ""
    at = f"{where}: line {numbers[-1]}, column {clock} = {time[-1]:g}"
    if span > cycle * (1 + 1e-6):
        raise ExperimentError(
            f"{at}: {span:g} {unit} after the first row, and a cycle has {cycle:g} {unit}; at most "
            f"{time[0] + cycle:g} is valid{another}"
        )
    if span >= cycle * (1 - 1e-6):
        return True
    if cycle - span > JUMP * steps.max() * (1 + 1e-9):
        raise ExperimentError(
            f"{at}: then {cycle - span:g} {unit} without a row up to the end of the cycle of "
            f"{cycle:g} {unit}, more than {JUMP:g} times the longest of the other steps, "
            f"{steps.max():g} {unit}: a gap; give rows up to {time[0] + cycle:g} {unit}{another}"
        )
    return False


def _check_repeats(
    x: np.ndarray, axes: tuple[str, ...], clock: str, cycle: float, where: str
) -> None:
    for axis, first, last in zip(axes, x[0], x[-1], strict=True):
        if abs(last - first) > 1e-6 * _largest_step(x):
            at = f"{cycle:g} {'s' if clock == 't' else 'cycle'}"
            raise ExperimentError(
                f"{where}, column {axis} = {last:g}: a jump at the seam: this row is one cycle "
                f"({at}) after the first and must repeat it, {axis} = {first:g} "
                f"{UNITS.get(axis, 'rad')}"
            )


def _check_seam(x: np.ndarray, axes: tuple[str, ...], where: str) -> None:
    """Raise where the way from the last row to the first is much longer than any other."""
    is_position = np.array([axis in "xyz" for axis in axes])
    for kind, unit, chosen in (("position", "m", is_position), ("rotation", "rad", ~is_position)):
        part = x[:, chosen]
        seam = float(np.linalg.norm(part[-1] - part[0]))
        largest = _largest_step(part)
        if seam > JUMP * largest * (1 + 1e-9):
            last = zip(axes, x[-1], strict=True)
            point = ", ".join(f"{axis} = {value:g}" for axis, value in last)
            raise ExperimentError(
                f"{where}, {point}: a jump at the seam: from this last row to the first the "
                f"{kind} changes by {seam:.3g} {unit}, and between other rows by at most "
                f"{largest:.3g} {unit}; at most {JUMP:g} times that is valid: give the rows that "
                "lead back to the first"
            )


def _largest_step(x: np.ndarray) -> float:
    """Largest distance between two rows that follow each other."""
    return float(np.linalg.norm(np.diff(x, axis=0), axis=1).max(initial=0.0))
