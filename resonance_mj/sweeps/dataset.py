"""What is kept of each run of a sweep, and the one dataset of all of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..errors import OutputError
from ..experiments.sweeping import Sweep
from ..results.run import Run, finite
from ..results.schema import COST, MOTORS, VARIABLES
from ..springs.cost import KINDS
from ..text import shown

WHOLE, TABLE, SETTINGS = "sweep.nc", "summary.csv", "sweep.json"
"""Files of a finished sweep, and the one that says of which sweep a folder is."""

FIGURES = (
    "torque_reduction",
    "torque_reduction_optimal",
    "torque_squared",
    "torque_squared_without_springs",
    "torque_squared_optimal",
    "cost_reduction",
    "cost_reduction_optimal",
    "cost",
    "cost_without_springs",
    "cost_optimal",
    *MOTORS,
    *(name.replace("power", "energy") for name in MOTORS if name.startswith("electrical_power")),
    "tracking_rms",
    "cycles_to_optimum",
)
"""Of each motion, as in summary.json; what a run does not have is NaN."""

PER_JOINT = ("stiffness", "stiffness_optimal", "offset", "offset_optimal")
PER_CYCLE = ("torque_squared", "tracking_rms")


@dataclass(frozen=True)
class Outcome:
    """What is kept of a run.

    Attributes:
        status: how it ended, or refused.
        message: why.
        joints: names of the arm's joints.
        motions: figures of each motion's last whole cycle, as in summary.json.
        cycles: of each name in `PER_CYCLE`, the values of all cycles.
        diverges: whether it diverges by the linear analysis; None where that was not asked for.
        cost: `springs.cost`.
    """

    status: str
    message: str
    joints: list[str]
    motions: list[dict[str, Any]]
    cycles: dict[str, list[float]]
    diverges: bool | None = None
    cost: str = "torque-squared"

    @classmethod
    def of(cls, run: Run, diverges: bool | None = None) -> Outcome:
        """What is kept of a run, and whether it was predicted to diverge."""
        summary, data = run.summary(), run.data
        return cls(
            status=summary["status"],
            message=summary["message"],
            joints=[str(name) for name in data["joint"].values],
            motions=[
                {name: one.get(name) for name in (*FIGURES, *PER_JOINT)}
                for one in summary["segments"]
            ],
            cycles={name: finite(data[name].values.tolist()) for name in PER_CYCLE},
            diverges=diverges,
            cost=run.experiment.springs.cost,
        )

    @classmethod
    def refused(cls, why: str) -> Outcome:
        """An experiment that could not begin."""
        return cls("refused", why, [], [], {name: [] for name in PER_CYCLE})


def written(outcomes: Sequence[Outcome]) -> bytes:
    """Outcomes as a shard's file; numbers keep all their bits."""
    return json.dumps([asdict(one) for one in outcomes]).encode()


def parsed(content: bytes) -> list[Outcome]:
    """The outcomes that `written` wrote."""
    return [Outcome(**one) for one in json.loads(content)]


def read(path: Path) -> list[Outcome] | None:
    """The outcomes in a shard's file; None if there is none."""
    try:
        return parsed(path.read_bytes())
    except (OSError, ValueError, TypeError):
        return None


def opened(path: Path) -> xr.Dataset:
    """The dataset in a sweep's file.

    Raises:
        OutputError: it is not there, or no netCDF file.
    """
    try:
        with xr.open_dataset(path, engine="h5netcdf") as data:
            return data.load()
    except (OSError, ValueError, KeyError) as error:
        raise OutputError(f"{path}: no sweep can be read from it: {error}") from None


def of(settings: Sweep, outcomes: Sequence[Outcome]) -> xr.Dataset:
    """One dataset of all outcomes, in the order of the sweep's points.

    Motions, joints and cycles that one run has and another lacks are NaN there.
    """
    points = settings.points()
    lengths = {
        "motion": max((len(one.motions) for one in outcomes), default=0),
        "joint": max((len(one.joints) for one in outcomes), default=0),
        "cycle": max((len(one.cycles["torque_squared"]) for one in outcomes), default=0),
    }
    if settings.how == "grid":
        axes = {key: _coordinate(values) for key, values in settings.values().items()}
        dims, shape = tuple(axes), tuple(map(len, axes.values()))
        along = {key: ((key,), values) for key, values in axes.items()}
    else:
        dims, shape = ("run",), (len(points),)
        along = {key: (dims, _coordinate([point[key] for point in points])) for key in points[0]}
    joints = next((one.joints for one in outcomes if len(one.joints) == lengths["joint"]), [])
    alike = all(one.joints in ([], joints) for one in outcomes)
    along |= {
        "motion": (("motion",), np.arange(1, lengths["motion"] + 1)),
        "cycle": (("cycle",), np.arange(1, lengths["cycle"] + 1)),
        "joint": (("joint",), np.array(joints if alike else range(lengths["joint"]))),
    }

    def filled(inner: tuple[str, ...], values: Sequence[Any]) -> tuple[tuple[str, ...], np.ndarray]:
        whole = np.full((len(outcomes), *(lengths[name] for name in inner)), np.nan)
        for row, value in enumerate(values):
            for at in np.ndindex(whole.shape[1:]):
                item: Any = value
                for index in at:
                    item = item[index] if item is not None and index < len(item) else None
                whole[(row, *at)] = np.nan if item is None else item
        return (*dims, *inner), whole.reshape(*shape, *whole.shape[1:])

    data = {
        "status": (dims, np.array([one.status for one in outcomes]).reshape(shape)),
        "message": (dims, np.array([one.message for one in outcomes]).reshape(shape)),
    }
    if settings.predict:
        told = [np.nan if one.diverges is None else float(one.diverges) for one in outcomes]
        data["predicted_to_diverge"] = dims, np.array(told).reshape(shape)
    for name in (*FIGURES, *PER_JOINT):
        inner = ("motion", "joint") if name in PER_JOINT else ("motion",)
        data[name] = filled(inner, [[one[name] for one in run.motions] for run in outcomes])
    for name in PER_CYCLE:
        data[f"{name}_per_cycle"] = filled(("cycle",), [one.cycles[name] for one in outcomes])
    found = xr.Dataset(data, coords=along)
    for name in (*FIGURES, *PER_JOINT, *(f"{name}_per_cycle" for name in PER_CYCLE)):
        known = VARIABLES.get(name.removesuffix("_per_cycle"))
        unit = "J" if name.startswith("electrical_energy") else "1"
        found[name].attrs["units"] = known.units if known else unit
    costs = {one.cost for one in outcomes if one.motions}
    cost = costs.pop() if len(costs) == 1 else "torque-squared"
    for name in COST:
        found[name].attrs["units"] = KINDS[cost].units
    return found.assign_attrs(title=f"resonance-mj sweep of {settings.experiment}", cost=cost)


def _coordinate(values: Sequence[Any]) -> np.ndarray:
    """Values of a key as a coordinate: numbers as they are, others as words."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values, float)
    return np.array([value if isinstance(value, str) else shown(value) for value in values])
