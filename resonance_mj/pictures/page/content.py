"""What a report says of one run: a headline, its motions, its verdicts, its origin."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from ... import library
from ...errors import ExperimentError
from ...evaluation.checks import cases, convergence
from ...evaluation.checks.check import judge
from ...experiments.expectations import Expect
from ...results.run import Run
from ...status import Status
from .motions import Motion, motions
from .wording import listed, minus


class Verdict(NamedTuple):
    """What was expected of a figure, and what was found."""

    motion: int
    figure: str
    expected: str
    tolerance: str
    found: str
    passed: bool


@dataclass(frozen=True)
class Content:
    """What a report says of a run; `parts` of the page are filled from it.

    Attributes:
        run: the run.
        label: what the page calls it.
        anchor: begins the ids of its part of the page.
        folder: where it was read from; None for a run that was not.
        motions: their last whole cycles.
        verdicts: on what the experiment expects; empty where it expects nothing.
        notes: what was found, changed or is doubtful; what could not be judged.
        facts: what was run, name and value.
        files: what the experiment needs besides itself to be run again.
    """

    run: Run
    label: str
    anchor: str
    folder: Path | None
    motions: tuple[Motion, ...]
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...]
    facts: tuple[tuple[str, str], ...]
    files: tuple[str, ...]

    @property
    def missed(self) -> int:
        """Expectations that the run missed."""
        return sum(not verdict.passed for verdict in self.verdicts)

    @property
    def headline(self) -> str:
        """The numbers that matter in a sentence or two."""
        return _headline(self)


def content(run: Run, label: str, anchor: str, folder: Path | None) -> Content:
    """Gather what a report says of a run.

    Args:
        run: the run.
        label: what the page calls it.
        anchor: begins the ids of its part of the page.
        folder: where it was read from, if it was.
    """
    verdicts: tuple[Verdict, ...] = ()
    notes = run.notes
    if run.experiment.expect != Expect():
        try:
            cases.fit(run.experiment, run.data["joint"].values.tolist(), run.experiment.name)
            verdicts = _verdicts(run)
        except ExperimentError as error:
            notes += (f"expectations are not judged: {error}",)
    facts = _facts(run, folder)
    return Content(run, label, anchor, folder, motions(run), verdicts, notes, facts, _files(run))


def _verdicts(run: Run) -> tuple[Verdict, ...]:
    return tuple(
        Verdict(
            one.motion,
            convergence.figure(one).replace("_", " ").replace("rms", "RMS"),
            minus(convergence.expected(one.band)),
            convergence.tolerance(one.band),
            minus(convergence.number(one.found, one.band)),
            one.passed,
        )
        for one in judge(run)
    )


def _headline(of: Content) -> str:
    run, done = of.run, [motion for motion in of.motions if motion.cycles]
    said = ""
    if run.status is not Status.OK:
        whole, wanted = sum(m.cycles for m in of.motions), sum(m.of for m in of.motions)
        said = f"The run {run.status} after {whole} whole cycles of {wanted}. "
    if not done:
        return said + "It has no whole cycle to measure."
    several = len(of.motions) > 1
    where = [f" in motion {motion.number}" if several else "" for motion in done]
    if len(done) > 3:
        done, where = [done[0], done[-1]], [" in the first motion", " in the last"]
    less = [
        "{} {} torque²{}".format(*motion.against, place)
        for motion, place in zip(done, where, strict=True)
    ]
    best = [motion.reduction.optimal.text for motion in done]
    error = [motion.tracking.text for motion in done]
    return (
        f"{said}Compared with no springs, the motors end up needing {listed(less)}; the best "
        f"constant springs would save {listed(best)}. The tool is {listed(error)} RMS off its path."
    )


def _facts(run: Run, folder: Path | None) -> tuple[tuple[str, str], ...]:
    experiment, data = run.experiment, run.data
    mjcf = experiment.robot.mjcf
    built_in = library.robots().get(mjcf)
    joints = [str(name) for name in data["joint"].values]
    about = f": {library.line(built_in)}" if built_in else ""
    law = experiment.law.kind + (f", J {experiment.law.jacobian}" * bool(experiment.law.jacobian))
    step = f"{1e3 * experiment.simulation.timestep:g} ms"
    facts = [
        ("Robot", f"{mjcf if built_in else Path(mjcf).name}{about}"),
        ("Joints", f"{len(joints)}: {', '.join(joints)}"),
        ("Task", f"{', '.join(map(str, data['axis'].values))} of the tool"),
        ("Law", law),
        ("Integration", f"{experiment.simulation.integrator}, a step each {step}"),
        ("Simulated", f"{run.steps} steps in {run.simulation_wall_s:.2f} s of computing"),
    ]
    if data.attrs["thinned"]:
        kept = len(set(data["cycle_of_sample"].values.tolist()))
        facts.append(("Samples", f"of {kept} of {data.sizes['cycle']} cycles were kept"))
    if folder is not None:
        made = datetime.fromtimestamp((folder / "run.nc").stat().st_mtime)
        facts.append(("Made", f"{made:%Y-%m-%d %H:%M}"))
    return tuple(facts)


def _files(run: Run) -> tuple[str, ...]:
    """Files of the user's own that the experiment names: they are not in the page."""
    experiment = run.experiment
    mjcf = experiment.robot.mjcf
    named = [mjcf] if mjcf not in library.robots() and not mjcf.startswith("menagerie:") else []
    named += [experiment.law.kind] * experiment.law.kind.endswith(".py")
    named += [motion.file for motion in experiment.motion if motion.file]
    return tuple(dict.fromkeys(named))
