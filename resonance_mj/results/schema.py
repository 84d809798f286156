"""The one table of what a run holds: dimensions, units and meaning of every variable."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..errors import OutputError


class Variable(NamedTuple):
    """A variable of a run's dataset."""

    dims: tuple[str, ...]
    units: str
    meaning: str
    kind: str = "f"
    """Of its dtype: f floating point, i integer, U text."""


SAMPLE, CYCLE, MOTION = ("time",), ("cycle",), ("segment",)
PER_JOINT, PER_AXIS = ("time", "joint"), ("time", "axis")
CYCLE_JOINT, MOTION_JOINT = ("cycle", "joint"), ("segment", "joint")

COORDINATES = {
    "time": Variable(SAMPLE, "s", "time"),
    "cycle": Variable(CYCLE, "1", "number of the cycle, from 1", "i"),
    "segment": Variable(MOTION, "1", "number of the motion, from 1", "i"),
    "joint": Variable(("joint",), "1", "name of the joint", "U"),
    "slides": Variable(("joint",), "1", "1 for a slide joint", "i"),
    "axis": Variable(("axis",), "1", "coordinate of the task", "U"),
    "parameter": Variable(("parameter",), "1", "parameter of an elastic element", "U"),
    "cycle_of_sample": Variable(SAMPLE, "1", "cycle that a sample belongs to", "i"),
    "segment_of_sample": Variable(SAMPLE, "1", "motion that a sample belongs to", "i"),
    "segment_of_cycle": Variable(CYCLE, "1", "motion that a cycle repeats", "i"),
    "passage": Variable(CYCLE, "1", "1 for a cycle of the passage into a motion", "i"),
}

VARIABLES = {
    "q": Variable(PER_JOINT, "rad", "joint angle"),
    "dq": Variable(PER_JOINT, "rad/s", "joint velocity"),
    "x": Variable(PER_AXIS, "m", "tool position"),
    "x_desired": Variable(PER_AXIS, "m", "desired tool position x_d"),
    "y": Variable(PER_JOINT, "rad/s", "error signal (8)"),
    "tau": Variable(PER_JOINT, "N m", "motor torque (4)"),
    "u": Variable(PER_JOINT, "N m", "learned torque (9)"),
    "stiffness": Variable(PER_JOINT, "N m/rad", "stiffness k (6)"),
    "offset": Variable(PER_JOINT, "N m", "offset torque q_e bar (7) about the center"),
    "equilibrium": Variable(PER_JOINT, "rad", "equilibrium angle q_e of the spring"),
    "center": Variable(PER_JOINT, "rad", "center q_c of the offset torque"),
    "tau_optimal": Variable(PER_JOINT, "N m", "motor torque with the optimal springs, tau_dopt"),
    "torque_squared": Variable(CYCLE, "N^2 m^2", "mean of tau^T tau over the cycle"),
    "torque_reduction": Variable(CYCLE, "1", "1 - torque_squared / that without springs"),
    "torque_share": Variable(CYCLE, "1", "torque_reduction / that of the optimum"),
    "tracking_rms": Variable(CYCLE, "m", "root mean square of the position error"),
    "rotation_rms": Variable(CYCLE, "rad", "root mean square of the rotation error"),
    "joint_rms": Variable(CYCLE, "rad", "root mean square of the joints' error"),
    "singular_value": Variable(CYCLE, "m/rad", "smallest singular value of J"),
    "stiffness_per_cycle": Variable(CYCLE_JOINT, "N m/rad", "stiffness at the end of the cycle"),
    "offset_per_cycle": Variable(CYCLE_JOINT, "N m", "offset torque at the end of the cycle"),
    "equilibrium_per_cycle": Variable(CYCLE_JOINT, "rad", "q_e at the end of the cycle"),
    "center_per_cycle": Variable(CYCLE_JOINT, "rad", "center q_c during the cycle"),
    "parameters_per_cycle": Variable(("cycle", "parameter"), "SI", "elastic elements likewise"),
    "parameters_optimal": Variable(("segment", "parameter"), "SI", "of the optimal elements"),
    "stiffness_optimal": Variable(MOTION_JOINT, "N m/rad", "stiffness of the optimal springs"),
    "offset_optimal": Variable(MOTION_JOINT, "N m", "offset of the optimal springs"),
    "equilibrium_optimal": Variable(MOTION_JOINT, "rad", "q_e of the optimal springs"),
    "stiffness_least": Variable(
        MOTION_JOINT, "N m/rad", "least that costs at most 1 % more of what none cost"
    ),
    "stiffness_most": Variable(MOTION_JOINT, "N m/rad", "greatest likewise"),
    "torque_squared_optimal": Variable(MOTION, "N^2 m^2", "torque_squared of the optimum"),
    "torque_squared_without_springs": Variable(MOTION, "N^2 m^2", "the same without springs"),
    "cost": Variable(CYCLE, "by springs.cost", "what springs.cost says, of the cycle"),
    "cost_optimal": Variable(MOTION, "by springs.cost", "cost of the optimum"),
    "cost_without_springs": Variable(MOTION, "by springs.cost", "the same without springs"),
    "electrical_power": Variable(MOTION, "W", "of all motors, mean of the last whole cycle"),
    "electrical_power_optimal": Variable(MOTION, "W", "electrical_power of the optimum"),
    "electrical_power_without_springs": Variable(MOTION, "W", "the same without springs"),
    "peak_torque": Variable(MOTION, "1", "largest of a motor in it, of its rated torque"),
    "peak_torque_optimal": Variable(MOTION, "1", "peak_torque of the optimum"),
    "peak_torque_without_springs": Variable(MOTION, "1", "the same without springs"),
    "optimum_made": Variable(MOTION, "1", "1 if the optimum is of the joint motion made", "i"),
    "size": Variable(MOTION, "m", "largest extent of the desired path"),
    "swing": Variable(MOTION, "rad", "widest extent of a joint's desired motion"),
    "start": Variable(MOTION, "s", "start of the motion"),
    "end": Variable(MOTION, "s", "end of the motion"),
    "period": Variable(MOTION, "s", "cycle time T"),
    "q_end": Variable(("joint",), "rad", "joint angle after the last time step"),
    "checkpoint": Variable(("number",), "1", "whole state after the last cycle, to resume from"),
    "dq_end": Variable(("joint",), "rad/s", "joint velocity after the last time step"),
}

ELASTIC = ("parameter", "parameters_per_cycle", "parameters_optimal")
"""Variables that only runs with elastic elements besides the joints' springs have."""

COST = ("cost", "cost_optimal", "cost_without_springs")
"""Variables that only runs have whose springs leave the least of something else than torque²."""

MOTORS = tuple(
    f"{name}{of}"
    for name in ("electrical_power", "peak_torque")
    for of in ("", "_optimal", "_without_springs")
)
"""What the motors do in the last whole cycle of each motion, beside the optimum's."""

OPTIONAL = (
    "rotation_rms",
    "joint_rms",
    "swing",
    "q_end",
    "dq_end",
    "checkpoint",
    *ELASTIC,
    *COST,
    *MOTORS,
)
"""Variables that only runs of some tasks have, or those of this version."""

KINDS = {"f": "floating-point numbers", "i": "integers", "U": "texts"}
"""What kinds of dtype are called."""

OF_SLIDES = {"rad": "m", "rad/s": "m/s", "N m": "N", "N m/rad": "N/m"}
"""Units of a hinge joint's variables, and of a slide joint's."""


def dataset(
    values: Mapping[str, Any],
    *,
    units: Mapping[str, str] | None = None,
    thinned: bool,
) -> xr.Dataset:
    """The dataset of a run, built at once.

    Args:
        values: by the names of `COORDINATES` and `VARIABLES`, all but what `OPTIONAL` allows.
        units: of variables in which they differ from the table.
        thinned: whether only some cycles' samples are among them.
    """
    mixed = bool(np.any(values["slides"]))

    def entry(name: str, about: Variable) -> tuple[Any, ...]:
        unit = (units or {}).get(name, about.units)
        if mixed and "joint" in about.dims and unit in OF_SLIDES:
            unit = f"{unit}; {OF_SLIDES[unit]} for slide joints"
        return about.dims, values[name], {"units": unit, "long_name": about.meaning}

    absent = set() if len(values["parameter"]) else set(ELASTIC)
    names = values.keys() - absent

    return xr.Dataset(
        {name: entry(name, about) for name, about in VARIABLES.items() if name in names},
        {name: entry(name, about) for name, about in COORDINATES.items() if name in names},
        {"thinned": int(thinned)},
    )


def with_checkpoint(data: xr.Dataset, state: np.ndarray) -> xr.Dataset:
    """The dataset of a run that can be resumed, with its whole state (S,) at its end."""
    about = VARIABLES["checkpoint"]
    entry = about.dims, state, {"units": about.units, "long_name": about.meaning}
    return data.assign(checkpoint=entry)


def check_cost(data: xr.Dataset, kind: str) -> None:
    """See that a dataset has the cost that its experiment asks for, by `springs.cost`.

    Raises:
        OutputError: it has not, or has one that was not asked for.
    """
    asked = kind != "torque-squared"
    for name in COST:
        if (name in data) != asked:
            raise OutputError(
                f"variable {name} is {'missing' if asked else 'of no such run'}: its experiment "
                f"has springs.cost = {kind!r}"
            )


def check(data: xr.Dataset) -> None:
    """See that a dataset has every variable of a run, and each its dimensions, dtype and unit.

    Raises:
        OutputError: one is missing or is not as the table says.
    """
    for name, wanted in (COORDINATES | VARIABLES).items():
        found = data.variables.get(name)
        if found is None:
            if name not in OPTIONAL:
                raise OutputError(f"variable {name} is missing")
            continue
        if (found.dims, found.dtype.kind) != (wanted.dims, wanted.kind):
            raise OutputError(
                f"variable {name} is {found.dtype} over ({', '.join(map(str, found.dims))}); "
                f"{KINDS[wanted.kind]} over ({', '.join(wanted.dims)}) are needed"
            )
        if not isinstance(found.attrs.get("units"), str):
            raise OutputError(f"variable {name} has no units")
