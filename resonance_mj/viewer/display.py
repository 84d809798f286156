"""Whether there is a display to open a window on, and what to do where there is none."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Mapping

from ..errors import PictureError

INSTEAD = (
    "`resonance-mj render RUN` films a run without a display, and `xvfb-run -a resonance-mj view "
    "...` opens the window on a virtual one"
)
ON_MACOS = (
    "on macOS the viewer needs the Python that comes with MuJoCo: mjpython -m resonance_mj.cli "
    "view ...; `resonance-mj render RUN` films a run without it"
)


def check(environment: Mapping[str, str] = os.environ, platform: str = sys.platform) -> None:
    """See that a window can be opened.

    MuJoCo's viewer would wait for ever for one that cannot.

    Raises:
        PictureError: there is no display, or no OpenGL on it.
    """
    if platform == "darwin":
        return  # Only mjpython may try, on a thread of its own; `Window` says so.
    names = ("DISPLAY", "WAYLAND_DISPLAY")
    if platform == "linux" and not any(environment.get(name) for name in names):
        raise PictureError(f"no display: neither {' nor '.join(names)} is set; {INSTEAD}")
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what GLFW says of an error, which is read below
        try:
            opened = glfw.init() and _try_window()
            reason = "" if opened else glfw.get_error()[1]
        finally:
            glfw.terminate()
    if not opened:
        said = reason.decode() if isinstance(reason, bytes) else str(reason or "GLFW does not say")
        shown = ", ".join(f"{name}={environment[name]}" for name in names if environment.get(name))
        raise PictureError(f"no window can be opened ({shown or platform}: {said}); {INSTEAD}")


def _try_window() -> bool:
    import glfw

    glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
    window = glfw.create_window(64, 64, "resonance-mj", None, None)
    if window:
        glfw.destroy_window(window)
    return bool(window)
