"""A run becomes a video: processes draw its frames, and they are encoded in order."""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import PictureError
from ...files import could_be_replaced
from ...results.run import Run
from ...text import cut, listed, one_line
from . import encoding, frame_data, gl, plots, render_model
from .drawing_process import BROKEN, READY, WRONG, Job
from .options import RenderOptions

Progress = Callable[[int, int], None]

FPS = (0.1, 1000.0)
"""Least and most frames per second."""
MOST = 1_000_000
"""Frames of a video."""


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


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
    progress: Progress | None = None,
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
        progress: is called with the number of frames done and that of all.
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
    progress: Progress | None = None,
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
        progress: is called with the number of frames done and that of all.
        note: is called with each line that the user should know.

    Returns:
        The path of the video.

    Raises:
        PictureError, OutputError, RobotError: as `render`.
    """
    path, options, note = Path(path), options or RenderOptions(), note or (lambda line: None)
    if workers is not None and workers < 1:
        raise PictureError(f"workers = {workers}: there must be at least 1")
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
    job = Job(
        shown=taken,
        models=tuple(
            render_model.prepare(
                one, options, (right - left, options.size[1] - options.plots_height), note
            )
            for one, (left, right) in zip(taken, options.columns(len(taken)), strict=True)
        ),
        plots=plots.pictures(tuple(runs), options),
        options=options,
        scales=frame_data.scales(taken),
        frames=range(len(times)),
    )
    pixels = bytearray(options.channels * options.size[0] * options.size[1])
    count = min(workers or cores(), len(times))
    with (
        _crew(job, count) as crew,
        encoding.encoder(path, options.size, fps, options.channels) as encode,
    ):
        for frame in job.frames:
            _read(crew[frame % count], memoryview(pixels))
            encode(memoryview(pixels))
            if progress:
                progress(frame + 1, len(times))
    return path


def _even(options: RenderOptions, note: Callable[[str], None]) -> RenderOptions:
    """The options in a size that H.264 takes."""
    width, height = options.size
    even = (width + width % 2, height + height % 2)
    if even == options.size:
        return options
    note(f"size {width}x{height} is drawn as {even[0]}x{even[1]}: H.264 needs even")
    return replace(options, size=even)


@contextmanager
def _crew(job: Job, count: int) -> Iterator[list[subprocess.Popen[bytes]]]:
    """Processes that draw every `count`-th frame each, with the first OpenGL that works."""
    tried: dict[str, str] = {}
    for backend in gl.backends():
        crew = [
            _start(replace(job, frames=job.frames[i::count]), backend, count) for i in range(count)
        ]
        try:
            answers = [_line(process) for process in crew]
            if all(answer == READY for answer in answers):
                yield crew
                return
            answer = next(answer for answer in answers if answer != READY)
            kind, _, reason = answer.partition(": ")
            if kind in (WRONG, BROKEN):
                raise PictureError(reason)
            tried[backend or "default"] = reason
        finally:
            for process in crew:
                process.kill()
                _close(process)
    raise PictureError(gl.missing(tried))


def _close(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        # What was not sent to a process that has ended is not missed.
        with suppress(BrokenPipeError):
            pipe.close()  # type: ignore[union-attr]
    process.wait()


def _start(job: Job, backend: str | None, count: int) -> subprocess.Popen[bytes]:
    # What stands in the working folder is not ours: -P keeps it off the path, where we are put.
    path = filter(None, (str(Path(__file__).parents[3]), os.environ.get("PYTHONPATH")))
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path)}
    environment["MUJOCO_GL"] = backend or ""
    if count > 1:
        # Software OpenGL has threads of its own: the processes share the cores already.
        environment.setdefault("LP_NUM_THREADS", "1")
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "resonance_mj.pictures.film.drawing_process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
    )
    assert process.stdin is not None
    # A process that has ended already says why.
    with suppress(BrokenPipeError):
        pickle.dump(job, process.stdin, protocol=pickle.HIGHEST_PROTOCOL)
        process.stdin.flush()
    return process


def _line(process: subprocess.Popen[bytes]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().decode(errors="replace").strip() or "the process ended"


def _read(process: subprocess.Popen[bytes], pixels: memoryview) -> None:
    """Fill `pixels` with the next frame of a process."""
    assert process.stdout is not None
    done = 0
    while done < len(pixels):
        got = process.stdout.readinto(pixels[done:])  # type: ignore[attr-defined]
        if not got:
            raise PictureError(f"a process that draws ended with status {process.wait()}")
        done += got
