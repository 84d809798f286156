"""The process that draws frames; it is started with MUJOCO_GL set, as a module of this name.

It reads from its standard input, pickled, the parts of the picture, how it looks and the numbers of
the frames to draw, says in one line that it is ready or what is wrong, and writes these frames as
raw pixels to its standard output.
"""

import os
import pickle
import signal
import sys

import numpy as np

from ...errors import ResonanceError

READY, WRONG, BROKEN, NO_OPENGL = "ready", "wrong", "broken", "no OpenGL"


def main() -> None:
    """Draw what standard input asks for."""
    # An interrupt is for the process that started this one; it closes the pipes.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())

    def send(content: memoryview) -> None:
        while content:  # a process that is stopped and goes on may have written a part
            content = content[output.write(content) :]

    def say(line: str) -> None:
        send(memoryview((" ".join(line.split()) + "\n").encode()))

    try:
        import mujoco

        mujoco.GLContext(16, 16).free()
    except Exception as error:  # MuJoCo and PyOpenGL raise any where there is none
        say(f"{NO_OPENGL}: {type(error).__name__}: {error}")
        return
    try:
        from .frames import FrameRenderer

        parts, options, frames = pickle.load(sys.stdin.buffer)
        renderers = [FrameRenderer(part, options) for part in parts]
    except ResonanceError as error:
        say(f"{WRONG}: {error}")
        return
    except Exception as error:
        say(f"{BROKEN}: frames cannot be drawn: {type(error).__name__}: {error}")
        raise
    say(READY)
    width, height = options.size
    picture = np.full((height, width, options.channels), 128, np.uint8)
    try:
        for frame in frames:
            for renderer in renderers:
                renderer.draw(picture, frame)
            send(picture.data.cast("B"))
    except BrokenPipeError:
        return


if __name__ == "__main__":
    main()
