"""A run: labelled arrays with units, how it ended, a summary; saved to a folder and loaded."""

from __future__ import annotations

import math
import os
import platform
import sys
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ..errors import OutputError
from ..experiments.experiment import Experiment
from ..springs import spring
from ..springs.cost import KINDS, Kind
from ..springs.elements import Elements
from ..springs.material import Material, material_of
from ..status import Status
from ..text import NOTHING, length, number, percent
from . import html, storing
from .motions import MotionOfRun, motions

if TYPE_CHECKING:
    from ..plan.inputs import Input
    from ..plan.plan import Plan


def versions() -> dict[str, str]:
    """Versions of this package and of those whose arithmetic a run depends on."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    found = {
        "python": platform.python_version(),
        "platform": f"{sys.platform}-{platform.machine()}",
    }
    for name in ("resonance-mj", "mujoco", "numpy", "numba", "xarray"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


@dataclass(frozen=True, repr=False)
class Run:
    """One simulated experiment.

    Attributes:
        experiment: what was simulated.
        status: how it ended.
        message: why, and what to try; empty if all went well.
        notes: what was found, changed or is doubtful, a line each.
        data: dims time | cycle | segment, joint, axis; every variable has units. Per time: q, dq,
            x, x_desired, tau, u, y, stiffness, offset, equilibrium, center, tau_optimal. Per cycle:
            torque_squared, tracking_rms, stiffness_per_cycle, offset_per_cycle. Per motion: the
            optimum. `schema.VARIABLES` has them all. `data.attrs["thinned"]` is 1 if only some
            cycles' samples were kept; `cycle_of_sample` says which.
        steps: time steps simulated.
        simulation_wall_s: wall time of the simulation alone [s].
        versions: of the packages that made it.
        inputs: the files that it depends on: robot, law, waypoints.
        found: of a run that was read, the keys that its experiment leaves open, as they were found.
        planned: the plan that was simulated; `plan` has that of any run.
    """

    experiment: Experiment
    status: Status
    message: str
    data: xr.Dataset
    steps: int
    simulation_wall_s: float
    notes: tuple[str, ...] = ()
    versions: dict[str, str] = field(default_factory=versions)
    inputs: tuple[Input, ...] = ()
    found: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    planned: Plan | None = field(default=None, repr=False, compare=False)

    @cached_property
    def plan(self) -> Plan:
        """What was known before the first step; built again for a run that was loaded.

        Raises:
            RobotError: the robot's file is missing or not valid.
            MotionError: the arm cannot make the motion.
        """
        from ..plan.plan import plan_for  # imports MuJoCo, which reading a run does not need

        if self.planned is not None and self.planned.experiment == self.experiment:
            return self.planned
        return plan_for(self.experiment)

    @cached_property
    def motions(self) -> tuple[MotionOfRun, ...]:
        """The motions of the run, each with its cycles, its optimum and its samples."""
        return motions(self.data, self.experiment.springs.cost)

    @property
    def cost(self) -> Kind:
        """What the springs leave the least of: its name and unit."""
        return KINDS[self.experiment.springs.cost]

    @property
    def stiffness(self) -> xr.DataArray:
        """Stiffness of each joint's spring in the last whole cycle (joint) [N m/rad]."""
        return self.data["stiffness_per_cycle"][-1]

    @property
    def equilibrium(self) -> xr.DataArray:
        """Equilibrium angle of each joint's spring in the last whole cycle (joint) [rad]."""
        return self.data["equilibrium_per_cycle"][-1]

    @property
    def material(self) -> Material | None:
        """What the joints' springs do besides Hooke's law; None for nothing."""
        return material_of(self.experiment.reality, self.data.sizes["joint"])

    def elements(self, parameters: np.ndarray) -> Elements:
        """The arm's elastic elements besides the joints' springs, with parameters (P,).

        Raises:
            RobotError: there are some, and the robot's file is missing or not valid.
        """
        return Elements(self.plan.robot.elements, parameters) if len(parameters) else Elements()

    def refuse_material(self, why: str) -> None:
        """Raise an OutputError if the run's springs are not linear."""
        if self.material is not None:
            raise OutputError(
                f"run {self.experiment.name!r}: its springs are not linear (reality.spring_*), and "
                f"{why}"
            )

    def elastic_torque(self, samples: xr.Dataset) -> np.ndarray:
        """Torque beside that of linear springs of the joints, at samples of the run (N, n) [N m].

        Args:
            samples: of the run's data, some of them.
        """
        cycle, q = samples["cycle_of_sample"].values, samples["q"].values
        found = np.zeros_like(q)
        if (material := self.material) is not None:
            k, offset, center, dq = (
                samples[name].values for name in ("stiffness", "offset", "center", "dq")
            )
            found += material.torque(k, offset, center, q, dq)
            found -= spring.torque(k, offset, q, center)
        if "parameter" in self.data:
            of_cycle = self.data["parameters_per_cycle"].values
            for number in np.unique(cycle):
                mine = cycle == number
                # A run that diverged ends within a cycle, whose elements were not kept.
                acting = self.elements(of_cycle[min(number, len(of_cycle)) - 1])
                found[mine] += acting.torque(q[mine])
        return found

    def __repr__(self) -> str:
        ended = [motion for motion in self.motions if len(motion.cycles)]
        reached = ", ".join(
            f"{percent(one.reduction[-1])} (best {percent(one.reduction_optimal)})" for one in ended
        )
        return (
            f"<Run {self.experiment.name!r}: {self.status}, {self.data.sizes['cycle']} cycles, "
            f"{self.cost.name} less by {reached or NOTHING}>"
        )

    def _repr_html_(self) -> str:
        """What a notebook shows: each motion's last cycle, and its springs beside the best."""
        rows = []
        for motion in self.motions:
            last = motion.summary()
            rows.append(
                [
                    f"motion {motion.number}",
                    motion.verdict,
                    f"{percent(motion.reduction[-1] if len(motion.cycles) else None)} (best "
                    f"{percent(motion.reduction_optimal)})",
                    length(last["tracking_rms"]),
                    *(
                        f"{number(mine)} ({number(best)})"
                        for mine, best in zip(
                            last["stiffness"] or [None] * len(motion.stiffness_optimal),
                            motion.stiffness_optimal,
                            strict=True,
                        )
                    ),
                ]
            )
        joints = [f"k {name} (best)" for name in self.data["joint"].values]
        head = ["", "the last cycle is", f"{self.cost.name} less by", "tracking RMS", *joints]
        return html.table(f"{self.experiment.name}: {self.status}. {self.message}", head, rows)

    def __getstate__(self) -> dict[str, Any]:
        """Without the plan, which holds MuJoCo's own memory."""
        fields = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return fields | {"planned": None}

    def summary(self) -> dict[str, Any]:
        """The dict that is written as summary.json."""
        return finite(
            {
                "name": self.experiment.name,
                "status": str(self.status),
                "message": self.message,
                "notes": list(self.notes),
                "versions": self.versions,
                "steps": self.steps,
                "simulation_wall_s": self.simulation_wall_s,
                "segments": [
                    motion.summary() for motion in motions(self.data, self.experiment.springs.cost)
                ],
            }
        )

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write run.nc, summary.json and experiment.toml into `folder`, which is made if needed.

        run.nc is the run; a folder inputs-* beside it has copies of the robot's files and of others
        that the experiment names, so that the folder can be sent, opened and run again elsewhere.
        All are written, or none.

        Raises:
            OutputError: the folder cannot be written.
        """
        return storing.save(self, folder)

    @staticmethod
    def load(folder: str | os.PathLike[str]) -> Run:
        """Read what `save` wrote. Nothing that the run names is executed.

        Raises:
            OutputError: the folder does not hold a run, or it or one of its inputs is not as saved.
        """
        return Run(**storing.load(folder))


def finite(value: Any) -> Any:
    """What JSON can hold of a value: it has no infinity and no NaN, which become null."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
