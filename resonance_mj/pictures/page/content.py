"""What a report says: of each run, and of several beside each other."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from ... import library
from ...errors import ExperimentError
from ...evaluation.checks import cases
from ...evaluation.checks.check import Judgement, judge
from ...experiments.expectations import Expect
from ...results.metrics import LEAST_REDUCTION
from ...results.run import Run
from ...status import Status
from ...text import NOTHING, duration, flat, joined, length, minus, percent, shown
from ..figures.catalogue import Entry

Figures = list[tuple[Entry, Markup]]
"""Figures of the catalogue, each as a part of the page."""

ENDED = {
    Status.DIVERGED: "The run diverged",
    Status.NOT_TRACKING: "The run was not tracking",
    Status.INTERRUPTED: "The run was interrupted",
    Status.DIVERGING: "The run was diverging",
    Status.IN_CONTACT: "The arm was in contact",
    Status.NOISY: "The motors acted on noise",
}
"""How a run that is not ok ended, in a sentence."""


@dataclass(frozen=True)
class Motion:
    """A motion of a run, and its last whole cycle.

    Attributes:
        number: from 1.
        about: shape, period and cycles in words.
        of: cycles of the experiment.
        last: as in summary.json, and equilibrium and equilibrium_optimal (n,) [rad] besides: where
            the springs are at rest; NaN for a joint that has none.
        tracks: whether the tool follows its path in the last whole cycle.
        what: the springs leave the least of.
    """

    number: int
    about: str
    of: int
    last: dict[str, Any]
    tracks: bool
    what: str

    @property
    def against(self) -> tuple[str, str]:
        """Torque² against that without springs: how much, and whether less, more or times it."""
        share = self.last["reduction"]
        if share is None:
            return NOTHING, ""
        if share > -9.995:
            return minus(percent(abs(share))), "less" if share >= 0 else "more"
        return f"{1 - share:,.0f}" if share > -1e9 else f"{1 - share:.3g}", "times the"

    @property
    def reached(self) -> str:
        """First cycle at the optimum; without a whole cycle, or an optimum, none can be told."""
        best = self.last["reduction_optimal"]
        if not self.last["cycles"] or best is None or best > 1 - LEAST_REDUCTION:
            return NOTHING
        return str(self.last["cycles_to_optimum"] or "never")


@dataclass(frozen=True)
class Content:
    """What a report says of a run.

    Attributes:
        run: the run.
        label: what the page calls it.
        anchor: begins the ids of its part of the page.
        source: the folder it was read from; None for a run that was not.
        figures: of the catalogue, each as a part of the page.
    """

    run: Run
    label: str
    anchor: str
    source: Path | None
    figures: Figures

    @property
    def folder(self) -> str:
        """Name of the folder it was read from; empty for a run that was not."""
        return self.source.resolve().name if self.source else ""

    @property
    def files(self) -> list[str]:
        """The user's own files that the experiment names."""
        return [one.path.name for one in self.run.inputs if one.key]

    @cached_property
    def motions(self) -> list[Motion]:
        """Its motions and their last whole cycles."""
        found = []
        segments = self.run.summary()["segments"]
        given = self.run.experiment.motion
        for motion, asked, last in zip(self.run.motions, given, segments, strict=True):
            angles = np.where(motion.stiffness, motion.equilibrium, np.nan)
            last["equilibrium"] = angles[-1].tolist() if last["cycles"] else None
            last["equilibrium_optimal"] = motion.equilibrium_optimal.tolist()
            about = f"{asked.shape}, {asked.cycles} cycles of {duration(asked.period)}"
            carried = "".join(f", {load}" for load in _loads(asked.payload))
            tracks = bool(motion.tracks[-1:].any())
            # What the page speaks of is the cost that was asked for.
            last["reduction"] = last.get("cost_reduction", last["torque_reduction"])
            best = last.get("cost_reduction_optimal", last["torque_reduction_optimal"])
            last["reduction_optimal"] = best
            what = f"{'motor ' * (motion.kind == 'torque-squared')}{self.run.cost.name}"
            found.append(Motion(motion.number, about + carried, asked.cycles, last, tracks, what))
        return found

    @cached_property
    def judged(self) -> tuple[list[Judgement], str]:
        """Verdicts on what the experiment expects, and why there are none."""
        run = self.run
        if run.experiment.expect == Expect():
            return [], ""
        try:
            cases.fit(run.experiment, run.data["joint"].values.tolist(), run.experiment.name)
            return list(judge(run)), ""
        except ExperimentError as error:
            return [], f"expectations are not judged: {error}"

    @property
    def verdicts(self) -> list[Judgement]:
        """Verdicts on what the experiment expects; empty where it expects nothing."""
        return self.judged[0]

    @property
    def notes(self) -> list[str]:
        """What was found, changed or is doubtful; what could not be judged."""
        return [*self.run.notes, *filter(None, self.judged[1:])]

    @property
    def facts(self) -> dict[str, str]:
        """What was run, by name."""
        experiment, data = self.run.experiment, self.run.data
        mjcf, law = experiment.robot.mjcf, experiment.law
        built_in = library.robots().get(mjcf)
        joints = data["joint"].values.tolist()
        robot = f"{mjcf}: {library.line(built_in)}" if built_in else Path(mjcf).name
        step = f"{1e3 * experiment.simulation.timestep:g} ms"
        facts = {
            "Robot": robot,
            "Joints": f"{len(joints)}: {', '.join(joints)}",
            "Task": f"{', '.join(data['axis'].values.tolist())} of the tool",
            "Law": law.kind + (f", J {law.jacobian}" if law.jacobian else ""),
            "Integration": f"{experiment.simulation.integrator}, a step each {step}",
            "Simulated": f"{self.run.steps} steps in "
            f"{self.run.simulation_wall_s:.2f} s of computing",
        }
        if data.attrs["thinned"]:
            kept = len(set(data["cycle_of_sample"].values.tolist()))
            facts["Samples"] = f"of {kept} of {data.sizes['cycle']} cycles were kept"
        if self.source is not None:
            made = datetime.fromtimestamp((self.source / "run.nc").stat().st_mtime)
            facts["Made"] = f"{made:%Y-%m-%d %H:%M}"
        return facts

    @property
    def joints(self) -> list[tuple[str, bool]]:
        """Names of the joints, and whether each slides."""
        data = self.run.data
        return list(zip(data["joint"].values.tolist(), data["slides"].values > 0, strict=True))

    @property
    def missed(self) -> int:
        """Expectations that the run missed."""
        return sum(not verdict.passed for verdict in self.verdicts)

    @property
    def headline(self) -> str:
        """The numbers that matter in a sentence or two."""
        run, done, said = self.run, [each for each in self.motions if each.last["cycles"]], ""
        if run.status is not Status.OK:
            whole, wanted = run.data.sizes["cycle"], sum(each.of for each in self.motions)
            said = f"{ENDED[run.status]} after {whole} whole cycles of {wanted}. "
        if not done:
            return said + "It has no whole cycle to measure."
        done = [done[0], done[-1]] if len(done) > 3 else done
        needed, best = [], []
        for each in done:
            much, kind = each.against
            where = f" in motion {each.number}" * (len(self.motions) > 1)
            if not each.tracks:
                off = run.motions[each.number - 1].off
                said += f"{off[0].upper()}{off[1:]}{where}: its torque is of another one. "
                continue
            needed.append(
                (f"{much} {kind} {run.cost.name}" if kind else "torque where none is due") + where
            )
            best.append(percent(each.last["reduction_optimal"]) if kind else "nothing")
        error = [length(each.last["tracking_rms"]) for each in done if each.tracks]
        if not error:
            return said.rstrip()
        return (
            f"{said}Compared with no springs, the motors end up needing {joined(needed)}; the best "
            f"constant springs would save {joined(best)}. The tool is {joined(error)} RMS off its "
            "path."
        )


def best(contents: Sequence[Content]) -> str:
    """Which run saves the most motor torque in each motion, in a sentence."""
    found: dict[str, list[str]] = {}
    for motions in zip(*(each.motions for each in contents), strict=False):
        shares = [motion.last["reduction"] for motion in motions]
        if None not in shares and all(motion.tracks for motion in motions):
            leader = max(range(len(shares)), key=shares.__getitem__)
            place = f"{percent(shares[leader])} in motion {motions[0].number}"
            found.setdefault(contents[leader].label, []).append(place)
    if not found:
        return f"{len(contents)} runs, which have no reduction of torque in common to compare."
    said = "; ".join(f"{leader}, {joined(where)}" for leader, where in found.items())
    what = joined(list(dict.fromkeys(one.motions[0].what for one in contents)))
    return f"The greatest reduction of {what} against no springs: {said}."


def differences(runs: Sequence[Run]) -> dict[str, list[str]]:
    """The keys in which the experiments differ, besides their names and what is expected.

    Returns:
        By key the value in each run; empty where the key is not given.
    """

    def written(value: object) -> str:
        return "" if value is None else shown(value, 200).replace("'", "")

    tables = [flat(run.experiment.model_dump()) for run in runs]
    keys = dict.fromkeys(key for table in tables for key in table)
    rows = {key: [written(table.get(key)) for table in tables] for key in keys}
    return {key: values for key, values in rows.items() if len(set(values)) > 1}


def _loads(payload: float | tuple[tuple[float, ...], ...]) -> list[str]:
    """What a tool carries, and when."""
    if isinstance(payload, float):
        return [f"payload {payload:g} kg"] if payload else []
    return [f"payload {mass:g} kg from {begin:g} to {end:g} s" for begin, end, mass in payload]
