"""What a run must show: the section [expect] of an experiment file."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from ..status import Status
from ..text import shown
from .sections import Alone, Name, Section

PER_JOINT = ("stiffness", "offset", "equilibrium")
"""Figures with a number for each joint; the others have one."""

WITH_OPTIMUM = (*PER_JOINT, "torque_reduction")
"""Figures that the optimum of the robot's own motion has too."""

Number = Annotated[float, Field(allow_inf_nan=False)]
Tolerance = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Expected(Section):
    """What one figure must be, and how near."""

    value: Literal["optimal"] | Number | tuple[Number, ...] | None = None
    """A number, for joints also a list of one each; "optimal" is that of this robot's optimum."""
    abs: Tolerance | None = None
    """Tolerance, in the unit of the figure."""
    rel: Tolerance | None = None
    """Tolerance as a share of the value; of abs and rel the wider counts."""
    min: Number | None = None
    """Least that it may be, in place of value."""
    max: Number | None = None
    """Most that it may be, in place of value."""
    joints: Annotated[tuple[Name, ...], Field(min_length=1), Alone] | None = None
    """Names of the joints that it is about; all if not given."""

    @field_validator("value", mode="before")
    @classmethod
    def _is_optimal_or_numbers(cls, given: Any) -> Any:
        numbers = given if isinstance(given, list | tuple) else (given,)
        if given is None or given == "optimal" or (numbers and all(map(_is_number, numbers))):
            return given
        raise ValueError("valid are 'optimal', a number, or a list of one for each joint")

    @model_validator(mode="after")
    def _says_how_near(self) -> Expected:
        bounded = self.min is not None or self.max is not None
        tolerant = self.abs is not None or self.rel is not None
        if self.value is None and not bounded:
            raise ValueError(
                "says nothing: give value, a number or 'optimal', with abs or rel; or min, max"
            )
        if self.value is not None and bounded:
            raise ValueError(
                f"value = {shown(self.value)} stands beside min or max: give value with a "
                "tolerance, abs or rel, or give bounds"
            )
        if bounded and tolerant:
            raise ValueError("bounds, min and max, have no tolerance: leave abs and rel out")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min = {self.min:g} is above max = {self.max:g}")
        if self.value not in (None, "optimal") and not tolerant:
            raise ValueError(f"value = {shown(self.value)} {_NO_TOLERANCE}")
        return self


_NO_TOLERANCE = (
    "has no tolerance: give abs or rel, as in { value = 0.97, abs = 0.002 }, or bounds, "
    "as in { max = 10 }"
)


def _table(given: Any) -> Any:
    """The table that a value stands for: "optimal" needs no tolerance, a number does."""
    if isinstance(given, str):
        if given != "optimal":
            raise ValueError("valid are 'optimal' and a table, as in { value = 3.06, rel = 0.01 }")
        return {"value": "optimal"}
    if given is None or isinstance(given, dict | Expected):
        return given
    raise ValueError(_NO_TOLERANCE)


Figure = Annotated[Expected | None, BeforeValidator(_table)]


class OfMotion(Section):
    """What a motion must show in its last whole cycle."""

    status: Status | None = None
    """How it must end: ok if all its cycles are simulated and the tool follows its path."""
    stiffness: Figure = None
    """k [N m/rad], for slide joints [N/m]."""
    offset: Figure = None
    """Offset torque of the spring [N m], for slide joints [N]."""
    equilibrium: Figure = None
    """Equilibrium angle q_e [rad], for slide joints [m]."""
    torque_reduction: Figure = None
    """1 - torque² / torque² without springs, 0.97 for 97 %."""
    torque_share: Figure = None
    """Torque reduction as a share of that of the optimum: 1 is all that constant springs can do."""
    tracking_rms: Figure = None
    """Root mean square of the tool's position error [m]."""
    cycles_to_optimum: Figure = None
    """First cycle of the motion from which torque² stays within 5 % of the optimum's."""

    @field_validator("torque_reduction", "torque_share", "tracking_rms", "cycles_to_optimum")
    @classmethod
    def _is_of_no_joint(cls, given: Expected | None, info: ValidationInfo) -> Expected | None:
        if given is None:
            return None
        if given.value == "optimal" and info.field_name not in WITH_OPTIMUM:
            raise ValueError(
                f"value = 'optimal' belongs to {', '.join(WITH_OPTIMUM)}: give a number"
            )
        if isinstance(given.value, tuple):
            raise ValueError(f"value = {shown(given.value)}: one number is needed")
        if given.joints is not None:
            raise ValueError(f"joints belongs to {', '.join(PER_JOINT)}")
        return given

    def figures(self) -> dict[str, Expected]:
        """What is expected: figure -> value and tolerance."""
        given = {name: getattr(self, name) for name in OfMotion.model_fields if name != "status"}
        return {name: expected for name, expected in given.items() if expected is not None}


class Expect(OfMotion):
    """What a run must show; the figures are those of each of its motions."""

    status: Status = Status.OK
    """How the run must end: ok, not tracking, in contact, noisy or diverged."""
    motion: tuple[OfMotion, ...] = ()
    """What single motions must show besides: a table [[expect.motion]] for each, in order."""
    versions: dict[str, str] | None = None
    """Versions that the numbers came from; written by `resonance-mj check --update`."""


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
