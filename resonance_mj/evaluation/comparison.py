"""The laws that users compare, on one experiment: how good each is, and whether it lasts."""

import csv
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..errors import ExperimentError
from ..experiments.experiment import Experiment
from ..files import replacing, writable
from ..laws.gains import adaptation
from ..progress import Asked
from ..results import html, metrics
from ..results.motions import MotionOfRun
from ..results.run import Run, Status, finite
from ..robots.robot import build
from ..simulation.simulation import simulate_many
from ..springs.cost import KINDS
from ..text import length, percent

SHORTEST = 20
"""Fewest cycles of the last motion that say whether a law lasts."""

STEADY = 0.05
"""Relative spread of torque² over the second half of a long run up to which it counts as held."""

OF_SUMMARY = ("torque_reduction", "torque_reduction_optimal", "cycles_to_optimum", "tracking_rms")
"""What a row has of a run's summary."""

Changes = dict[str, Any]

BETA = 10.0
"""Learning gain of the transfer for K_v of the paper's size [N m s/rad]."""


class Contender(NamedTuple):
    """A law to compare: its name, also of its folder, and what differs from an experiment's."""

    name: str
    title: str
    changes: Changes


NO_SPRINGS: Changes = {"springs.initial_stiffness": 0.0, "springs.initial_equilibrium": 0.0}
FOUND: Changes = {"law.lead": None, "law.harmonics": None}
PRINTED: Changes = {
    "law.kind": "paper", "law.lead": 0, "law.harmonics": None, "law.jacobian": None
}  # fmt: skip
JOINT_SPACE: Changes = {
    "law.kind": "joint-space",
    "law.q_c": "mean",
    "law.q_s": "mean",
    "springs.initial_equilibrium": 0.0,
}
TRANSFER: Changes = {
    "law.kind": "transfer", "law.lead": 2, "law.gamma_k": 0.0, "law.gamma_qe": 0.0
}  # fmt: skip

CONTENDERS = (
    Contender("feedback", "feedback only", {"law.kind": "feedback", **NO_SPRINGS}),
    Contender("learning", "learning only", {"law.kind": "learning", **NO_SPRINGS, **FOUND}),
    Contender("fixed", "optimal springs", {"law.kind": "fixed", **FOUND}),
    Contender("joint-space", "joint space", PRINTED | JOINT_SPACE),
    Contender("printed", "as printed", PRINTED),
    Contender("printed-transpose", "as printed, Jᵀ", PRINTED | {"law.jacobian": "transpose"}),
    Contender("printed-lead", "as printed, lead 1", PRINTED | {"law.lead": 1}),
    Contender("transfer", "transfer", PRINTED | TRANSFER),
    Contender("computed-torque", "computed torque", {"law.kind": "computed-torque"}),
)
"""What is compared, from the law that knows least to the one that knows all."""


def contending(experiment: Experiment) -> list[tuple[Contender, Experiment]]:
    """The experiment under each law, with gains that fit it where it has none of the law's kind.

    The transfer has the experiment's own settings where that is its law; a law of the user's own is
    compared as well.
    """
    law, found = experiment.law, []
    adapts = np.any(law.gamma_k) or np.any(law.gamma_qe)
    rates = {} if adapts else adaptation(build(experiment))
    for one in CONTENDERS:
        changes = dict(one.changes)
        if changes["law.kind"] in ("paper", "joint-space") and not adapts:
            changes |= {f"law.{name}": gamma.tolist() for name, gamma in rates.items()}
        if changes["law.kind"] == "transfer":
            changes["law.beta"] = None if law.k_v is None else BETA
            if law.kind == "transfer":
                changes = {}
        found.append((one, experiment.replace(changes)))
    if law.kind.endswith(".py"):
        found.append((Contender("own", Path(law.kind).name, {}), experiment))
    return found


class Verdict(NamedTuple):
    """What a long run of the last motion showed."""

    diverged: int | None
    """Cycle of the motion in which it diverged, 0 for an earlier motion; None if it did not."""
    lowest: float
    """Least cost of the second half, as a multiple of the optimum's; NaN if that is 0."""
    highest: float
    """Greatest cost of the second half, as a multiple of the optimum's."""

    def __str__(self) -> str:
        if self.diverged is not None:
            return f"DIVERGED at {self.diverged}" if self.diverged else "DIVERGED before"
        if np.isnan(self.lowest):
            return "the optimum needs no torque"
        band = metrics.OPTIMUM_BAND
        if 1 - band <= self.lowest and self.highest <= 1 + band:
            return "holds the optimum"
        if self.highest <= (1 + STEADY) * self.lowest:
            return f"{self.highest:.3g} × optimum"
        return f"{self.lowest:.2g}-{self.highest:.2g} × optimum"


@dataclass(frozen=True, repr=False)
class Comparison:
    """Runs of one experiment under several laws.

    Attributes:
        experiment: what was compared, with its own law.
        titles: what each law is called, by its name.
        runs: the experiment under each law, by its name.
        long: the same with the last motion repeated long; empty if none was asked for.
    """

    experiment: Experiment
    titles: dict[str, str]
    runs: dict[str, Run]
    long: dict[str, Run]

    def __repr__(self) -> str:
        return f"<Comparison of {self.experiment.name!r}: {', '.join(self.titles)}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the rows, but for those of what needs no word."""
        less = f"{self.cost} less by"
        head = ("law", "motion", less, "tracking RMS", "cycles to the best", "status")
        rows = (
            [
                row["title"],
                str(row["motion"]),
                percent(row["reduction"]),
                length(row["tracking_rms"]),
                str(row["cycles_to_optimum"] or "never"),
                row["status"],
            ]
            for row in self.rows()
        )
        return html.table(f"{self.experiment.name}: last cycle of each motion", head, rows)

    @property
    def cost(self) -> str:
        """What the springs leave the least of."""
        return KINDS[self.experiment.springs.cost].name

    def rows(self) -> list[dict[str, Any]]:
        """A dict per law and motion, of the motion's last cycle.

        law, title, motion, share (of the possible reduction), reduction and reduction_optimal of
        the cost, torque_reduction, torque_reduction_optimal, cycles_to_optimum, tracking_rms [m],
        peak_torque (the highest of any joint) [N m], energy (the sum over joints of ∫|τ q̇| dt,
        without recuperation) [J], status, and long_run in the last motion's. None for what a run
        that diverged did not reach, and for a share of nothing.
        """
        return [
            finite(self._row(name, motion))
            for name in self.titles
            for motion in self.runs[name].motions
        ]

    def verdict(self, name: str) -> Verdict | None:
        """What the long run of a law showed; None if there was none."""
        if name not in self.long:
            return None
        run = self.long[name]
        motion = run.motions[-1]
        if run.status is Status.DIVERGED:
            before = sum(one.cycles for one in run.experiment.motion[:-1])
            whole, of = run.data.sizes["cycle"], run.data["cycle_of_sample"].values
            # In the last whole cycle, or in the one that follows.
            ended = whole if len(of) and of[-1] <= whole else whole + 1
            return Verdict(max(0, ended - before), np.inf, np.inf)
        if not motion.cost_optimal > 0:
            return Verdict(None, np.nan, np.nan)
        second = motion.cost[len(motion.cycles) // 2 :] / motion.cost_optimal
        return Verdict(None, float(second.min()), float(second.max()))

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write compare.json, compare.csv, and each law's run into a folder of its own.

        Of the long runs, long.nc holds torque² and tracking RMS per cycle.

        Raises:
            OutputError: a folder cannot be written.
        """
        folder = writable(folder)
        for name, run in self.runs.items():
            run.save(folder / name)
        if self.long:
            kept = [run.data[["torque_squared", "tracking_rms"]] for run in self.long.values()]
            law = xr.DataArray(list(self.long), dims="law", name="law")
            with replacing(folder / "long.nc") as path:
                xr.concat(kept, law, join="outer").to_netcdf(path, engine="h5netcdf")
        rows = self.rows()
        with replacing(folder / "compare.json") as path:
            path.write_text(json.dumps(rows, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        with (
            replacing(folder / "compare.csv") as path,
            path.open("w", encoding="utf-8", newline="") as file,
        ):
            table = csv.DictWriter(file, list(rows[0]))
            table.writeheader()
            table.writerows(rows)
        return folder

    def _row(self, name: str, motion: MotionOfRun) -> dict[str, Any]:
        run, share = self.runs[name], motion.share
        verdict = self.verdict(name) if motion.number == len(run.motions) else None
        return {
            "law": name,
            "title": self.titles[name],
            "motion": motion.number,
            "share": share[-1].item() if len(share) else None,
            "reduction": motion.reduction[-1].item() if len(share) else None,
            "reduction_optimal": motion.reduction_optimal,
            **{key: motion.summary()[key] for key in OF_SUMMARY},
            **_effort(run, motion),
            "status": str(run.status),
            "long_run": str(verdict) if verdict else None,
        }


def compare(
    experiment: Experiment,
    *,
    long: int = 1000,
    threads: int = 0,
    progress: Asked = None,
) -> Comparison:
    """Simulate an experiment under each law that users compare, many at a time.

    Args:
        experiment: what to compare on; of its law, gains are taken that fit the others. If its law
            is a file, it is compared as well.
        long: how many cycles of the last motion show whether a law lasts; 0 for none.
        threads: how many to use; 0 for all cores.
        progress: called with the cycles done and the cycles of all runs; a bar in a terminal or a
            notebook if not given, nothing for False.

    Raises:
        ExperimentError: `long` is neither 0 nor at least 20.
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
        CallbackError: another program's callback is installed in this process.
    """
    if long and long < SHORTEST:
        raise ExperimentError(
            f"long = {long}: 0 for no long run, or at least {SHORTEST} cycles of the last motion"
        )
    laws, each = zip(*contending(experiment), strict=True)
    duration = f"motion.{len(experiment.motion) - 1}.duration"
    lasting = {duration: long * experiment.motion[-1].period, "simulation.samples": 1}
    names = [law.name for law in laws]
    longer = [one.replace(lasting) for one in each] if long else []
    runs = simulate_many([*each, *longer], threads=threads, progress=progress)
    return Comparison(
        experiment=experiment,
        titles={law.name: law.title for law in laws},
        runs=dict(zip(names, runs[: len(each)], strict=True)),
        long=dict(zip(names, runs[len(each) :], strict=False)),
    )


def _effort(run: Run, motion: MotionOfRun) -> dict[str, float | None]:
    """Peak torque [N m] and energy [J] of the motors in the last cycle of a motion."""
    planned = run.experiment.motion[motion.number - 1].cycles
    if len(motion.cycles) < planned:
        return {"peak_torque": None, "energy": None}
    samples = motion.samples
    last = samples.isel(time=samples["cycle_of_sample"].values == motion.cycles[-1])
    power = np.abs(last["tau"].values * last["dq"].values).sum(axis=1)
    return {
        "peak_torque": float(np.abs(last["tau"].values).max()),
        "energy": float(power.sum() * run.experiment.simulation.timestep),
    }
