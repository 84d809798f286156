"""What figures call panels, runs and units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import xarray as xr

from ...results.run import Run


def letters() -> Iterator[str]:
    """Letters that name panels: a, b, ..., z, aa, ab, ..."""
    for first in ("", *ascii_lowercase):
        for second in ascii_lowercase:
            yield first + second


def heading(run: Run) -> str:
    """What was run, under which law, and how it ended."""
    law, motions = run.experiment.law, run.experiment.motion
    periods = ", ".join(f"{motion.cycles} × {motion.period:g} s" for motion in motions)
    form = f" (J {law.jacobian})" if law.jacobian else ""
    return (
        f"{run.experiment.name}: {Path(run.experiment.robot.mjcf).stem}, "
        f"law {Path(law.kind).stem}{form}, cycles {periods}; {run.status}"
    )


def of_joint(text: str, slides: bool) -> str:
    """A text with units of a hinge joint, as it is for a joint that slides or does not."""
    if not slides:
        return text
    return text.replace("N m/rad", "N/m").replace("N m", "N").replace("rad", "m")


def torque_squared_unit(data: xr.Dataset) -> str:
    """Unit of τᵀτ, whose terms differ where some joints slide and others do not."""
    slides = data["slides"].values.astype(bool)
    return "N²" if slides.all() else "N² m² + N²" if slides.any() else "N² m²"


def labels(runs: Sequence[Run]) -> list[str]:
    """Runs told apart: by their names, and where these are the same by the keys that differ."""
    names = [run.experiment.name for run in runs]
    told = []
    for run, name in zip(runs, names, strict=True):
        alike = [one for one in runs if one.experiment.name == name]
        words = [name]
        if len(alike) > 1:
            flat = [_flat(one.experiment.model_dump()) for one in alike]
            mine = _flat(run.experiment.model_dump())
            keys = [key for key in mine if any(one.get(key) != mine[key] for one in flat)]
            words += [f"{key} {_short(mine[key])}" for key in keys[:2]]
        told.append(", ".join(words))
    return [
        f"{label} ({told[: i + 1].count(label)})" if told.count(label) > 1 else label
        for i, label in enumerate(told)
    ]


def _flat(value: Any, key: str = "") -> dict[str, Any]:
    """Nested tables as one with dotted keys."""
    if isinstance(value, list | tuple) and any(isinstance(item, dict) for item in value):
        value = dict(enumerate(value))
    if not isinstance(value, dict):
        return {key: value}
    found: dict[str, Any] = {}
    for name, item in value.items():
        if key or name not in ("name", "expect"):
            found |= _flat(item, f"{key}.{name}".removeprefix("."))
    return found


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple):
        return " ".join(map(_short, value))
    return str(value)
