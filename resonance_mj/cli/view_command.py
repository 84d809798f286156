"""`resonance-mj view`: a saved run again, or an experiment as it is simulated, in a window."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import ExperimentError
from ..pictures.viewer.clock import KEYS_HELP
from . import keys_as_options, render_options
from .console import DONE, NOT_WELL, console

if TYPE_CHECKING:
    from ..experiments.experiment import Experiment
    from ..results.run import Run

HELP = "watch a saved run again, or an experiment live, in MuJoCo's viewer"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    keys_as_options.add_options(
        parser,
        "RUN|NAME|PATH",
        "a run's folder, which is replayed; or a built-in name or a TOML file, which is simulated "
        "while you watch",
    )
    add = parser.add_argument
    add("--speed", type=float, default=1.0, help="seconds of the run per second; 1")
    render_options.add_span(parser)
    add("--once", action="store_true", help="close the window at the end; runs are repeated else")
    render_options.add_options(parser, "sky, white or dark", without=["plots"])
    parser.epilog = f"{KEYS_HELP}. {parser.epilog}"


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    # Windows are GLFW's, whatever pictures are drawn with; MuJoCo reads this when it is imported.
    os.environ["MUJOCO_GL"] = "glfw"
    what = _what(options)
    from ..pictures.viewer.view import view
    from ..status import Status

    screen = console()
    failed = []

    def ended(run: Run) -> None:
        if run.status is not Status.OK:
            failed.append(run)
            name = run.experiment.name
            print(f"resonance-mj: {name}: {run.status}: {run.message}", file=sys.stderr, flush=True)

    view(
        what,
        speed=options.speed,
        start=options.start,
        stop=options.stop,
        once=options.once,
        options=render_options.chosen(options),
        note=lambda line: screen.print(f"  {line}", soft_wrap=True),
        ended=ended,
    )
    return NOT_WELL if failed else DONE


def _what(options: argparse.Namespace) -> Run | Experiment:
    """The run, or else the experiment, that the options ask for."""
    from ..results.run import Run

    if not _is_run(options.experiment):
        return keys_as_options.experiment(options)
    given = [f"--{key}" for key in options.changes] + ["--robot"] * (options.robot is not None)
    if given:
        raise ExperimentError(
            f"{options.experiment}: a run is shown as it was: leave out {', '.join(given)}, or "
            "give the name or path of its experiment, which is simulated anew"
        )
    return Run.load(options.experiment)


def _is_run(given: str | None) -> bool:
    """Whether a folder of a run is meant: one with a run in it is, whatever else has its name."""
    from .. import library

    path = Path(given or "")
    if given is None or given in library.experiments():
        return given is not None and (path / "run.nc").is_file()
    return path.is_dir() or (len(path.parts) > 1 and path.suffix != ".toml" and not path.is_file())
