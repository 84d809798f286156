"""The commands that take an experiment or a robot: run, optimum, inspect, compare and check."""

from __future__ import annotations

import warnings
from argparse import Namespace
from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import resonance_mj as rmj

from ..claim import claimed
from ..errors import DivergedWarning, ExperimentError
from ..files import could_be_written
from ..pictures.figures.catalogue import DRAFT
from ..progress import bar
from . import keys_as_options, run_commands
from .command import (
    DONE,
    ENDED_BY_SIGNAL,
    NOT_WELL,
    Screen,
    argument,
    command,
    complain,
    flag,
    stopping,
)
from .keys_as_options import EXPERIMENT, ROBOT

if TYPE_CHECKING:
    from rich.console import Group
    from rich.table import Table

    from ..evaluation.checks.check import Judgement


@command(
    EXPERIMENT,
    ROBOT,
    argument("--out", "where to write; runs/NAME", metavar="FOLDER", type=Path),
    argument("--after", "a run's folder to go on from", metavar="RUN", type=Path),
    argument(
        "--checkpoint", "save the run so far every so many cycles", metavar="N", type=int, default=0
    ),
    flag("--resume", "go on with the run in --out that was interrupted or killed"),
    flag("--interpret", "run the law as plain Python, for a debugger"),
    flag("--certify", "check on the run what the stability proof claims"),
    flag("--strict", "refuse what will diverge, instead of a warning"),
    keys=True,
    figures=True,
)
def run(options: Namespace) -> int:
    """Simulate an experiment and write its run."""
    experiment = keys_as_options.experiment(options)
    folder = could_be_written(options.out or Path("runs") / experiment.name)
    # While it is saved now and then, `simulate` has the folder for itself.
    with nullcontext() if options.checkpoint else claimed(folder):
        return _made(experiment, folder, options)


def _made(experiment: rmj.Experiment, folder: Path, options: Namespace) -> int:
    """Simulate and write into a folder as options ask for; returns the exit status."""
    from . import tables

    screen = Screen(options)
    name, total = experiment.name, sum(motion.cycles for motion in experiment.motion)
    with (
        stopping() as came,
        bar(f"{name}: preparing the law", "cycles", screen.console, total, then=name) as show,
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore", DivergedWarning)  # said at the end
        run = rmj.simulate(
            experiment,
            interpret=options.interpret,
            strict=options.strict,
            after=options.after and rmj.Run.load(options.after),
            progress=show,
            note=screen.note,
            stop=lambda: bool(came),
            checkpoint=options.checkpoint,
            folder=folder,
            resume=_begun(folder) if options.resume else None,
        )
    run.save(folder)
    written = ["run.nc", "summary.json", "experiment.toml"]
    figures = run.summary()
    shown: list[Group | Table] = [tables.summary(run)]
    if run.data.sizes["time"]:
        written += [path.name for path in rmj.plot(run, folder, figures=["overview"], dpi=DRAFT)]
    if options.certify:
        found, names = run_commands.certified(run, folder)
        figures["certificates"] = run_commands.certificates(found)
        shown.append(tables.certificates(found))
        written += names
    screen.table(figures, *shown)
    if run.data.attrs["thinned"]:
        kept = len(set(run.data["cycle_of_sample"].values.tolist()))
        screen.line(
            f"Samples of {kept} of {run.data.sizes['cycle']} cycles were kept "
            f"(simulation.samples = {experiment.simulation.samples})."
        )
    screen.line(f"{folder}: {', '.join(written)}")
    if run.status is rmj.Status.OK:
        return DONE
    complain(f"{name}: {run.status}: {run.message}")
    return ENDED_BY_SIGNAL + came[0] if run.status is rmj.Status.INTERRUPTED else NOT_WELL


def _begun(folder: Path) -> rmj.Run | None:
    """The run in a folder that is to be resumed; None where it was killed before a checkpoint."""
    return rmj.Run.load(folder) if (folder / "run.nc").exists() else None


@command(EXPERIMENT, ROBOT, keys=True, figures=True)
def optimum(options: Namespace) -> None:
    """The best constant springs of an experiment."""
    experiment = keys_as_options.experiment(options)
    from ..plan.plan import plan_for
    from . import tables

    plan = plan_for(experiment)
    figures = ("stiffness", "offset", "equilibrium", "center", "cost", "cost_without_springs")
    motions = [
        {name: getattr(best, name) for name in (*figures, "reduction", "torque_reduction")}
        for best in plan.optima
    ]
    found = {"name": experiment.name, "joints": plan.robot.joints, "motions": motions}
    Screen(options).table(found, tables.optimum(plan))


@command(
    argument("robot", "a path, a built-in name or menagerie:NAME", metavar="MJCF"),
    argument("--tool", "the site or body that follows the motion", metavar="NAME"),
    argument(
        "--home", "a keyframe, or joint angles as in --home=0.5,-1 [rad]", metavar="KEY|ANGLES"
    ),
    flag("--toml", "print an experiment file for it and nothing else"),
    argument("-o --output", "draw it: .png, .jpg or .webp", metavar="FILE", type=Path),
    figures=True,
)
def inspect(options: Namespace) -> None:
    """What is found in an arm, and a motion and gains for it."""
    from ..evaluation.inspection import inspect
    from ..experiments.loading import for_robot
    from ..plan.plan import plan_for
    from . import arm_tables

    changes: dict[str, Any] = {}
    if options.tool is not None:
        changes["robot.tool"] = options.tool
    if options.home is not None:
        home = keys_as_options.value(options.home)
        changes["robot.home"] = [home] if isinstance(home, int | float) else home
    plan = plan_for(for_robot(options.robot).replace(changes))
    found = inspect(plan)
    if options.toml:
        print(found.to_toml(), end="")
        return
    screen, printed = Screen(options), []
    for kind, slides in (("hinge", False), ("slide", True)):
        joints = [joint for joint in found.joints if joint.slides == slides]
        if joints:
            printed += [
                arm_tables.joints(f"{found.experiment.name}: {kind} joints", joints),
                arm_tables.effort(f"{kind} joints along the suggested motion", joints),
            ]
    data = asdict(found) | {"experiment": found.experiment.model_dump()}
    screen.table(data, *printed, arm_tables.tools(found), arm_tables.suggestion(found))
    for note in found.notes:
        screen.note(note)
    if options.output:
        from ..pictures.film.arm_picture import draw_arm

        screen.line(draw_arm(plan, options.output, note=screen.note))


@command(
    argument(
        "runs",
        "TOML files with [expect], folders of such, or built-in names; all in the working "
        "folder and its folder runs, or else the built-in ones",
        metavar="RUN",
        nargs="*",
    ),
    flag("--update", "rewrite the numbers expected in the files with those found"),
    keys=True,
    figures=True,
)
def check(options: Namespace) -> int:
    """Hold runs against what their experiments expect."""
    if options.update and options.changes:
        raise ExperimentError(
            f"--{next(iter(options.changes))}: --update writes what the files' own runs show; "
            "leave one of the two out"
        )
    from ..evaluation.checks import cases

    files = cases.named(options.runs)
    experiments = [cases.read(path, options.changes) for path in files]
    from ..evaluation.checks import convergence
    from ..evaluation.checks.check import judge
    from ..laws import laws
    from . import tables

    screen = Screen(options)
    for kind in dict.fromkeys(experiment.law.kind for experiment in experiments):
        for line in laws.load(kind).said:
            screen.note(line)
    with bar("experiments", "cycles", screen.console) as show:
        runs = rmj.simulate_many(experiments, progress=show)
    judgements = [judge(run) for run in runs]
    data = [
        {"run": run.experiment.name, **_judged(one)}
        for run, found in zip(runs, judgements, strict=True)
        for one in found
    ]
    screen.table(data, *map(tables.judgements, runs, judgements))
    if options.update:
        return _update(files, runs, judgements)
    for run, found in zip(runs, judgements, strict=True):
        if text := convergence.report(run, found):
            screen.line(text)
    missed = sum(not one.passed for found in judgements for one in found)
    total = sum(map(len, judgements))
    screen.line(f"{missed or 'none'} of {total} expectations missed in {len(runs)} run(s)")
    return NOT_WELL if missed else DONE


def _judged(one: Judgement) -> dict[str, Any]:
    """A judgement as data."""
    figures = ("key", "motion", "figure", "joint", "unit", "found", "passed")
    band = {"expected": one.band.expected, "low": one.band.low, "high": one.band.high}
    return {name: getattr(one, name) for name in figures} | band


def _update(files: list[Path], runs: list[rmj.Run], judgements: list[list[Judgement]]) -> int:
    """Write what was found into the files, and hold the runs against them again."""
    from dataclasses import replace

    from ..evaluation.checks import cases, updating
    from ..evaluation.checks.check import judge

    for path, run in zip(files, runs, strict=True):
        if run.status is not rmj.Status.OK:
            complain(
                f"{path}: the run ended as {run.status}, and no file is updated: {run.message}"
            )
            return NOT_WELL
    # All are made before any is written.
    updates = [updating.Update(*each) for each in zip(files, runs, judgements, strict=True)]
    missed = []
    for update, run in zip(updates, runs, strict=True):
        update.write()
        print("\n".join(update.differences()) or f"{update.path}: nothing to update")
        again = judge(replace(run, experiment=cases.read(update.path)))
        missed += [f"{update.path}: {one.key}" for one in again if not one.passed]
    for key in missed:
        complain(f"{key}: missed, and not a number to update")
    return NOT_WELL if missed else DONE
