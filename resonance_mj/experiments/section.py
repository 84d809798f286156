"""What the sections of an experiment file have in common: their types, each with its range."""

import math
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field


def _one_alone(given: Any) -> Any:
    """A list of one number or name may be written without brackets."""
    return (given,) if isinstance(given, int | float | str) else given


def _bound(given: float) -> float:
    if not (abs(given) <= 1e9 or math.isinf(given)):
        raise ValueError("valid are numbers from -1e9 to 1e9, and -inf or inf for no bound")
    return given


Name = Annotated[str, Field(max_length=4096, pattern=r"^[^\x00]*$")]
"""Of a file, or of an element of the robot."""
Finite = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False, strict=True)]
"""Lengths, angles and accelerations: beyond, sums of squares have no digits left."""
Positive = Annotated[float, Field(gt=0, le=1e12, allow_inf_nan=False, strict=True)]
Gain = Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False, strict=True)]
Stiffness = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False, strict=True)]
Bound = Annotated[float, AfterValidator(_bound)]
Alone = BeforeValidator(_one_alone)
"""Lets a list take one value alone."""
Numbers = Annotated[tuple[Finite, ...], Field(min_length=1), Alone]
Rows = Annotated[tuple[Annotated[tuple[Finite, ...], Alone], ...], Alone]
Gains = Gain | Annotated[tuple[Gain, ...], Field(min_length=1)]
Angles = Finite | Annotated[tuple[Finite, ...], Field(min_length=1)]


class Section(BaseModel):
    """A table of the file: frozen, without unknown keys; each key's docstring says what it is."""

    model_config = ConfigDict(
        defer_build=True, frozen=True, extra="forbid", use_attribute_docstrings=True
    )
