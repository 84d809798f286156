"""One motion of a run at a time: what every reader of a run asks for."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from ..text import NOTHING, angle, length
from .metrics import cycles_to_optimum, reduction, share, tracks
from .schema import MOTORS


@dataclass(frozen=True)
class MotionOfRun:
    """One motion of a run: its whole cycles (C), its optimum, its samples.

    Attributes:
        number: of the motion, from 1.
        start: when it begins [s].
        end: when it would end if all its cycles were simulated [s].
        period: cycle time [s].
        optimum_made: whether the optimum is of the joint motion made.
        size: largest extent of the desired path along an axis [m].
        cycles: numbers in the run of its whole cycles (C,).
        passage: whether each is part of the passage into the motion, which teaches nothing (C,).
        torque_squared: mean of τᵀτ over each cycle (C,) [N² m²].
        torque_reduction: 1 - torque_squared / that without springs (C,); NaN for a motion that
            needs no torque.
        torque_share: torque_reduction over that of the optimum (C,); NaN where no spring helps.
        tracking_rms: of the position error (C,) [m].
        rotation_rms: of the rotation error (C,) [rad]; None for a task without rotation.
        joint_rms: of the joints' error (C,) [rad]; None for a task of the tool.
        swing: widest extent of a joint's desired motion [rad]; 0 for a task of the tool.
        stiffness: k at the end of each cycle (C, n) [N m/rad].
        offset: q̄_e about `center` likewise (C, n) [N m].
        equilibrium: q_e likewise (C, n) [rad].
        center: q_c during each cycle (C, n) [rad].
        stiffness_optimal: of the best constant springs (n,) [N m/rad].
        offset_optimal: likewise (n,) [N m].
        equilibrium_optimal: likewise (n,) [rad].
        stiffness_least: the least with which torque² is at most 1 % of that without springs above
            the optimum's, whatever the other joints' springs (n,) [N m/rad].
        stiffness_most: the greatest likewise (n,) [N m/rad].
        parameters: of the elastic elements besides, at the end of each cycle, by their names
            (C,) each.
        parameters_optimal: of the best ones, by their names.
        torque_squared_optimal: with the best constant springs [N² m²].
        torque_squared_without_springs: without any [N² m²].
        kind: what the springs leave the least of, by the words of `springs.cost`.
        cost: that of each cycle (C,); torque_squared if it is no other.
        cost_optimal: with the best constant springs.
        cost_without_springs: without any.
        motors: electrical power [W] and peak torque, of the rated one, of the last whole cycle, of
            the optimum and without springs, by their names in `schema.MOTORS`; empty in runs that
            were made before there were any.
    """

    number: int
    start: float
    end: float
    period: float
    optimum_made: int
    size: float
    cycles: np.ndarray
    passage: np.ndarray
    torque_squared: np.ndarray
    torque_reduction: np.ndarray
    torque_share: np.ndarray
    tracking_rms: np.ndarray
    rotation_rms: np.ndarray | None
    joint_rms: np.ndarray | None
    swing: float
    stiffness: np.ndarray
    offset: np.ndarray
    equilibrium: np.ndarray
    center: np.ndarray
    stiffness_optimal: np.ndarray
    offset_optimal: np.ndarray
    equilibrium_optimal: np.ndarray
    stiffness_least: np.ndarray
    stiffness_most: np.ndarray
    parameters: dict[str, np.ndarray]
    parameters_optimal: dict[str, float]
    torque_squared_optimal: float
    torque_squared_without_springs: float
    kind: str
    cost: np.ndarray
    cost_optimal: float
    cost_without_springs: float
    motors: dict[str, float]
    _data: xr.Dataset = field(repr=False)

    @cached_property
    def samples(self) -> xr.Dataset:
        """The per-time part of the run's data that belongs to the motion."""
        of_sample = self._data["segment_of_sample"].values
        return self._data.isel(time=np.flatnonzero(of_sample == self.number))

    @property
    def optimum_of(self) -> str:
        """Which joint motion the optimum is of: `desired`, or `made` where the task leaves it free.

        The one made is that of the motion's last whole cycle, if the tool followed its path in it
        and nothing but motors, springs and gravity bore on the arm.
        """
        return "made" if self.optimum_made else "desired"

    @property
    def tracks(self) -> np.ndarray:
        """Whether the tool follows its path in each cycle (C,)."""
        joints = None if self.joint_rms is None else (self.joint_rms, self.swing)
        return tracks(self.tracking_rms, self.size, self.rotation_rms, joints)

    @property
    def off(self) -> str:
        """How far the last cycle is off: "the tool is 3 mm RMS off its path"."""
        if self.joint_rms is None:
            return f"the tool is {length(self.tracking_rms[-1])} RMS off its path"
        return f"the joints are {angle(self.joint_rms[-1])} RMS off their path"

    @property
    def torque_reduction_optimal(self) -> float:
        """1 - torque² of the optimum / that without springs; NaN if no torque is needed."""
        optimal, without = self.torque_squared_optimal, self.torque_squared_without_springs
        return float(reduction(optimal, without))

    @property
    def reduction(self) -> np.ndarray:
        """1 - cost / cost without springs (C,); NaN for a motion that costs nothing."""
        return reduction(self.cost, self.cost_without_springs)

    @property
    def reduction_optimal(self) -> float:
        """The same of the optimum."""
        return float(reduction(self.cost_optimal, self.cost_without_springs))

    @property
    def share(self) -> np.ndarray:
        """`reduction` over that of the optimum (C,); NaN where no spring helps."""
        return share(self.reduction, self.reduction_optimal)

    @property
    def cycles_to_optimum(self) -> int | None:
        """First cycle of the motion, from 1, from which it tracks at the optimum's cost.

        A cycle of the passage into it is none, as it is not yet the motion.
        """
        return cycles_to_optimum(
            self.cost,
            self.cost_optimal,
            self.cost_without_springs,
            self.tracks & (self.passage == 0),
        )

    @property
    def verdict(self) -> str:
        """What the last cycle is: at the optimum, off the path, or neither."""
        if not len(self.cycles):
            return NOTHING
        if not self.tracks[-1]:
            return "off path"
        if self.cycles_to_optimum or not self.cost_without_springs > 0:
            return "at optimum"
        below = self.cost[-1] < self.cost_optimal
        return "below optimum" if below else "above optimum"

    def summary(self) -> dict[str, Any]:
        """The motion's figures in its last whole cycle beside the optimum's, as in summary.json.

        What a run that ended early did not reach is None.
        """

        def last(values: np.ndarray) -> Any:
            return values[-1].tolist() if len(values) else None

        of_some = {"rotation_rms": self.rotation_rms, "joint_rms": self.joint_rms}
        more = {name: last(values) for name, values in of_some.items() if values is not None}
        elastic = (
            {
                "parameters": {name: last(values) for name, values in self.parameters.items()},
                "parameters_optimal": self.parameters_optimal,
            }
            if self.parameters
            else {}
        )
        asked = {
            "cost": last(self.cost),
            "cost_optimal": self.cost_optimal,
            "cost_without_springs": self.cost_without_springs,
            "cost_reduction": last(self.reduction),
            "cost_reduction_optimal": self.reduction_optimal,
        }
        joules = {
            name.replace("power", "energy"): self.period * value
            for name, value in self.motors.items()
            if name.startswith("electrical_power")
        }
        return {
            "start_s": self.start,
            "end_s": self.end,
            "cycles": len(self.cycles),
            "torque_reduction": last(self.torque_reduction),
            "torque_reduction_optimal": self.torque_reduction_optimal,
            "torque_squared": last(self.torque_squared),
            "torque_squared_without_springs": self.torque_squared_without_springs,
            "torque_squared_optimal": self.torque_squared_optimal,
            **({} if self.kind == "torque-squared" else asked),
            **self.motors,
            **joules,
            "tracking_rms": last(self.tracking_rms),
            **more,
            "stiffness": last(self.stiffness),
            "stiffness_optimal": self.stiffness_optimal.tolist(),
            "offset": last(self.offset),
            "offset_optimal": self.offset_optimal.tolist(),
            **elastic,
            "cycles_to_optimum": self.cycles_to_optimum,
        }


_PER_CYCLE = ("torque_squared", "torque_reduction", "torque_share", "tracking_rms", "passage")
_SPRINGS = ("stiffness", "offset", "equilibrium")
_RANGE = ("stiffness_least", "stiffness_most")
_PER_MOTION = (
    "start",
    "end",
    "period",
    "optimum_made",
    "size",
    "torque_squared_optimal",
    "torque_squared_without_springs",
)


def motions(data: xr.Dataset, kind: str) -> tuple[MotionOfRun, ...]:
    """The motions of a run, in order.

    Args:
        data: `Run.data`.
        kind: what the springs leave the least of, by the words of `springs.cost`.
    """
    of_cycle = data["segment_of_cycle"].values
    found = []
    for row, number in enumerate(data["segment"].values.tolist()):
        cycles = of_cycle == number
        source = "torque_squared" if kind == "torque-squared" else "cost"
        rotation, joints = (
            data[name].values[cycles] if name in data else None
            for name in ("rotation_rms", "joint_rms")
        )
        names = data["parameter"].values.tolist() if "parameter" in data else []
        found.append(
            MotionOfRun(
                number=number,
                rotation_rms=rotation,
                joint_rms=joints,
                swing=data["swing"].values[row].item() if "swing" in data else 0.0,
                kind=kind,
                cost=data[source].values[cycles],
                cost_optimal=data[f"{source}_optimal"].values[row].item(),
                cost_without_springs=data[f"{source}_without_springs"].values[row].item(),
                motors={name: data[name].values[row].item() for name in MOTORS if name in data},
                parameters={
                    name: data["parameters_per_cycle"].values[cycles, at]
                    for at, name in enumerate(names)
                },
                parameters_optimal={
                    name: data["parameters_optimal"].values[row, at].item()
                    for at, name in enumerate(names)
                },
                cycles=data["cycle"].values[cycles],
                center=data["center_per_cycle"].values[cycles],
                _data=data,
                **{name: data[name].values[cycles] for name in _PER_CYCLE},
                **{name: data[f"{name}_per_cycle"].values[cycles] for name in _SPRINGS},
                **{name: data[name].values[row] for name in _RANGE},
                **{f"{name}_optimal": data[f"{name}_optimal"].values[row] for name in _SPRINGS},
                **{name: data[name].values[row].item() for name in _PER_MOTION},
            )
        )
    return tuple(found)
