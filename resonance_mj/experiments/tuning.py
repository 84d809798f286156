"""A tuning file: an experiment, where its keys are looked for, and what is to be best."""

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from .sections import Finite, Name, Section
from .sweeping import Range, read


class Constraint(Section):
    """What a figure must be."""

    min: Finite | None = None
    """At least."""
    max: Finite | None = None
    """At most."""

    @model_validator(mode="after")
    def _one_end(self) -> Self:
        if self.min is None and self.max is None:
            raise ValueError("give min, max, or both")
        return self

    def excess(self, value: float) -> float:
        """How far a value is beyond an end; 0 or less within."""
        low = -float("inf") if self.min is None else self.min - value
        high = -float("inf") if self.max is None else value - self.max
        return max(low, high)


class Tuning(Section):
    """An experiment, its keys that are looked for, and the figure that is to be best."""

    experiment: Name
    """That all begin with: a built-in name, or the path of an experiment's or an arm's file."""
    minimize: Name | None = None
    """The figure of summary.json that is to be least, the worst of all motions."""
    maximize: Name | None = None
    """The figure that is to be greatest, in place of one that is to be least."""
    trials: Annotated[int, Field(ge=1, le=1_000_000)] = 64
    """Experiments that are tried."""
    seed: Annotated[int, Field(ge=0, le=2**31)] = 0
    """Of the search."""
    fixed: dict[str, Any] = Field(default={})
    """Keys that all change, and their values."""
    keys: Annotated[dict[str, Range | list[Any]], Field(min_length=1)]
    """Keys that are looked for: a list of values, or a range {from, to, scale}; with count, so many
    values of it."""
    constraints: dict[str, Constraint] = Field(default={})
    """Figures that must be within ends, the worst of all motions, each {min, max}."""

    @model_validator(mode="after")
    def _one_goal(self) -> Self:
        if (self.minimize is None) == (self.maximize is None):
            raise ValueError("give either minimize or maximize: the name of a figure")
        for key, values in self.keys.items():
            if not values:
                raise ValueError(f"keys.{key} = []: at least one value is needed")
        return self

    @property
    def figure(self) -> str:
        """The figure that is to be best."""
        return self.minimize or self.maximize or ""


def load_tuning(path: str) -> Tuning:
    """Read a tuning file.

    Args:
        path: of a TOML file.

    Raises:
        ExperimentError: there is no such file, it is not TOML, or a value in it is not valid.
    """
    return read(Tuning, Path(path), "give a tuning's TOML file")
