"""A run becomes a video: processes draw its frames, and they are encoded in order."""

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import PictureError
from ...files import could_be_replaced
from ...progress import Asked, progressing
from ...results.run import Run
from ...text import cut, listed, one_line
from . import crew, encoding, frame_data, plots
from .options import RenderOptions

FPS = (0.1, 1000.0)
"""Least and most frames per second."""
MOST = 1_000_000
"""Frames of a video."""


def render(
    run: Run | Sequence[Run],
    path: str | os.PathLike[str],
    start: float | str | None = None,
    stop: float | str | None = None,
    fps: float = 30.0,
    *,
    speed: float = 1.0,
    options: RenderOptions | None = None,
    labels: Sequence[str] | None = None,
    workers: int | None = None,
    progress: Asked = None,
    note: Callable[[str], None] | None = None,
) -> Path:
    """Film a run, or two or more side by side and in step.

    Args:
        run: the run or runs.
        path: the video: .mp4 (H.264), .webp or .gif.
        start: where it begins: seconds of the run, or a cycle such as "8c"; the run's start.
        stop: where it ends: seconds, or a cycle such as "10c" with whose end it ends; the run's.
        fps: frames per second.
        speed: seconds of the run per second of video.
        options: size, camera, background and what is drawn; all has defaults.
        labels: what the picture calls each run; the experiments' names.
        workers: processes that draw; one per core.
        progress: is called with the number of frames done and that of all; a bar in a terminal or a
            notebook if not given, nothing for False.
        note: is called with each line that the user should know.

    Returns:
        The path of the video.

    Raises:
        PictureError: the span, the camera, the size or the format is not valid, or there is no
            OpenGL to draw with.
        OutputError: the file cannot be written; then there is none.
        RobotError: the arm's MJCF is missing.
    """
    runs = (run,) if isinstance(run, Run) else tuple(run)
    if not FPS[0] <= fps <= FPS[1]:
        raise PictureError(f"fps = {fps:g}: it must be between {FPS[0]:g} and {FPS[1]:g}")
    if not 0 < speed < float("inf"):
        raise PictureError(f"speed = {speed:g}: it must be greater than 0")
    low, high = frame_data.common_span(runs, start, stop)
    if (high - low) * fps > MOST * speed:
        raise PictureError(
            f"from {low:g} s to {high:g} s at {fps:g} fps and speed {speed:g} there are "
            f"{(high - low) / speed * fps:.3g} frames; a video has at most {MOST}"
        )
    times = frame_data.times(runs, low, high, speed / fps, start is not None or stop is not None)
    return film(
        runs,
        path,
        times,
        fps,
        options=options,
        labels=labels,
        workers=workers,
        progress=progress,
        note=note,
    )


def film(
    runs: Sequence[Run],
    path: str | os.PathLike[str],
    times: np.ndarray,
    fps: float,
    *,
    options: RenderOptions | None = None,
    labels: Sequence[str] | None = None,
    workers: int | None = None,
    progress: Asked = None,
    note: Callable[[str], None] | None = None,
) -> Path:
    """Film runs at given times, which need not follow each other evenly.

    Args:
        runs: the runs, side by side.
        path: the video.
        times: of the frames (F,) [s], ascending; every run has a sample at each, as those from
            `frame_data.times`.
        fps: frames per second.
        options: as for `render`; so are the following.
        labels: one for each run.
        workers: processes that draw.
        progress: is called with the number of frames done and that of all; a bar in a terminal or a
            notebook if not given, nothing for False.
        note: is called with each line that the user should know.

    Returns:
        The path of the video.

    Raises:
        PictureError, OutputError, RobotError: as `render`.
    """
    path, options, note = Path(path), options or RenderOptions(), note or (lambda line: None)
    if labels and len(labels) != len(runs):
        raise PictureError(
            f"{len(labels)} labels, {listed(labels)}, for {len(runs)} runs: give one for each"
        )
    encoding.check(path, options.background == "transparent")
    could_be_replaced(path)
    if path.suffix.lower() == ".mp4":
        options = _even(options, note)
    names = (cut(one_line(name), 40) for name in labels or (one.experiment.name for one in runs))
    taken = tuple(
        frame_data.of_run(one, times, name) for one, name in zip(runs, names, strict=True)
    )
    below = plots.pictures(tuple(runs), options)
    with (
        crew.drawn(taken, below, options, workers, note) as frames,
        encoding.encoder(path, options.size, fps, options.channels) as encode,
        progressing(progress, path.name, "frames") as show,
    ):
        for number, pixels in enumerate(frames):
            encode(pixels)
            show(number + 1, len(times))
    return path


def _even(options: RenderOptions, note: Callable[[str], None]) -> RenderOptions:
    """The options in a size that H.264 takes."""
    width, height = options.size
    even = (width + width % 2, height + height % 2)
    if even == options.size:
        return options
    note(f"size {width}x{height} is drawn as {even[0]}x{even[1]}: H.264 needs even")
    return replace(options, size=even)
