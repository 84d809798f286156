"""The variables of a run: one table of their names and dimensions, and what is checked against it."""

from __future__ import annotations

from typing import NamedTuple

import xarray as xr

from ..errors import OutputError


class Variable(NamedTuple):
    """A variable of `Run.data`."""

    dims: tuple[str, ...]
    kind: str = "f"
    """Of its dtype: f floating point, i integer, U text."""
    optional: bool = False


SAMPLE, CYCLE, SEGMENT = ("time", "joint"), ("cycle", "joint"), ("segment", "joint")

COORDINATES = {
    "time": Variable(("time",)),
    "cycle": Variable(("cycle",), "i"),
    "segment": Variable(("segment",), "i"),
    "joint": Variable(("joint",), "U"),
    "slides": Variable(("joint",), "i"),
    "axis": Variable(("axis",), "U"),
    "cycle_of_sample": Variable(("time",), "i"),
    "segment_of_cycle": Variable(("cycle",), "i"),
}
VARIABLES = {
    **dict.fromkeys(("q", "dq", "y", "tau", "u", "tau_optimal"), Variable(SAMPLE)),
    **dict.fromkeys(("stiffness", "offset", "equilibrium", "center"), Variable(SAMPLE)),
    **dict.fromkeys(("x", "x_desired"), Variable(("time", "axis"))),
    **dict.fromkeys(("torque_squared", "tracking_rms", "singular_value"), Variable(("cycle",))),
    "rotation_rms": Variable(("cycle",), optional=True),
    **dict.fromkeys(("stiffness_per_cycle", "offset_per_cycle"), Variable(CYCLE)),
    **dict.fromkeys(
        ("stiffness_optimal", "offset_optimal", "equilibrium_optimal"), Variable(SEGMENT)
    ),
    **dict.fromkeys(
        ("torque_squared_optimal", "torque_squared_without_springs", "start", "end", "period"),
        Variable(("segment",)),
    ),
}


def check(data: xr.Dataset) -> None:
    """See that a dataset has the variables of a run and no others, and that each has its unit.

    Raises:
        OutputError: one is missing, unknown, or not of its dimensions, dtype or attributes.
    """
    table = COORDINATES | VARIABLES
    for name in (*table, *map(str, data.variables)):
        wanted, found = table.get(name), data.variables.get(name)
        if wanted is None:
            raise OutputError(f"variable {name!r} is not one of a run")
        if found is None:
            if wanted.optional:
                continue
            raise OutputError(f"variable {name!r} is missing")
        if found.dims != wanted.dims or found.dtype.kind not in (wanted.kind, wanted.kind.replace("U", "O")):
            raise OutputError(f"variable {name!r} is {found.dtype} of ({', '.join(map(str, found.dims))}); {wanted.kind} of ({', '.join(wanted.dims)}) is needed")
        if not isinstance(found.attrs.get("units"), str):
            raise OutputError(f"variable {name!r} has no units")
