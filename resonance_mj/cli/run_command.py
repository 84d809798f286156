"""`resonance-mj run`: simulate an experiment, and write, draw and print its run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from . import certify_command, keys_as_options
from .console import DONE, NOT_WELL, bar, console

if TYPE_CHECKING:
    from rich.console import Console

    from ..experiments.experiment import Experiment
    from ..results.run import Run

HELP = "simulate an experiment and write its run"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    keys_as_options.add_options(parser)
    add = parser.add_argument
    add("--out", metavar="FOLDER", type=Path, help="where to write; runs/NAME")
    add("--interpret", action="store_true", help="run the law as plain Python, for a debugger")
    add("--certify", action="store_true", help="check on the run what the stability proof claims")
    add("--strict", action="store_true", help="refuse what will diverge, instead of a warning")


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    experiment = keys_as_options.experiment(options)
    from ..files import could_be_written
    from ..pictures.figures.plot import plot
    from ..pictures.figures.sizes import DRAFT

    folder = could_be_written(options.out or Path("runs") / experiment.name)
    screen = console()
    run = _simulate(experiment, options, screen)
    run.save(folder)
    written = ["run.nc", "summary.json", "experiment.toml"]
    from . import tables

    screen.print(tables.summary(run))
    if run.data.sizes["time"]:
        written += [path.name for path in plot(run, folder, figures=["overview"], dpi=DRAFT)]
    if options.certify:
        written += certify_command.certified(run, folder, screen)
    if run.data.attrs["thinned"]:
        kept = len(set(run.data["cycle_of_sample"].values.tolist()))
        screen.print(
            f"Samples of {kept} of {run.data.sizes['cycle']} cycles were kept "
            f"(simulation.samples = {experiment.simulation.samples})."
        )
    screen.print(f"{folder}: {', '.join(written)}", soft_wrap=True)
    from ..status import Status

    if run.status is Status.OK:
        return DONE
    print(f"resonance-mj: {experiment.name}: {run.status}: {run.message}", file=sys.stderr)
    return NOT_WELL


def _simulate(experiment: Experiment, options: argparse.Namespace, console: Console) -> Run:
    """Simulate behind a progress bar."""
    from ..simulation import simulation

    name, total = experiment.name, sum(motion.cycles for motion in experiment.motion)
    with bar(f"{name}: preparing the law", "cycles", console, total, then=name) as show:
        return simulation.simulate(
            experiment,
            interpret=options.interpret,
            strict=options.strict,
            progress=show,
            note=lambda line: console.print(f"  {line}", soft_wrap=True),
        )
