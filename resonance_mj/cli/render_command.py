"""`resonance-mj render`: film a saved run, or several side by side and in step."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import PictureError
from . import render_options
from .console import DONE, bar, console

HELP = "film a saved run, or several side by side and in step"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    parser.add_argument(
        "runs", metavar="RUN", type=Path, nargs="+", help="a run's folder; several: side by side"
    )
    add = parser.add_argument
    add("-o", "--output", metavar="FILE", type=Path, help=".mp4, .webp or .gif; RUN/motion.mp4")
    render_options.add_span(parser)
    add("--speed", type=float, default=1.0, help="seconds of the run per second of video; 1")
    add("--fps", type=float, default=30.0, help="frames per second; 30")
    add("--size", metavar="WxH", default="1280x720", help="of the picture [pixels]; 1280x720")
    render_options.add_options(parser, "sky, white, dark or transparent")
    add("--label", dest="labels", action="append", help="what the picture calls a run; one each")
    add("--workers", metavar="N", type=int, help="processes that draw; one per core")


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from ..pictures.film import video
    from ..results.run import Run

    chosen = render_options.chosen(options, size=_size(options.size))
    runs = [Run.load(folder) for folder in options.runs]
    labels = options.labels
    if labels is None and len({run.experiment.name for run in runs}) < len(runs):
        labels = [folder.resolve().name for folder in options.runs]
    path = options.output or options.runs[0] / "motion.mp4"
    screen = console()
    with bar(path.name, "frames", screen) as show:
        written = video.render(
            runs,
            path,
            options.start,
            options.stop,
            options.fps,
            speed=options.speed,
            options=chosen,
            labels=labels,
            workers=options.workers,
            progress=show,
            note=lambda line: screen.print(f"  {line}", soft_wrap=True),
        )
    screen.print(str(written), soft_wrap=True)
    return DONE


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise PictureError(f"size {text!r}: give width and height in pixels, as in 1280x720")
    return int(width), int(height)
