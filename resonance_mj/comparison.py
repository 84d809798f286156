"""The laws that users compare, on one experiment: what each is, and how good and lasting it is."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import metrics
from .errors import ExperimentError
from .experiment import Experiment
from .files import replacing, writable
from .robot import build
from .run import Run, Status
from .simulation import Progress, simulate_many

Changes = dict[str, Any]

STIFFNESS_RATE, OFFSET_RATE = 200.0, 500.0
"""Γ_k and Γ_qe per inertia [1/(rad² s²), 1/s²], where none are given: the paper's on its arm."""

SHORTEST = 20
"""Fewest cycles of the last motion that say whether a law lasts."""

STEADY = 0.05
"""Relative spread of torque² over the second half of a long run up to which it counts as held."""


class Contender(NamedTuple):
    """A law to compare: an experiment's, but for some keys."""

    name: str
    """Of its folder."""
    title: str
    changes: Callable[[Experiment], Changes]


def _always(**changes: Any) -> Callable[[Experiment], Changes]:
    return lambda experiment: {f"law.{key}": value for key, value in changes.items()}


def _without_springs(kind: str) -> Callable[[Experiment], Changes]:
    return lambda experiment: {
        "law.kind": kind,
        "law.lead": None,
        "law.harmonics": None,
        "springs.initial_stiffness": 0.0,
        "springs.initial_equilibrium": 0.0,
    }


def _printed(**changes: Any) -> Callable[[Experiment], Changes]:
    """A law of the authors', with adaptation gains for experiments that have none."""

    def of(experiment: Experiment) -> Changes:
        law, found = experiment.law, {"lead": 0, "harmonics": None, **changes}
        if not np.any(law.gamma_k) and not np.any(law.gamma_qe):
            inertia = np.diag(build(experiment).inertia)
            found["gamma_k"] = (STIFFNESS_RATE * inertia).tolist()
            found["gamma_qe"] = (OFFSET_RATE * inertia).tolist()
        return {f"law.{key}": value for key, value in found.items()}

    return of


def _transfer(experiment: Experiment) -> Changes:
    """Its own settings where the experiment has the law; else what lead and low-pass allow."""
    law = experiment.law
    if law.kind == "transfer":
        return {}
    changes = {
        "kind": "transfer",
        "jacobian": None,
        "beta": None if law.beta is None else 10 * law.beta,
        "gamma_k": 0.0,
        "gamma_qe": 0.0,
        "lead": 2,
        "harmonics": None,
    }
    return {f"law.{key}": value for key, value in changes.items()}


CONTENDERS = (
    Contender("feedback", "feedback only", _without_springs("feedback")),
    Contender("learning", "learning only", _without_springs("learning")),
    Contender("fixed", "optimal springs", _always(kind="fixed", lead=None, harmonics=None)),
    Contender(
        "joint-space", "joint space [4]", _printed(kind="joint-space", q_c="mean", q_s="mean")
    ),
    Contender("printed", "as printed", _printed(kind="paper", jacobian=None)),
    Contender("printed-transpose", "as printed, Jᵀ", _printed(kind="paper", jacobian="transpose")),
    Contender("printed-lead", "as printed, lead 1", _printed(kind="paper", jacobian=None, lead=1)),
    Contender("transfer", "transfer", _transfer),
    Contender("computed-torque", "computed torque", _always(kind="computed-torque")),
)
"""What is compared, from the law that knows least to the one that knows all."""


class Verdict(NamedTuple):
    """What a long run of the last motion showed."""

    diverged: int | None
    """Cycle of the motion in which it diverged, 0 for an earlier motion; None if it did not."""
    lowest: float
    """Least torque² of the second half, as a multiple of the optimum's."""
    highest: float
    """Greatest torque² of the second half, as a multiple of the optimum's."""

    def __str__(self) -> str:
        if self.diverged is not None:
            return f"DIVERGED at {self.diverged}" if self.diverged else "DIVERGED before"
        band = metrics.OPTIMUM_BAND
        if 1 - band <= self.lowest and self.highest <= 1 + band:
            return "holds the optimum"
        if self.highest <= (1 + STEADY) * self.lowest:
            return f"{self.highest:.3g} × optimum"
        return f"{self.lowest:.2g}-{self.highest:.2g} × optimum"


@dataclass(frozen=True)
class Comparison:
    """Runs of one experiment under several laws.

    Attributes:
        experiment: what was compared, with its own law.
        contenders: the laws, in order.
        runs: the experiment under each law, by its name.
        long: the same with the last motion repeated long; empty if none was asked for.
    """

    experiment: Experiment
    contenders: tuple[Contender, ...]
    runs: dict[str, Run]
    long: dict[str, Run]

    def rows(self) -> list[dict[str, Any]]:
        """A dict per law and motion, of the motion's last cycle.

        law, title, motion, torque_reduction, torque_reduction_optimal, share (of the possible
        reduction), cycles_to_optimum, tracking_rms [m], peak_torque (the highest of any joint)
        [N m], energy (the sum over joints of ∫|τ q̇| dt, without recuperation) [J], status, and
        long_run in the last motion's. None for what a run that diverged did not reach.
        """
        return [
            {"law": contender.name, "title": contender.title, **figures}
            for contender in self.contenders
            for figures in self._of(contender.name)
        ]

    def verdict(self, name: str) -> Verdict | None:
        """What the long run of a law showed; None if there was none."""
        if name not in self.long:
            return None
        run = self.long[name]
        last = run.data["segment"].values[-1]
        mine = run.data.sel(segment=last, cycle=run.data["segment_of_cycle"] == last)
        ratio = (mine["torque_squared"] / mine["torque_squared_optimal"]).values
        if run.status is Status.DIVERGED:
            return Verdict(len(ratio) + _fell(run) if len(ratio) else 0, np.inf, np.inf)
        second = ratio[len(ratio) // 2 :]
        return Verdict(None, float(second.min()), float(second.max()))

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write compare.json, compare.csv, and each law's run into a folder of its own.

        Raises:
            OutputError: a folder cannot be written.
        """
        folder = writable(folder)
        for name, run in self.runs.items():
            run.save(folder / name)
        for name, run in self.long.items():
            run.save(folder / name / "long")
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

    def _of(self, name: str) -> list[dict[str, Any]]:
        run, verdict = self.runs[name], self.verdict(name)
        segments = run.summary()["segments"]
        found = []
        for number, one in enumerate(segments, start=1):
            reduction, possible = one["torque_reduction"], one["torque_reduction_optimal"]
            last = number == len(segments)
            found.append(
                {
                    "motion": number,
                    "torque_reduction": reduction,
                    "torque_reduction_optimal": possible,
                    "share": None if reduction is None else reduction / possible,
                    "cycles_to_optimum": one["cycles_to_optimum"],
                    "tracking_rms": one["tracking_rms"],
                    **_effort(run, number),
                    "status": str(run.status),
                    "long_run": str(verdict) if verdict and last else None,
                }
            )
        return found


def compare(
    experiment: Experiment,
    *,
    long: int = 1000,
    threads: int = 0,
    progress: Progress | None = None,
) -> Comparison:
    """Simulate an experiment under each law that users compare, many at a time.

    Args:
        experiment: what to compare on; of its law, gains are taken that fit the others. If its law
            is a file, it is compared as well.
        long: how many cycles of the last motion show whether a law lasts; 0 for none.
        threads: how many to use; 0 for all cores.
        progress: called with the cycles done and the cycles of all runs.

    Raises:
        ExperimentError: `long` is neither 0 nor at least 20.
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
        CallbackError: another simulation is running in this process.
    """
    if long and long < SHORTEST:
        raise ExperimentError(
            f"long = {long}: 0 for no long run, or at least {SHORTEST} cycles of the last motion"
        )
    contenders: tuple[Contender, ...] = CONTENDERS
    if experiment.law.kind.endswith(".py"):
        contenders += (Contender("own", Path(experiment.law.kind).name, _always()),)
    found = {one.name: experiment.replace(one.changes(experiment)) for one in contenders}
    lasting = {name: _lengthened(one, long) for name, one in found.items()} if long else {}
    runs = simulate_many([*found.values(), *lasting.values()], threads=threads, progress=progress)
    return Comparison(
        experiment=experiment,
        contenders=contenders,
        runs=dict(zip(found, runs, strict=False)),
        long=dict(zip(lasting, runs[len(found) :], strict=True)),
    )


def _lengthened(experiment: Experiment, cycles: int) -> Experiment:
    """With the last motion repeated so often, and few samples kept."""
    index, motion = len(experiment.motion) - 1, experiment.motion[-1]
    return experiment.replace(
        {f"motion.{index}.duration": cycles * motion.period, "simulation.samples": 1}
    )


def _effort(run: Run, segment: int) -> dict[str, float | None]:
    """Peak torque [N m] and energy [J] of the motors in the last cycle of a motion."""
    data, experiment = run.data, run.experiment
    motion = experiment.motion[segment - 1]
    last = sum(one.cycles for one in experiment.motion[:segment])
    cycle = data.sel(time=data["cycle_of_sample"] == last)
    if cycle.sizes["time"] < motion.steps(experiment.simulation.timestep):
        return {"peak_torque": None, "energy": None}
    power = np.abs(cycle["tau"].values * cycle["dq"].values).sum(axis=1)
    return {
        "peak_torque": float(np.abs(cycle["tau"].values).max()),
        "energy": float(power.sum() * experiment.simulation.timestep),
    }


def _fell(run: Run) -> bool:
    """Whether a run ended within a cycle."""
    return int(run.data["cycle_of_sample"].values[-1]) > run.data.sizes["cycle"]
