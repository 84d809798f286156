"""`resonance-mj check`: runs held against what their experiments expect, or the files updated."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import ExperimentError
from . import keys_as_options
from .console import DONE, NOT_WELL, bar, console

if TYPE_CHECKING:
    from ..evaluation.checks.check import Judgement
    from ..results.run import Run

HELP = "hold runs against what their experiments expect"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    parser.add_argument(
        "runs",
        metavar="RUN",
        nargs="*",
        help="TOML files with [expect], folders of such, or built-in names; all in the working "
        "folder and its folder runs, or else the built-in ones",
    )
    parser.add_argument(
        "--update",
        action="store_true",
        help="rewrite the numbers expected in the files with those found",
    )
    keys_as_options.take_keys(parser)


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
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
    from ..simulation.simulation import simulate_many
    from . import tables

    screen = console()
    with bar("experiments", "cycles", screen) as show:
        runs = simulate_many(experiments, progress=show)
    judgements = [judge(run) for run in runs]
    for run, found in zip(runs, judgements, strict=True):
        screen.print(tables.judgements(run, found))
    if options.update:
        return _update(files, runs, judgements)
    for run, found in zip(runs, judgements, strict=True):
        if text := convergence.report(run, found):
            screen.print(text, soft_wrap=True)
    missed = sum(not one.passed for found in judgements for one in found)
    total = sum(map(len, judgements))
    screen.print(f"{missed or 'none'} of {total} expectations missed in {len(runs)} run(s)")
    return NOT_WELL if missed else DONE


def _update(files: list[Path], runs: list[Run], judgements: list[list[Judgement]]) -> int:
    """Write what was found into the files, and hold the runs against them again."""
    from dataclasses import replace

    from ..evaluation.checks import cases, updating
    from ..evaluation.checks.check import judge
    from ..results.run import Status

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
