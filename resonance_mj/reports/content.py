"""What a report says of one run: its numbers beside the optimum's, its verdicts, its origin."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

from .. import library
from ..checks import cases, convergence
from ..checks.check import judge
from ..errors import ExperimentError
from ..experiments.expectations import Expect
from ..laws import springs
from ..results.run import Run
from ..status import Status
from .wording import Number, angle, length, listed, minus, percent, plain, seconds


class Beside(NamedTuple):
    """A number of the run beside that of the optimum."""

    found: Number
    optimal: Number


class Joint(NamedTuple):
    """The spring of a joint in a motion's last whole cycle."""

    name: str
    slides: bool
    stiffness: Beside
    offset: Beside
    equilibrium: Beside


@dataclass(frozen=True)
class Motion:
    """The last whole cycle of a motion.

    Attributes:
        number: from 1.
        about: shape, period and cycles in words.
        cycles: simulated whole, of so many.
        of: cycles of the experiment.
        reduction: torque reduction.
        torque: mean torque² [N² m²].
        without: the same without springs.
        tracking: RMS of the tool's position error.
        rotation: RMS of its rotation error; None where the task has none.
        reached: first cycle at the optimum.
        joints: their springs.
    """

    number: int
    about: str
    cycles: int
    of: int
    reduction: Beside
    torque: Beside
    without: Number
    tracking: Number
    rotation: Number | None
    reached: Number
    joints: tuple[Joint, ...]

    @property
    def against(self) -> tuple[str, str]:
        """Torque² against that without springs: how much, and whether less, more or times it."""
        share = self.reduction.found.value
        if share is None:
            return self.reduction.found.text, ""
        if share > -9.995:
            return percent(abs(share)).text, "less" if share >= 0 else "more"
        return f"{1 - share:,.0f}" if share > -1e9 else f"{1 - share:.3g}", "times the"


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
    files: tuple[str, ...] = field(default=())

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
    summary = run.summary()
    motions = tuple(_motion(run, i, segment) for i, segment in enumerate(summary["segments"]))
    verdicts: tuple[Verdict, ...] = ()
    notes = run.notes
    if run.experiment.expect != Expect():
        try:
            cases.fit(run.experiment, run.data["joint"].values.tolist(), run.experiment.name)
            verdicts = _verdicts(run)
        except ExperimentError as error:
            notes += (f"expectations are not judged: {error}",)
    facts = _facts(run, folder)
    return Content(run, label, anchor, folder, motions, verdicts, notes, facts, _files(run))


def _motion(run: Run, index: int, segment: dict[str, Any]) -> Motion:
    of = run.experiment.motion[index]
    data = run.data.sel(segment=index + 1)

    def beside(name: str, j: int) -> Beside:
        found = segment[name][j] if segment[name] else None
        return Beside(plain(found), plain(segment[f"{name}_optimal"][j]))

    joints = tuple(
        Joint(
            str(name),
            bool(run.data["slides"].values[j]),
            beside("stiffness", j),
            beside("offset", j),
            Beside(_equilibrium(run, index, j), plain(float(data["equilibrium_optimal"][j]))),
        )
        for j, name in enumerate(run.data["joint"].values)
    )
    return Motion(
        number=index + 1,
        about=f"{of.shape}, {of.cycles} cycles of {seconds(of.period)}"
        + (f", payload {of.payload:g} kg" if of.payload else ""),
        cycles=segment["cycles"],
        of=of.cycles,
        reduction=Beside(
            percent(segment["torque_reduction"]), percent(segment["torque_reduction_optimal"])
        ),
        torque=Beside(
            plain(segment["torque_squared"], 2), plain(segment["torque_squared_optimal"], 2)
        ),
        without=plain(segment["torque_squared_without_springs"], 2),
        tracking=length(segment["tracking_rms"]),
        rotation=angle(segment["rotation_rms"]) if "rotation_rms" in segment else None,
        reached=_reached(segment),
        joints=joints,
    )


def _reached(segment: dict[str, Any]) -> Number:
    """First cycle at the optimum; a motion without a whole cycle cannot tell."""
    cycle = segment["cycles_to_optimum"]
    if cycle is None:
        return Number(None, "never" if segment["cycles"] else "–")
    return Number(cycle, str(cycle))


def _equilibrium(run: Run, index: int, j: int) -> Number:
    """Where a joint's spring is at rest at the end of a motion; a joint without one has none."""
    data = run.data
    cycles = data["cycle"].values[data["segment_of_cycle"].values == index + 1]
    samples = data["cycle_of_sample"].values
    if not cycles.size or cycles[-1] not in samples:
        return plain(None)
    k = float(data["stiffness_per_cycle"].values[cycles[-1] - 1, j])
    offset = float(data["offset_per_cycle"].values[cycles[-1] - 1, j])
    if k == 0.0:
        return plain(None)
    center = float(data["center"].values[samples == cycles[-1]][-1, j])
    return plain(springs.equilibrium(k, offset, center)[1])


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
