"""A sweep file: an experiment, and which values each of some of its keys takes."""

import math
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from .. import library
from ..errors import ExperimentError
from ..files import read_text
from ..text import listed
from . import toml
from .experiment import Experiment
from .loading import load
from .sections import Finite, Name, Section
from .validation import NESTED, Model, plain, validated

MOST_POINTS = 1_000_000
"""Experiments of a sweep that nobody has confirmed."""


class Range(Section):
    """Values of a number from one end to the other."""

    model_config = ConfigDict(validate_by_name=True, validate_by_alias=True)

    start: Annotated[Finite, Field(alias="from")]
    """The first."""
    stop: Annotated[Finite, Field(alias="to")]
    """The last."""
    count: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    """How many there are; of a sample as many as it has experiments."""
    scale: Literal["linear", "log"] = "linear"
    """log: equal ratios in place of equal differences."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.start < self.stop:
            raise ValueError(f"from {self.start:g} to {self.stop:g}: from < to is needed")
        if self.scale == "log" and self.start <= 0:
            raise ValueError(f"from {self.start:g}: a logarithmic range begins above 0")
        return self

    def at(self, share: np.ndarray) -> list[float]:
        """Its values at shares of the way from 0 to 1 (N,), with twelve digits."""
        low, high = self.start, self.stop
        if self.scale == "log":
            values = np.exp(math.log(low) + share * (math.log(high) - math.log(low)))
        else:
            values = low + share * (high - low)
        return [float(f"{value:.12g}") for value in values]


class Sweep(Section):
    """An experiment and the values of its keys."""

    experiment: Name
    """That all begin with: a built-in name, or the path of an experiment's or an arm's file."""
    how: Literal["grid", "zip", "sample"] = "grid"
    """grid: every value of a key with every value of the others; zip: the first of each, the second
    of each, and so on; sample: values drawn from the ranges."""
    count: Annotated[int, Field(ge=1, le=10_000_000)] | None = None
    """Experiments of a sample."""
    method: Literal["sobol", "random"] = "sobol"
    """How a sample is drawn: evenly, by Sobol's sequence, or at random."""
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0
    """Of a sample."""
    predict: bool = False
    """Whether it is found too, before each run, if by the linear analysis its learning or its
    feedback diverges, in this run or later; it takes some hundredths of a second each."""
    fixed: dict[str, Any] = Field(default={})
    """Keys that all change, and their values."""
    keys: Annotated[dict[str, Range | list[Any]], Field(min_length=1)]
    """Keys that vary: a list of values, or a range {from, to, count, scale}."""

    @model_validator(mode="after")
    def _can_be_made(self) -> Self:
        for key, values in self.keys.items():
            if not values:
                raise ValueError(f"keys.{key} = []: at least one value is needed")
            if self.how != "sample" and isinstance(values, Range) and values.count is None:
                raise ValueError(f"keys.{key}: the range needs a count")
        if self.how == "sample" and self.count is None:
            raise ValueError('how = "sample" needs count: how many experiments')
        if self.how != "sample" and self.count is not None:
            raise ValueError(f'count = {self.count} is of how = "sample"')
        lengths = {key: len(values) for key, values in self.values().items()}
        if self.how == "zip" and len(set(lengths.values())) > 1:
            said = ", ".join(f"{key} has {count}" for key, count in lengths.items())
            raise ValueError(f'how = "zip" needs as many values of each key: {said}')
        return self

    def values(self) -> dict[str, list[Any]]:
        """The values of each key; none of a range that is sampled."""
        found: dict[str, list[Any]] = {}
        for key, given in self.keys.items():
            if isinstance(given, list):
                found[key] = given
            elif self.how != "sample":
                found[key] = given.at(np.linspace(0.0, 1.0, given.count or 1))
        return found

    @property
    def size(self) -> int:
        """Number of experiments."""
        if self.how == "sample":
            return self.count or 0
        lengths = [len(values) for values in self.values().values()]
        return math.prod(lengths) if self.how == "grid" else lengths[0]

    def points(self) -> list[dict[str, Any]]:
        """The keys' values in each experiment, in order; the last key varies fastest in a grid."""
        if self.how == "sample":
            return self._drawn()
        values = self.values()
        combine = product if self.how == "grid" else zip
        return [dict(zip(values, point, strict=True)) for point in combine(*values.values())]

    def _drawn(self) -> list[dict[str, Any]]:
        count, names = self.count or 0, list(self.keys)
        if self.method == "sobol":
            from scipy.stats import qmc

            power = max(0, math.ceil(math.log2(count)))
            drawn = qmc.Sobol(len(names), rng=np.random.default_rng(self.seed))
            shares = drawn.random_base2(power)[:count]
        else:
            shares = np.random.default_rng(self.seed).random((count, len(names)))
        columns = []
        for share, given in zip(shares.T, self.keys.values(), strict=True):
            if isinstance(given, list):
                columns.append([given[int(i)] for i in share * len(given)])
            else:
                columns.append(given.at(share))
        return [dict(zip(names, point, strict=True)) for point in zip(*columns, strict=True)]

    def experiments(self, base: Experiment | None = None, *, yes: bool = False) -> list[Experiment]:
        """The experiments, in the order of `points`.

        Args:
            base: that all begin with, in place of the one that is named.
            yes: allow more than a million.

        Raises:
            ExperimentError: the experiment cannot be read, or a key or value is not valid.
        """
        if self.size > MOST_POINTS and not yes:
            raise ExperimentError(
                f"{self.size} experiments are more than {MOST_POINTS}: confirm with --yes"
            )
        base = (load(self.experiment) if base is None else base).replace(self.fixed)
        return [base.replace(point) for point in self.points()]


def load_sweep(name: str) -> Sweep:
    """Read a sweep file.

    Args:
        name: name of a built-in sweep, or path of a TOML file.

    Raises:
        ExperimentError: there is no such file, it is not TOML, or a value in it is not valid.
    """
    built_in = library.sweeps()
    path = built_in.get(str(name), Path(name))
    return read(Sweep, path, f"give a sweep's TOML file or one of {listed(built_in)}")


def read(model: type[Model], path: Path, needed: str) -> Model:
    """What varies the keys of an experiment, from its file; see `load_sweep`.

    Args:
        model: `Sweep`, or another with keys and fixed.
        path: of the TOML file.
        needed: what to give where there is none.
    """
    try:
        values = toml.parsed(read_text(path, needed=needed))
    except ValueError as error:
        raise ExperimentError(f"{path}: not valid TOML: {error}") from None
    except RecursionError:
        raise ExperimentError(f"{path}: {NESTED}") from None
    beside = path.parent / str(values.get("experiment", ""))
    if beside.is_file():
        values["experiment"] = str(beside.resolve())
    return of_values(model, values, str(path))


def of_values(model: type[Model], values: dict[str, Any], source: str) -> Model:
    """The same of a file's values; keys may stand as `law.beta` with quotes or without.

    Raises:
        ExperimentError: a value is not valid; the message names `source`.
    """
    try:
        for name in ("keys", "fixed"):
            if isinstance(table := values.get(name), dict):
                values = values | {name: _dotted(plain(table))}
    except RecursionError:
        raise ExperimentError(f"{source}: {NESTED}") from None
    return validated(model, values, source)


def _dotted(table: dict[str, Any], before: str = "") -> dict[str, Any]:
    """Tables in tables as dotted keys; what has from and to is a range."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{before}.{key}".removeprefix(".")
        if isinstance(value, dict) and not {"from", "to"} & set(value):
            found |= _dotted(value, name)
        else:
            found[name] = value
    return found
