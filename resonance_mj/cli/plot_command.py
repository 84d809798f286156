"""`resonance-mj plot`: draw the figures of a saved run, or several runs in one figure."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..pictures.figures.catalogue import FIGURES
from ..pictures.figures.sizes import DPI, FORMATS
from .console import DONE

HELP = "draw the figures of a saved run, or several runs in one figure"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    parser.add_argument(
        "runs",
        metavar="RUN",
        type=Path,
        nargs="+",
        help="a run's folder, such as runs/paper; several: compared in one figure",
    )
    add = parser.add_argument
    add(
        "--figure",
        dest="figures",
        metavar="NAME",
        action="append",
        help=f"{', '.join(entry.name for entry in FIGURES)}; again or with commas for several; "
        "all that the runs have samples for",
    )
    add("--format", metavar="KIND", default=",".join(FORMATS), help="any of svg,png,pdf; svg,png")
    add("--width", metavar="WIDTH", default="page", help="column, page, or inches; page: 7.16")
    add("--dpi", metavar="N", type=float, default=DPI, help=f"pixels per inch of a PNG; {DPI:g}")
    add("--out", metavar="FOLDER", type=Path, help="where to write; the first run's folder")


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from ..pictures.figures.plot import plot
    from ..results.run import Run

    names = [name for given in options.figures or [] for name in given.split(",")]
    written = plot(
        [Run.load(folder) for folder in options.runs],
        options.out or options.runs[0],
        figures=names or None,
        formats=options.format.split(","),
        width=options.width,
        dpi=options.dpi,
    )
    for path in written:
        print(path)
    return DONE
