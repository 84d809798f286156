"""What a report says of one run: a headline, its motions, its verdicts, its origin."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from ... import library
from ...errors import ExperimentError
from ...evaluation.checks import cases
from ...evaluation.checks.check import Judgement, judge
from ...experiments.expectations import Expect
from ...results.metrics import LEAST_REDUCTION
from ...results.run import Run
from ...status import Status
from ...text import NOTHING, duration, joined, length, minus, percent


@dataclass(frozen=True)
class Motion:
    """A motion of a run, and its last whole cycle.

    Attributes:
        number: from 1.
        about: shape, period and cycles in words.
        of: cycles of the experiment.
        last: as in summary.json, and equilibrium and equilibrium_optimal (n,) [rad] besides: where
            the springs are at rest; NaN for a joint that has none.
    """

    number: int
    about: str
    of: int
    last: dict[str, Any]

    @property
    def against(self) -> tuple[str, str]:
        """Torque² against that without springs: how much, and whether less, more or times it."""
        share = self.last["torque_reduction"]
        if share is None:
            return NOTHING, ""
        if share > -9.995:
            return minus(percent(abs(share))), "less" if share >= 0 else "more"
        return f"{1 - share:,.0f}" if share > -1e9 else f"{1 - share:.3g}", "times the"

    @property
    def reached(self) -> str:
        """First cycle at the optimum; without a whole cycle, or an optimum, none can be told."""
        best = self.last["torque_reduction_optimal"]
        if not self.last["cycles"] or best is None or best > 1 - LEAST_REDUCTION:
            return NOTHING
        return str(self.last["cycles_to_optimum"] or "never")


@dataclass(frozen=True)
class Content:
    """What a report says of a run; `parts` of the page are filled from it.

    Attributes:
        run: the run.
        label: what the page calls it.
        anchor: begins the ids of its part of the page.
        folder: name of the folder it was read from; empty for a run that was not.
        motions: their last whole cycles.
        verdicts: on what the experiment expects; empty where it expects nothing.
        notes: what was found, changed or is doubtful; what could not be judged.
        facts: what was run, name and value.
        files: those of the user's own that the experiment names.
    """

    run: Run
    label: str
    anchor: str
    folder: str
    motions: tuple[Motion, ...]
    verdicts: tuple[Judgement, ...]
    notes: tuple[str, ...]
    facts: tuple[tuple[str, str], ...]
    files: tuple[str, ...]

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
            said = f"The run {run.status} after {whole} whole cycles of {wanted}. "
        if not done:
            return said + "It has no whole cycle to measure."
        done = [done[0], done[-1]] if len(done) > 3 else done
        needed, best = [], []
        for each in done:
            much, kind = each.against
            where = f" in motion {each.number}" * (len(self.motions) > 1)
            needed.append(
                (f"{much} {kind} torque²" if kind else "torque where none is due") + where
            )
            best.append(percent(each.last["torque_reduction_optimal"]) if kind else "nothing")
        error = [length(each.last["tracking_rms"]) for each in done]
        return (
            f"{said}Compared with no springs, the motors end up needing {joined(needed)}; the best "
            f"constant springs would save {joined(best)}. The tool is {joined(error)} RMS off its "
            "path."
        )


def content(run: Run, label: str, anchor: str, folder: Path | None) -> Content:
    """Gather what a report says of a run.

    Args:
        run: the run.
        label: what the page calls it.
        anchor: begins the ids of its part of the page.
        folder: where it was read from, if it was.
    """
    verdicts: tuple[Judgement, ...] = ()
    notes = run.notes
    if run.experiment.expect != Expect():
        try:
            cases.fit(run.experiment, run.data["joint"].values.tolist(), run.experiment.name)
            verdicts = tuple(judge(run))
        except ExperimentError as error:
            notes += (f"expectations are not judged: {error}",)
    return Content(
        run=run,
        label=label,
        anchor=anchor,
        folder=folder.resolve().name if folder else "",
        motions=tuple(_motions(run)),
        verdicts=verdicts,
        notes=notes,
        facts=tuple(_facts(run, folder)),
        files=tuple(one.path.name for one in run.inputs if one.key),
    )


def _motions(run: Run) -> Iterator[Motion]:
    for motion, given, last in zip(
        run.motions, run.experiment.motion, run.summary()["segments"], strict=True
    ):
        angles = np.where(motion.stiffness, motion.equilibrium, np.nan)
        last["equilibrium"] = angles[-1].tolist() if last["cycles"] else None
        last["equilibrium_optimal"] = motion.equilibrium_optimal.tolist()
        about = f"{given.shape}, {given.cycles} cycles of {duration(given.period)}"
        carried = f", payload {given.payload:g} kg" if given.payload else ""
        yield Motion(motion.number, about + carried, given.cycles, last)


def _facts(run: Run, folder: Path | None) -> list[tuple[str, str]]:
    experiment, data = run.experiment, run.data
    mjcf, law = experiment.robot.mjcf, experiment.law
    built_in = library.robots().get(mjcf)
    joints = data["joint"].values.tolist()
    about = f": {library.line(built_in)}" if built_in else ""
    step = f"{1e3 * experiment.simulation.timestep:g} ms"
    facts = [
        ("Robot", f"{mjcf if built_in else Path(mjcf).name}{about}"),
        ("Joints", f"{len(joints)}: {', '.join(joints)}"),
        ("Task", f"{', '.join(data['axis'].values.tolist())} of the tool"),
        ("Law", law.kind + (f", J {law.jacobian}" if law.jacobian else "")),
        ("Integration", f"{experiment.simulation.integrator}, a step each {step}"),
        ("Simulated", f"{run.steps} steps in {run.simulation_wall_s:.2f} s of computing"),
    ]
    if data.attrs["thinned"]:
        kept = len(set(data["cycle_of_sample"].values.tolist()))
        facts.append(("Samples", f"of {kept} of {data.sizes['cycle']} cycles were kept"))
    if folder is not None:
        made = datetime.fromtimestamp((folder / "run.nc").stat().st_mtime)
        facts.append(("Made", f"{made:%Y-%m-%d %H:%M}"))
    return facts
