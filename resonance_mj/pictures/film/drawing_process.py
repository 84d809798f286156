"""The process that draws frames; it is started with MUJOCO_GL set, as a module of this name.

It reads a pickled `Job` from its standard input, says in one line that it is ready or what is
wrong, and writes its frames as raw pixels to its standard output.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import ResonanceError
from .frame_data import FrameData, Scale
from .options import RenderOptions
from .plot_picture import PlotPicture

if TYPE_CHECKING:
    import mujoco

READY, WRONG, BROKEN, NO_OPENGL = "ready", "wrong", "broken", "no OpenGL"


@dataclass(frozen=True)
class Job:
    """What a process draws.

    Attributes:
        shown: the runs side by side.
        models: the arm of each, and the name of its tool's site.
        plots: the plots below each; None for none.
        options: how the video looks.
        scales: what the overlays' full thickness, colour and length stand for.
        frames: numbers of the frames to draw, in order.
    """

    shown: tuple[FrameData, ...]
    models: tuple[tuple[mujoco.MjModel, str], ...]
    plots: tuple[PlotPicture | None, ...]
    options: RenderOptions
    scales: tuple[Scale, ...]
    frames: range


def main() -> None:
    """Draw what standard input asks for."""
    # An interrupt is for the process that started this one; it closes the pipes.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    try:
        import mujoco

        mujoco.GLContext(16, 16).free()
    except Exception as error:  # MuJoCo and PyOpenGL raise any where there is none
        _say(output, f"{NO_OPENGL}: {type(error).__name__}: {error}")
        return
    try:
        from .frames import FrameRenderer

        job: Job = pickle.load(sys.stdin.buffer)
        columns = job.options.columns(len(job.shown))
        renderers = [
            FrameRenderer(one, *model, job.options, scale, plot, right - left)
            for one, model, scale, plot, (left, right) in zip(
                job.shown, job.models, job.scales, job.plots, columns, strict=True
            )
        ]
    except ResonanceError as error:
        _say(output, f"{WRONG}: {error}")
        return
    except Exception as error:
        _say(output, f"{BROKEN}: frames cannot be drawn: {type(error).__name__}: {error}")
        raise
    _say(output, READY)
    picture = np.full(
        (job.options.size[1], job.options.size[0], job.options.channels), 128, np.uint8
    )
    try:
        for frame in job.frames:
            for renderer, (left, right) in zip(renderers, columns, strict=True):
                renderer.draw(picture[:, left:right], frame)
            _write(output, picture.data.cast("B"))
    except BrokenPipeError:
        return


def _say(output: object, line: str) -> None:
    _write(output, memoryview((" ".join(line.split()) + "\n").encode()))


def _write(output: object, pixels: memoryview) -> None:
    written = 0
    while written < len(pixels):
        written += os.write(output.fileno(), pixels[written:])  # type: ignore[attr-defined]


if __name__ == "__main__":
    main()
