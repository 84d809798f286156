"""`resonance-mj plot`: draw the figure of a saved run again."""

from __future__ import annotations

import argparse
from pathlib import Path

from .console import DONE

HELP = "draw the figure of a run again"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    parser.add_argument("run", metavar="RUN", type=Path, help="a run's folder, such as runs/paper")
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, help="where to write; the run's folder"
    )


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from ..figures import figures
    from ..files import writable
    from ..results.run import Run

    run = Run.load(options.run)
    for path in figures.save(figures.figure(run), writable(options.out or options.run)):
        print(path)
    return DONE
