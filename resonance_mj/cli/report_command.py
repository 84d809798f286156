"""`resonance-mj report`: a saved run, or several beside each other, as one HTML file."""

from __future__ import annotations

import argparse
from pathlib import Path

from .console import DONE, bar, console

HELP = "write a run, or several beside each other, as one page to read and to send"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    parser.add_argument(
        "runs", metavar="RUN", type=Path, nargs="+", help="a run's folder; several: compared"
    )
    add = parser.add_argument
    add(
        "-o",
        "--output",
        metavar="FILE",
        type=Path,
        help="RUN/report.html; of several, comparison.html in the first one's folder",
    )
    add("--title", help="of the page; the names of the runs")
    add("--label", dest="labels", action="append", help="what the page calls a run; one each")
    add("--no-video", action="store_true", help="leave out the video, which takes most of the time")


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from ..pictures.page.report import report

    screen = console()
    with bar("report", "pictures", screen) as show:
        written = report(
            options.runs,
            options.output,
            video=not options.no_video,
            title=options.title,
            labels=options.labels,
            progress=show,
            note=lambda line: screen.print(f"  {line}", soft_wrap=True),
        )
    screen.print(f"{written}: {written.stat().st_size / 1e6:.1f} MB", soft_wrap=True)
    return DONE
