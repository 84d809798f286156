"""The sections [[motion]] of an experiment file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from ..text import listed
from .sections import Alone, Finite, Name, Numbers, Positive, Rows, Section

MOST_CYCLES = 1_000_000
"""Cycles that a motion, and all of an experiment together, may have."""


Times = Annotated[tuple[Annotated[Finite, Field(ge=0)], ...], Alone]
"""Lengths of time [s]; one of them may stand alone."""

GRADUAL = 4
"""Cycles from which a passage changes little enough from one to the next to be learned from."""


class Motion(Section):
    """A periodic motion of the tool."""

    duration: Positive = 20.0
    """How long the motion is repeated [s]: a whole number of periods."""
    period: Positive = 1.0
    """Cycle time T [s]: a whole number of time steps."""
    shape: Literal["ellipse", "line", "eight", "polygon", "points", "fourier", "csv"] = "ellipse"
    """ellipse, line, eight, polygon: with rounded corners, points: from one to the next with rests,
    fourier: an offset plus harmonics, or csv: a smooth closed curve through waypoints."""
    frame: Literal["world", "base", "tool"] = "world"
    """Whose axes and origin the motion's positions are given in: world, base: of the body that
    carries the first joint, or tool: of the tool at home. Rotations are about the world's axes."""
    payload: Finite | Rows = 0.0
    """Mass that the tool carries, as a point at the tool [kg]: a number for the whole cycle, or for
    parts of it rows of when it is picked up and put down [s] and its mass; laws are not told of it,
    and computed-torque knows it."""
    blend: Annotated[int, Field(ge=0, le=1000)] | None = None
    """Cycles in which the arm passes over into this motion, 0 for a jump, from 4 on with learning
    on the way; 1, or with the law transfer 12 where motors are too weak to make the motion without
    springs, or where one motion follows another and the loop is late or noisy, if not given."""
    center: Numbers | None = None
    """Middle of an ellipse, line, eight or polygon [m], one per position coordinate; where the tool
    is at home if not given."""
    size: tuple[Finite, Finite] | None = None
    """Half of the shape's two sizes in its plane [m], for a polygon the half axes of the ellipse
    through its corners; the largest that the arm follows with margin if not given."""
    plane: tuple[Name, Name] | None = None
    """The two coordinates in which an ellipse, line, eight or polygon lies, of x, y and z, or the
    names of two joints; the first and the last of the task's positions, or joints, if not given."""
    corners: Annotated[int, Field(ge=3, le=1000)] | None = None
    """Number of corners of a polygon, the first on the plane's first coordinate; 4 if not given."""
    rounding: Annotated[float, Field(gt=1e-6, le=1)] | None = None
    """Share of a polygon's sides that its rounded corners take, up to 1; 0.5 if not given."""
    points: Rows = ()
    """Positions that the tool goes to and rests at, one after the other and then to the first again
    [m]: a row each with a number per position coordinate; moves have minimum jerk."""
    rests: Times = ()
    """How long the tool rests at each of the points [s]; one number for all, 0 if not given."""
    moves: Times = ()
    """How long each move takes, the first from the first point to the second [s]; what the rests
    leave of the period in equal parts if not given."""
    offset: Numbers | None = None
    """Mean of a fourier motion [m], one per coordinate."""
    sin: Rows = ()
    """Amplitudes of the sines [m]: a row per coordinate, a column per harmonic."""
    cos: Rows = ()
    """Amplitudes of the cosines [m]: a row per coordinate, a column per harmonic."""
    file: Name | None = None
    """Path of a csv motion's waypoints, absolute or from the experiment's folder: a column per
    coordinate [m, rad], in order or named in a header; t [s] or phase [cycles] if not equally
    spaced."""
    rotation_sin: Rows = ()
    """Amplitudes of the sines of the tool's rotation vector from its orientation at home [rad]: a
    row each for rx, ry and rz, a column per harmonic; with any shape."""
    rotation_cos: Rows = ()
    """Amplitudes of the cosines of the rotation vector [rad], as rotation_sin."""

    @field_validator("payload")
    @classmethod
    def _is_carried(cls, payload: float | tuple[tuple[float, ...], ...]) -> Any:
        if isinstance(payload, float):
            masses = [payload]
        elif lengths := [len(row) for row in payload if len(row) != 3]:
            raise ValueError(
                "valid are a mass [kg] and rows of three numbers, when it is picked up and put "
                f"down [s] and its mass [kg]; there is a row of {lengths[0]}"
            )
        else:
            masses = [mass for *_, mass in payload]
        if min(masses, default=0.0) < 0:
            raise ValueError(f"{min(masses):g} kg: a mass is 0 kg or more")
        return payload

    @model_validator(mode="after")
    def _fits_its_shape(self) -> Motion:
        own = _KEYS_OF_SHAPE[self.shape]
        every = dict.fromkeys(key for keys in _KEYS_OF_SHAPE.values() for key in keys)
        wrong = [key for key in every if key not in own and getattr(self, key) not in (None, ())]
        if wrong:
            shapes = [shape for shape, keys in _KEYS_OF_SHAPE.items() if wrong[0] in keys]
            raise ValueError(
                f"a motion of shape {self.shape!r} takes {listed(own)}, not {listed(wrong)}; "
                f"{wrong[0]} belongs to shape {' or '.join(map(repr, shapes))}"
            )
        if self.shape == "fourier" and self.offset is None:
            raise ValueError(
                "a motion of shape 'fourier' needs offset: its mean [m], a number per coordinate"
            )
        if self.shape == "csv" and not self.file:
            raise ValueError(
                "a motion of shape 'csv' needs file: the path of a CSV of waypoints, a row each"
            )
        if self.shape == "points":
            self._stops()
        if not isinstance(self.payload, float):
            self._parts(self.payload)
        numbers = len(self.offset or ())
        for name in ("rotation_sin", "rotation_cos", "sin", "cos"):
            rows = len(getattr(self, name))
            if name.startswith("rotation") and rows not in (0, 3):
                raise ValueError(
                    f"{name} has {rows} rows; 3 are needed, one each for rx, ry and rz"
                )
            if name in ("sin", "cos") and rows not in (0, numbers):
                raise ValueError(
                    f"{name} has {rows} rows and offset has {numbers} numbers: both need one per "
                    "coordinate"
                )
        cycles = self.duration / self.period
        if cycles > MOST_CYCLES or abs(cycles - round(cycles)) > 1e-9 * cycles:
            whole = max(1, round(min(cycles, MOST_CYCLES)))
            raise ValueError(
                f"duration {self.duration:g} s is {cycles:.6g} periods of {self.period:g} s; a "
                f"whole number up to {MOST_CYCLES} is needed, for example {whole * self.period:g} s"
            )
        if self.blend is not None and self.blend >= self.cycles:
            raise ValueError(
                f"blend = {self.blend} leaves no cycle of the {self.cycles} that the motion has"
            )
        return self

    def phases(self) -> tuple[np.ndarray, np.ndarray]:
        """Of a motion from point to point how long it rests at each, and each move takes [s]."""
        count = len(self.points)
        rests = np.zeros(count) + (self.rests or 0.0)
        left = self.period - rests.sum()
        moves = np.array(self.moves) if self.moves else np.full(count, left / count)
        return rests, moves

    def carried(self, steps: int) -> np.ndarray:
        """Mass that the tool carries in each of the time steps of a cycle (steps,) [kg]."""
        masses = np.zeros(steps)
        if isinstance(self.payload, float):
            return masses + self.payload
        for begin, end, mass in self.payload:
            first, last = (round(time / self.period * steps) for time in (begin, end))
            masses[np.arange(first, last) % steps] = mass
        return masses

    @property
    def carries(self) -> bool:
        """Whether the tool carries anything, at any time."""
        return self.payload not in (0.0, ())

    @property
    def shortest_part(self) -> tuple[float, ...] | None:
        """Of the parts of a cycle in which something is carried the shortest, None for no parts."""
        rows = () if isinstance(self.payload, float) else self.payload
        return min(rows, key=lambda row: row[1] - row[0], default=None)

    def _parts(self, rows: tuple[tuple[float, ...], ...]) -> None:
        """Raise where the parts of a cycle in which something is carried are none."""
        for begin, end, _ in rows:
            if not (0 <= begin < self.period and begin < end <= begin + self.period):
                raise ValueError(
                    f"payload: from {begin:g} to {end:g} s: it is picked up within the period of "
                    f"{self.period:g} s, and put down later, at most a period later"
                )
        in_order = sorted(rows)
        following = [*in_order[1:], (in_order[0][0] + self.period, 0.0, 0.0)] if rows else []
        for (_, end, _), (begin, *_) in zip(in_order, following, strict=True):
            if end > begin:
                raise ValueError(
                    f"payload: something is put down at {end:g} s, after the next is picked up at "
                    f"{begin:g} s"
                )

    def _stops(self) -> None:
        """Raise where points, rests and moves do not fit each other and the period."""
        count, widths = len(self.points), {len(row) for row in self.points}
        if count < 2 or len(widths) > 1:
            rows = listed(sorted(map(str, widths)), "none")
            raise ValueError(
                f"a motion of shape 'points' needs points: two or more rows of as many positions "
                f"[m]; {count} were given, of {rows} numbers"
            )
        if len(self.rests) not in (0, 1, count) or len(self.moves) not in (0, count):
            raise ValueError(
                f"{len(self.rests)} rests and {len(self.moves)} moves for {count} points: give a "
                "rest for each point, or one for all, and a move from each to the next"
            )
        rests, moves = self.phases()
        if not (moves > 0).all():
            raise ValueError(
                f"rests of {rests.sum():g} s leave no time to move in a period of {self.period:g} s"
                if not self.moves
                else "moves: each needs a time above 0 s"
            )
        together = float(rests.sum() + moves.sum())
        if abs(together - self.period) > 1e-9 * self.period:
            raise ValueError(
                f"rests and moves take {together:g} s together, and the period is {self.period:g} s"
            )

    @property
    def in_a_plane(self) -> bool:
        """Whether it has a center, a size and a plane, which can be found if they are not given."""
        return "size" in _KEYS_OF_SHAPE[self.shape]

    @property
    def passage(self) -> int:
        """Number of cycles in which the arm passes over into the motion."""
        return self.blend or 0

    @property
    def gradual(self) -> bool:
        """Whether the law learns on the way into the motion."""
        return self.passage >= GRADUAL

    @property
    def cycles(self) -> int:
        """Number of cycles in the duration."""
        return max(1, round(self.duration / self.period))

    def steps(self, timestep: float) -> int:
        """Number of time steps of `timestep` [s] in a cycle."""
        return round(self.period / timestep)


_IN_PLANE = ("center", "size", "plane")
_KEYS_OF_SHAPE: dict[str, tuple[str, ...]] = {
    "ellipse": _IN_PLANE,
    "line": _IN_PLANE,
    "eight": _IN_PLANE,
    "polygon": (*_IN_PLANE, "corners", "rounding"),
    "points": ("points", "rests", "moves"),
    "fourier": ("offset", "sin", "cos"),
    "csv": ("file",),
}
"""What each shape is described by, besides the keys that every motion has."""
