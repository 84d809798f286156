"""The command line: the only place that prints or exits."""

from __future__ import annotations

import argparse
import os
import sys
import threading
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from . import render_command
from .errors import ExperimentError, OutputError, ResonanceError

if TYPE_CHECKING:
    from rich.console import Console

    from .check import Judgement
    from .experiment import Experiment
    from .run import Run

DONE, NOT_WELL, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Returns:
        The exit status: 0 done, 1 the run did not end well, 2 bad input.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        changes, rest = _split(arguments)
        options = _parser().parse_args(rest)
        options.changes = changes
        if changes and options.command not in (_run, _optimum, _compare, _check):
            key = next(iter(changes))
            raise ExperimentError(f"--{key}: this command takes no keys of an experiment")
        return int(options.command(options))
    except ResonanceError as error:
        print(f"resonance-mj: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("resonance-mj: interrupted; nothing was written", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        raise ExperimentError(f"{message}; see {self.prog} --help")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="resonance-mj",
        description="Tune a robot's joint springs to its motion, in MuJoCo.",
        allow_abbrev=False,
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    run = _command(commands, "run", _run, "simulate an experiment and write its run")
    _what(run)
    run.add_argument("--out", metavar="FOLDER", type=Path, help="where to write; runs/NAME")
    run.add_argument(
        "--interpret", action="store_true", help="run the law as plain Python, for a debugger"
    )
    run.add_argument(
        "--certify", action="store_true", help="check on the run what the stability proof claims"
    )
    run.add_argument(
        "--strict", action="store_true", help="refuse what will diverge, instead of a warning"
    )
    run.epilog = _KEYS

    optimum = _command(commands, "optimum", _optimum, "the best constant springs of an experiment")
    _what(optimum)
    optimum.epilog = _KEYS

    inspect = _command(
        commands, "inspect", _inspect, "what is found in an arm, and a motion and gains for it"
    )
    inspect.add_argument("robot", metavar="MJCF", help="a path, a built-in name or menagerie:NAME")
    inspect.add_argument("--tool", metavar="NAME", help="the site or body that follows the motion")
    inspect.add_argument(
        "--home", metavar="KEY|ANGLES", help="a keyframe, or joint angles as in --home=0.5,-1 [rad]"
    )
    inspect.add_argument(
        "--toml", action="store_true", help="print an experiment file for it and nothing else"
    )

    compare = _command(
        commands, "compare", _compare, "the laws that users compare, on one experiment"
    )
    _what(compare)
    compare.add_argument(
        "--long",
        metavar="CYCLES",
        type=int,
        default=1000,
        help="how often the last motion is repeated to see which law lasts; 1000, and 0 for not",
    )
    compare.add_argument(
        "--out", metavar="FOLDER", type=Path, help="where to write; runs/NAME-compare"
    )
    compare.epilog = _KEYS

    plot = _command(commands, "plot", _plot, "draw the figure of a run again")
    plot.add_argument("run", metavar="RUN", type=Path, help="a run's folder, such as runs/paper")
    plot.add_argument("--out", metavar="FOLDER", type=Path, help="where to write; the run's folder")

    certify = _command(
        commands, "certify", _certify, "check on a saved run what the stability proof claims"
    )
    certify.add_argument("run", metavar="RUN", type=Path, help="a run's folder, such as runs/paper")
    certify.add_argument(
        "--out", metavar="FOLDER", type=Path, help="where to draw; the run's folder"
    )

    check = _command(commands, "check", _check, "hold runs against what their experiments expect")
    check.add_argument(
        "runs",
        metavar="RUN",
        nargs="*",
        help="TOML files with [expect], folders of such, or built-in names; all in the working "
        "folder and its folder runs, or else the built-in ones",
    )
    check.add_argument("--junit", metavar="FILE", type=Path, help="write the verdicts as XML")
    check.add_argument(
        "--update",
        action="store_true",
        help="rewrite the numbers expected in the files with those found",
    )
    check.epilog = _KEYS

    render = _command(
        commands, "render", _render, "film a saved run, or several side by side and in step"
    )
    render_command.add_options(render)

    _command(commands, "list", _list, "the experiments and robots that come with the program")
    _command(commands, "keys", _keys, "every key of an experiment, with unit and default")

    _command(commands, "version", _version, "versions of this program and what it uses")
    return parser


_KEYS = (
    "Every key of the experiment is an option, with its value as in the file: --law.beta 3, "
    "--law.k_v 200,300, --springs.stiffness=-inf,inf, --motion.0.period 0.5. "
    "`resonance-mj keys` lists them."
)


def _what(parser: argparse.ArgumentParser) -> None:
    """What to simulate: an experiment, or a robot with everything else found."""
    parser.add_argument(
        "experiment", metavar="NAME|PATH", nargs="?", help="a built-in name, or a TOML file"
    )
    parser.add_argument(
        "--robot", metavar="MJCF", help="an arm, in place of the experiment's or with none given"
    )


def _command(commands: Any, name: str, function: Callable[..., int], help_: str) -> _Parser:
    parser = commands.add_parser(
        name, help=help_, description=help_[0].upper() + help_[1:] + ".", allow_abbrev=False
    )
    parser.set_defaults(command=function)
    return parser


def _split(arguments: list[str]) -> tuple[dict[str, Any], list[str]]:
    """Take the options with a dot, `--law.beta 3` or `--law.beta=3`, out of the arguments."""
    changes: dict[str, Any] = {}
    rest: list[str] = []
    tokens = iter(arguments)
    for token in tokens:
        key, equals, text = token.removeprefix("--").partition("=")
        if not token.startswith("--") or "." not in key:
            rest.append(token)
            continue
        if not equals:
            following = next(tokens, None)
            if following is None or following.startswith("--"):
                raise ExperimentError(f"--{key}: a value must follow, as in --{key}=VALUE")
            text = following
        changes[key] = _value(text)
    return changes, rest


def _value(text: str) -> Any:
    """A value as a TOML file would have it; `1,2` is a list, and what is no TOML is a string."""
    for literal in (text, f"[{text}]") if "," in text else (text,):
        try:
            return tomllib.loads(f"value = {literal}")["value"]
        except tomllib.TOMLDecodeError:
            continue
    return text.split(",") if "," in text else text


def _experiment(options: argparse.Namespace) -> Experiment:
    from .experiment import for_robot, load

    if options.experiment is None and options.robot is None:
        raise ExperimentError(
            "give the NAME or PATH of an experiment, or --robot MJCF; `resonance-mj list` has names"
        )
    if options.experiment is None:
        return for_robot(options.robot).replace(options.changes)
    changes = dict(options.changes)
    if options.robot is not None:
        changes["robot.mjcf"] = options.robot
    return load(options.experiment).replace(changes)


def _run(options: argparse.Namespace) -> int:
    experiment = _experiment(options)
    from . import tables
    from .files import could_be_written
    from .run import Status

    folder = could_be_written(options.out or Path("runs") / experiment.name)
    console = _console()
    run = _simulate(experiment, options, console)
    run.save(folder)
    written = ["run.nc", "summary.json", "experiment.toml"]
    if run.data.sizes["time"]:
        from . import figures

        written += [path.name for path in figures.save(figures.figure(run), folder)]
    console.print(tables.summary(run))
    if options.certify:
        written += _certified(run, folder, console)
    if run.data.attrs["thinned"]:
        kept = len(set(run.data["cycle_of_sample"].values.tolist()))
        console.print(
            f"Samples of {kept} of {run.data.sizes['cycle']} cycles were kept "
            f"(simulation.samples = {experiment.simulation.samples})."
        )
    console.print(f"{folder}: {', '.join(written)}", soft_wrap=True)
    if run.status is Status.OK:
        return DONE
    print(f"resonance-mj: {experiment.name}: {run.status}: {run.message}", file=sys.stderr)
    return NOT_WELL


def _simulate(experiment: Experiment, options: argparse.Namespace, console: Console) -> Run:
    """Simulate behind a progress bar."""
    from . import simulation

    total = sum(motion.cycles for motion in experiment.motion)
    drawing = threading.Thread(target=import_module, args=("resonance_mj.figures",), daemon=True)
    with _bar(experiment.name, total, console) as show:

        def shown(done: int, of: int) -> None:
            if done == 1:
                # Imported while MuJoCo steps, which leaves Python's lock to others.
                drawing.start()
            show(done, of)

        return simulation.simulate(
            experiment,
            interpret=options.interpret,
            strict=options.strict,
            progress=shown,
            note=lambda line: console.print(f"  {line}", soft_wrap=True),
        )


@contextmanager
def _bar(name: str, total: int | None, console: Console) -> Iterator[Callable[[int, int], None]]:
    """A progress bar, as a function of the cycles done and the cycles in all."""
    from rich import progress

    bars = progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TextColumn("cycles"),
        progress.TimeElapsedColumn(),
        progress.TextColumn("left"),
        progress.TimeRemainingColumn(),
        console=console,
    )
    with bars:
        bar = bars.add_task(f"{name}: preparing the law", total=total)

        def show(done: int, of: int) -> None:
            bars.update(bar, completed=done, total=of, description=name)

        yield show


def _compare(options: argparse.Namespace) -> int:
    experiment = _experiment(options)
    from . import comparison, comparison_figure, figures, tables
    from .files import could_be_written

    folder = could_be_written(options.out or Path("runs") / f"{experiment.name}-compare")
    console = _console()
    with _bar(f"{experiment.name}: all laws", None, console) as show:
        found = comparison.compare(experiment, long=options.long, progress=show)
    found.save(folder)
    figures.save(comparison_figure.figure(found), folder, "compare")
    console.print(tables.comparison(found))
    console.print(
        f"{folder}: compare.svg, compare.png, compare.json, compare.csv, and a run in each of "
        f"{', '.join(found.runs)}",
        soft_wrap=True,
    )
    return DONE


def _check(options: argparse.Namespace) -> int:
    if options.update and options.changes:
        raise ExperimentError(
            f"--{next(iter(options.changes))}: --update writes what the files' own runs show; "
            "leave one of the two out"
        )
    from . import cases

    if options.junit is not None:
        from .files import could_be_written

        could_be_written(options.junit.parent)
        if options.junit.is_dir():
            raise OutputError(f"{options.junit}: is a folder; give --junit the name of a file")
    files = cases.named(options.runs)
    experiments = [cases.read(path, options.changes) for path in files]
    from . import convergence, tables
    from .check import judge
    from .simulation import simulate_many

    console = _console()
    with _bar("experiments", None, console) as show:
        runs = simulate_many(experiments, progress=show)
    judgements = [judge(run) for run in runs]
    for run, found in zip(runs, judgements, strict=True):
        console.print(tables.judgements(run, found))
    if options.junit is not None:
        from . import junit

        junit.write(options.junit, runs, judgements)
    if options.update:
        return _update(files, runs, judgements)
    for run, found in zip(runs, judgements, strict=True):
        if text := convergence.report(run, found):
            console.print(text, soft_wrap=True)
    missed = sum(not one.passed for found in judgements for one in found)
    total = sum(map(len, judgements))
    console.print(f"{missed or 'none'} of {total} expectations missed in {len(runs)} run(s)")
    return NOT_WELL if missed else DONE


def _update(files: list[Path], runs: list[Run], judgements: list[list[Judgement]]) -> int:
    """Write what was found into the files, and hold the runs against them again."""
    from dataclasses import replace

    from . import cases, updating
    from .check import judge
    from .run import Status

    for path, run in zip(files, runs, strict=True):
        if run.status is not Status.OK:
            print(
                f"resonance-mj: {path}: the run ended as {run.status}, and no file is updated: "
                f"{run.message}",
                file=sys.stderr,
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
        print(f"resonance-mj: {key}: missed, and not a number to update", file=sys.stderr)
    return NOT_WELL if missed else DONE


def _optimum(options: argparse.Namespace) -> int:
    experiment = _experiment(options)
    from . import robot, tables
    from .optimal_springs import along, follow, resolved

    arm = robot.build(experiment)
    experiment = resolved(experiment, arm)
    best = along(experiment, arm, follow(experiment, arm))
    _console().print(tables.optimum(experiment, arm, best))
    return DONE


def _inspect(options: argparse.Namespace) -> int:
    from . import tables
    from .experiment import for_robot
    from .inspection import inspect

    changes: dict[str, Any] = {}
    if options.tool is not None:
        changes["robot.tool"] = options.tool
    if options.home is not None:
        home = _value(options.home)
        changes["robot.home"] = [home] if isinstance(home, int | float) else home
    found = inspect(for_robot(options.robot).replace(changes))
    if options.toml:
        print(found.to_toml(), end="")
        return DONE
    console = _console()
    for kind, slides in (("hinge", False), ("slide", True)):
        joints = [joint for joint in found.joints if joint.slides == slides]
        if joints:
            console.print(tables.joints(f"{found.experiment.name}: {kind} joints", joints))
            console.print(tables.effort(f"{kind} joints along the suggested motion", joints))
    console.print(tables.tools(found))
    console.print(tables.suggestion(found))
    for note in found.notes:
        console.print(f"  {note}", soft_wrap=True)
    return DONE


def _plot(options: argparse.Namespace) -> int:
    from . import figures
    from .files import writable
    from .run import Run

    run = Run.load(options.run)
    for path in figures.save(figures.figure(run), writable(options.out or options.run)):
        print(path)
    return DONE


def _certify(options: argparse.Namespace) -> int:
    from .files import writable
    from .run import Run

    run, console = Run.load(options.run), _console()
    folder = writable(options.out or options.run)
    for name in _certified(run, folder, console):
        console.print(folder / name, soft_wrap=True)
    return DONE


def _certified(run: Run, folder: Path, console: Console) -> list[str]:
    """Print and draw a run's certificates; the names of the files that were written."""
    from . import certificate_figure, figures, tables
    from .certificates import certify

    found = certify(run)
    drawn = figures.save(certificate_figure.figure(found), folder, "certificates")
    console.print(tables.certificates(found))
    return [path.name for path in drawn]


def _render(options: argparse.Namespace) -> int:
    console = _console()
    console.print(str(render_command.render(options, console)), soft_wrap=True)
    return DONE


def _list(options: argparse.Namespace) -> int:
    from rich.table import Table

    from . import library

    console = _console()
    for title, files in (("runs", library.experiments()), ("robots", library.robots())):
        table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
        table.add_column("name", no_wrap=True)
        table.add_column("what it is")
        for name, path in files.items():
            table.add_row(name, library.line(path))
        console.print(table)
        console.print()
    console.print(f"robots are in {library.folder('mjcf')}, runs in {library.folder('runs')}")
    return DONE


def _keys(options: argparse.Namespace) -> int:
    from rich.table import Table

    from .experiment import describe

    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("key", "default", "meaning"):
        table.add_column(heading)
    for key, default, meaning in describe():
        table.add_row(key, default, meaning)
    _console().print(table)
    return DONE


def _version(options: argparse.Namespace) -> int:
    from .run import versions

    for name, number in versions().items():
        print(f"{name} {number}")
    return DONE


def _console() -> Console:
    from rich.console import Console

    return Console(markup=False, highlight=False)


if __name__ == "__main__":
    sys.exit(main())
