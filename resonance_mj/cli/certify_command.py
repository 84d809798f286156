"""`resonance-mj certify`: what the stability proof claims, checked on a saved run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .console import DONE, console

if TYPE_CHECKING:
    from rich.console import Console

    from ..results.run import Run

HELP = "check on a saved run what the stability proof claims"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    parser.add_argument("run", metavar="RUN", type=Path, help="a run's folder, such as runs/paper")
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, help="where to draw; the run's folder"
    )


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from ..files import writable
    from ..results.run import Run

    run, screen = Run.load(options.run), console()
    folder = writable(options.out or options.run)
    for name in certified(run, folder, screen):
        screen.print(folder / name, soft_wrap=True)
    return DONE


def certified(run: Run, folder: Path, console: Console) -> list[str]:
    """Print and draw a run's certificates; the names of the files that were written."""
    from ..evaluation.certificates.certificates import certify
    from ..pictures.figures import certificate_figure, saving
    from . import tables

    found = certify(run)
    drawn = saving.save(certificate_figure.figure(found), folder, "certificates")
    console.print(tables.certificates(found))
    return [path.name for path in drawn]
