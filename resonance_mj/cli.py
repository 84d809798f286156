"""The command line: the only place that prints or exits."""

from __future__ import annotations

import argparse
import math
import os
import sys
import threading
import tomllib
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from .errors import ExperimentError, ResonanceError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from .experiment import Experiment
    from .inspection import Inspection, Joint
    from .optimal_springs import Optimum
    from .robot import Robot
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
        if changes and options.command not in (_run, _optimum):
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

    plot = _command(commands, "plot", _plot, "draw the figure of a run again")
    plot.add_argument("run", metavar="RUN", type=Path, help="a run's folder, such as runs/paper")
    plot.add_argument("--out", metavar="FOLDER", type=Path, help="where to write; the run's folder")

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
    from .files import could_be_written
    from .run import Status

    folder = could_be_written(options.out or Path("runs") / experiment.name)
    console = _console()
    # Imported while MuJoCo steps, which leaves Python's lock to others.
    threading.Thread(target=import_module, args=("resonance_mj.figures",), daemon=True).start()
    run = _simulate(experiment, options.interpret, console)
    run.save(folder)
    written = ["run.nc", "summary.json", "experiment.toml"]
    if run.data.sizes["time"]:
        from . import figures

        written += [path.name for path in figures.save(figures.figure(run), folder)]
    console.print(_summary_table(run))
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


def _simulate(experiment: Experiment, interpret: bool, console: Console) -> Run:
    """Simulate behind a progress bar."""
    from rich import progress

    from . import simulation

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
        total = sum(motion.cycles for motion in experiment.motion)
        bar = bars.add_task(f"{experiment.name}: preparing the law", total=total)

        def show(done: int, _: int) -> None:
            bars.update(bar, completed=done, description=experiment.name)

        return simulation.simulate(
            experiment,
            interpret=interpret,
            progress=show,
            note=lambda line: console.print(f"  {line}", soft_wrap=True),
        )


def _optimum(options: argparse.Namespace) -> int:

    experiment = _experiment(options)
    from . import robot
    from .optimal_springs import along, follow, resolved

    arm = robot.build(experiment)
    experiment = resolved(experiment, arm)
    best = along(experiment, arm, follow(experiment, arm))
    _console().print(_optimum_table(experiment, arm, best))
    return DONE


def _inspect(options: argparse.Namespace) -> int:
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
            console.print(_joints_table(f"{found.experiment.name}: {kind} joints", joints))
            console.print(_effort_table(f"{kind} joints along the suggested motion", joints))
    console.print(_tools_table(found))
    console.print(_suggestion_table(found))
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


def _summary_table(run: Run) -> Table:
    """The figures of each motion's last whole cycle beside the optimum's."""
    segments = run.summary()["segments"]
    table = _table(f"{run.experiment.name}: last cycle of each motion", len(segments))

    def row(label: str, key: str, scale: float, digits: int, joint: int | None = None) -> None:
        cells = [label]
        for segment in segments:
            for name in (key, f"{key}_optimal"):
                value = segment.get(name)
                if isinstance(value, list) and joint is not None:
                    value = value[joint]
                cells.append(_number(value, scale, digits) if name in segment else "")
        table.add_row(*cells)

    row("torque reduction [%]", "torque_reduction", 100, 1)
    row("mean torque² [N² m²]", "torque_squared", 1, 2)
    row("  without springs", "torque_squared_without_springs", 1, 2)
    slides = run.data["slides"].values
    for joint, name in enumerate(run.data["joint"].values):
        unit = "N/m" if slides[joint] else "N m/rad"
        row(f"stiffness {name} [{unit}]", "stiffness", 1, 3, joint)
    for joint, name in enumerate(run.data["joint"].values):
        row(f"offset {name} [{'N' if slides[joint] else 'N m'}]", "offset", 1, 3, joint)
    row("tracking RMS [mm]", "tracking_rms", 1e3, 3)
    if "rotation_rms" in run.data:
        row("rotation RMS [mrad]", "rotation_rms", 1e3, 3)
    reached = [segment["cycles_to_optimum"] for segment in segments]
    cells = ((str(cycle or "never"), "") for cycle in reached)
    table.add_row("first cycle at the optimum", *(cell for pair in cells for cell in pair))
    return table


def _optimum_table(experiment: Experiment, arm: Robot, best: list[Optimum]) -> Table:
    from rich.table import Table

    table = Table(title=f"{experiment.name}: optimal springs", title_justify="left", box=None)
    table.add_column("")
    for index in range(len(best)):
        table.add_column(f"motion {index + 1}", justify="right")
    for j, joint in enumerate(arm.joints):
        k, force, angle = ("N/m", "N", "m") if arm.slides[j] else ("N m/rad", "N m", "rad")
        table.add_row(f"stiffness {joint} [{k}]", *(_number(b.stiffness[j], 1, 3) for b in best))
        table.add_row(f"offset {joint} [{force}]", *(_number(b.offset[j], 1, 3) for b in best))
        table.add_row(
            f"equilibrium {joint} [{angle}]", *(_number(b.equilibrium[j], 1, 3) for b in best)
        )
        table.add_row(f"center {joint} [{angle}]", *(_number(b.center[j], 1, 3) for b in best))
    table.add_row("cost J_min [N² m² s]", *(_number(b.cost, 1, 3) for b in best))
    table.add_row(
        "cost without springs [N² m² s]", *(_number(b.cost_without_springs, 1, 3) for b in best)
    )
    table.add_row("torque reduction [%]", *(_number(b.torque_reduction, 100, 1) for b in best))
    return table


def _joints_table(title: str, joints: list[Joint]) -> Table:
    """Joints as they are in the MJCF; all are hinges, or all are slides."""
    angle, torque, inertia = _units(joints)
    table = _table(title, 0)
    damping = f"{torque} s/{angle}"
    for heading in (
        f"home\n[{angle}]",
        f"range\n[{angle}]",
        f"damping\n[{damping}]",
        f"inertia\n[{inertia}]",
        f"motor limit\n[{torque}]",
    ):
        table.add_column(heading, justify="right")
    for joint in joints:
        table.add_row(
            joint.name,
            _number(joint.home, 1, 3),
            _interval(joint.range),
            _number(joint.damping, 1, 3),
            _number(joint.inertia, 1, 4),
            _interval(joint.torque_limit),
        )
    return table


def _effort_table(title: str, joints: list[Joint]) -> Table:
    """What a motion asks of joints, beside the limits of their motors."""
    angle, torque, _ = _units(joints)
    table = _table(title, 0)
    for heading in (
        f"peak speed\n[{angle}/s]",
        f"peak torque\nwithout springs [{torque}]",
        "of the limit\n[%]",
        f"with the best\nsprings [{torque}]",
    ):
        table.add_column(heading, justify="right")
    for joint in joints:
        limited = any(map(math.isfinite, joint.torque_limit))
        table.add_row(
            joint.name,
            _number(joint.peak_speed, 1, 3),
            _number(joint.peak_torque, 1, 3),
            _number(joint.share if limited else None, 100, 0),
            _number(joint.peak_torque_with_springs, 1, 3),
        )
    return table


def _tools_table(found: Inspection) -> Table:
    table = _table("what could be the tool", 0)
    for heading in ("kind", "on body", "chosen"):
        table.add_column(heading)
    for tool in found.tools:
        chosen = found.tool_reason if tool == found.tool else ""
        table.add_row(tool.name, tool.kind, tool.body, chosen)
    return table


def _suggestion_table(found: Inspection) -> Table:
    motion, law, gains = found.experiment.motion[0], found.experiment.law, found.gains
    least, most = found.conditioning.min(), found.conditioning.max()
    table = _table("suggested motion and gains", 0)
    table.add_column("")
    table.show_header = False
    for label, value in (
        ("reach, stretched out [m]", _number(found.reach, 1, 3)),
        ("task", ", ".join(found.axes)),
        ("motion", f"{motion.shape} in {', '.join(dict.fromkeys(motion.plane or ()))}"),
        ("  center [m]", _listed(motion.center)),
        ("  half sizes [m]", _listed(motion.size)),
        ("  period T [s]", f"{motion.period:g}"),
        ("  smallest / largest singular value of J", f"{least:.3f} to {most:.3f}"),
        ("  torque reduction with the best springs [%]", _number(found.torque_reduction, 100, 1)),
        ("feedback bandwidth omega [1/s]", f"{gains.omega:g}"),
        ("share eta that is learned in a cycle", f"{law.eta:g}"),
        ("lead [control periods]", str(gains.lead)),
        ("harmonics of 1/T that are learned", str(gains.harmonics or "all")),
    ):
        table.add_row(label, value)
    return table


def _units(joints: list[Joint]) -> tuple[str, str, str]:
    """Units of angle, torque and inertia of hinges, or of what they are for slides."""
    return ("m", "N", "kg") if joints[0].slides else ("rad", "N m", "kg m²")


def _interval(ends: tuple[float, float] | None) -> str:
    if ends is None or not any(map(math.isfinite, ends)):
        return "none"
    return f"{ends[0]:.4g} to {ends[1]:.4g}"


def _listed(values: Sequence[float] | None) -> str:
    return ", ".join(f"{value:.3f}" for value in values or ())


def _table(title: str, motions: int) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    for index in range(motions):
        table.add_column(f"motion {index + 1}", justify="right")
        table.add_column("optimum", justify="right", style="dim")
    return table


def _console() -> Console:
    from rich.console import Console

    return Console(markup=False, highlight=False)


def _number(value: float | None, scale: float, digits: int) -> str:
    return "-" if value is None else f"{value * scale:.{digits}f}"


if __name__ == "__main__":
    sys.exit(main())
