"""`resonance-mj compare`: the laws that users compare, on one experiment."""

from __future__ import annotations

import argparse
from pathlib import Path

from . import keys_as_options
from .console import DONE, bar, console

HELP = "the laws that users compare, on one experiment"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    keys_as_options.add_options(parser)
    parser.add_argument(
        "--long",
        metavar="CYCLES",
        type=int,
        default=1000,
        help="how often the last motion is repeated to see which law lasts; 1000, and 0 for not",
    )
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, help="where to write; runs/NAME-compare"
    )


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    experiment = keys_as_options.experiment(options)
    from ..evaluation import comparison
    from ..files import could_be_written
    from ..pictures.figures import comparison_figure, saving
    from . import tables

    folder = could_be_written(options.out or Path("runs") / f"{experiment.name}-compare")
    screen = console()
    with bar(f"{experiment.name}: all laws", "cycles", screen) as show:
        found = comparison.compare(experiment, long=options.long, progress=show)
    found.save(folder)
    saving.save(comparison_figure.figure(found), folder, "compare")
    screen.print(tables.comparison(found))
    screen.print(
        f"{folder}: compare.svg, compare.png, compare.json, compare.csv, and a run in each of "
        f"{', '.join(found.runs)}",
        soft_wrap=True,
    )
    return DONE
