"""What the sections of an experiment file have in common."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Gain = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Vector = tuple[float, ...]
Gains = Gain | Annotated[tuple[Gain, ...], Field(min_length=1)]
Angles = Literal["mean"] | Finite | Annotated[tuple[Finite, ...], Field(min_length=1)]


class Section(BaseModel):
    """A table of the file: frozen, without unknown keys; each key's docstring says what it is."""

    model_config = ConfigDict(
        defer_build=True, frozen=True, extra="forbid", use_attribute_docstrings=True
    )
