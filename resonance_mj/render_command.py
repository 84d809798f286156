"""The options of `resonance-mj render`, and a progress bar with the time left."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import PictureError

if TYPE_CHECKING:
    from rich.console import Console

PARTS = {
    "path": "the desired path",
    "trail": "the tool's recent trail",
    "springs": "springs and equilibria",
    "motors": "the motors' torque",
    "strip": "the plots below",
    "head-up": "the line above",
    "legend": "what the overlays mean",
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    parser.add_argument(
        "runs", metavar="RUN", type=Path, nargs="+", help="a run's folder; several: side by side"
    )
    add = parser.add_argument
    add("-o", "--output", metavar="FILE", type=Path, help=".mp4, .webp or .gif; RUN/motion.mp4")
    add("--from", dest="start", metavar="TIME", help="seconds, or a cycle: 8c begins with the 8th")
    add("--to", dest="stop", metavar="TIME", help="seconds, or a cycle: 10c ends with the 10th")
    add("--speed", type=float, default=1.0, help="seconds of the run per second of video; 1")
    add("--fps", type=float, default=30.0, help="frames per second; 30")
    add("--size", metavar="WxH", default="1280x720", help="of the picture [pixels]; 1280x720")
    add(
        "--camera",
        metavar="NAME|VIEW",
        help="of the model, or azimuth,elevation,distance as in --camera=120,-20,1.5; "
        "one that frames the motion",
    )
    add("--follow", action="store_true", help="go with the tool")
    add("--background", metavar="KIND", default="sky", help="sky, white, dark or transparent; sky")
    add("--label", dest="labels", action="append", help="what the picture calls a run; one each")
    add("--workers", metavar="N", type=int, help="processes that draw; one per core")
    for part, meaning in PARTS.items():
        add(f"--no-{part}", action="store_true", help=f"leave out {meaning}")


def render(options: argparse.Namespace, console: Console) -> Path:
    """Make the video that the options ask for; returns its path.

    Raises:
        ResonanceError: as `video.render`, and for runs that cannot be loaded.
    """
    from rich import progress

    from . import video
    from .look import Look
    from .run import Run

    look = Look(
        size=_size(options.size),
        camera=options.camera,
        follow=options.follow,
        background=options.background,
        **{
            part.replace("-", "_"): not getattr(options, "no_" + part.replace("-", "_"))
            for part in PARTS
        },
    )
    runs = [Run.load(folder) for folder in options.runs]
    labels = options.labels
    if labels is None and len({run.experiment.name for run in runs}) < len(runs):
        labels = [folder.resolve().name for folder in options.runs]
    bars = progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TextColumn("frames"),
        progress.TimeElapsedColumn(),
        progress.TextColumn("left"),
        progress.TimeRemainingColumn(),
        console=console,
    )
    path = options.output or options.runs[0] / "motion.mp4"
    with bars:
        bar = bars.add_task(path.name, total=None)
        return video.render(
            runs,
            path,
            options.start,
            options.stop,
            options.fps,
            speed=options.speed,
            look=look,
            labels=labels,
            workers=options.workers,
            progress=lambda done, total: bars.update(bar, completed=done, total=total),
            note=lambda line: console.print(f"  {line}", soft_wrap=True),
        )


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise PictureError(f"size {text!r}: give width and height in pixels, as in 1280x720")
    return int(width), int(height)
