"""Processes that draw frames, each of them every so many, with the first OpenGL that works."""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...errors import PictureError
from . import gl
from .drawing_process import BROKEN, READY, WRONG
from .frame_data import FrameData, scales
from .frames import Part, PlotPicture
from .options import RenderOptions
from .surroundings import prepare


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def drawn(
    taken: tuple[FrameData, ...],
    below: tuple[PlotPicture | None, ...],
    options: RenderOptions,
    workers: int | None,
    note: Callable[[str], None],
) -> Iterator[Iterator[memoryview]]:
    """The pixels of each frame in order, in one buffer that is filled again.

    Args:
        taken: what is shown side by side, with as many frames each.
        below: the plots below each.
        options: how it looks.
        workers: processes that draw; one per core if None.
        note: is called with each line that the user should know.

    Raises:
        PictureError: there is no OpenGL to draw with, or no process to draw.
        RobotError: the arm's file is missing.
    """
    if workers is not None and workers < 1:
        raise PictureError(f"workers = {workers}: there must be at least 1")
    height = options.size[1] - options.plots_height
    parts = tuple(
        Part(one, *prepare(one, options, (right - left, height), note), scale, plots, left, right)
        for one, (left, right), scale, plots in zip(
            taken, options.columns(len(taken)), scales(taken), below, strict=True
        )
    )
    frames = range(len(taken[0].sample))
    count = min(workers or cores(), len(frames))
    pixels = memoryview(bytearray(options.channels * options.size[0] * options.size[1]))
    tried: dict[str, str] = {}
    for backend in gl.backends():
        jobs = [(parts, options, frames[i::count]) for i in range(count)]
        crew = [_started(job, backend, count) for job in jobs]
        try:
            answers = [_line(process) for process in crew]
            if all(answer == READY for answer in answers):
                yield (_filled(pixels, crew[frame % count]) for frame in frames)
                return
            answer = next(answer for answer in answers if answer != READY)
            kind, _, reason = answer.partition(": ")
            if kind in (WRONG, BROKEN):
                raise PictureError(reason)
            tried[backend or "default"] = reason
        finally:
            for process in crew:
                with process:
                    process.kill()
    raise PictureError(gl.missing(tried))


def _started(job: tuple[object, ...], backend: str | None, count: int) -> subprocess.Popen[bytes]:
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
    with suppress(BrokenPipeError), process.stdin as pipe:
        pickle.dump(job, pipe, protocol=pickle.HIGHEST_PROTOCOL)
    return process


def _line(process: subprocess.Popen[bytes]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().decode(errors="replace").strip() or "the process ended"


def _filled(pixels: memoryview, process: subprocess.Popen[bytes]) -> memoryview:
    """The buffer with the next frame of a process."""
    if process.stdout.readinto(pixels) < len(pixels):  # type: ignore[union-attr]
        raise PictureError(f"a process that draws ended with status {process.wait()}")
    return pixels
