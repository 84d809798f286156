"""Whether there is a display to open a window on, and what to do where there is none."""

import os
import sys
import warnings
from collections.abc import Mapping

from ...errors import PictureError

NAMES = ("DISPLAY", "WAYLAND_DISPLAY")
"""What of the environment names a display on Linux."""
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
    if platform != "linux":
        return  # On macOS only mjpython may try, on a thread of its own; `Window` says so.
    if not any(environment.get(name) for name in NAMES):
        raise PictureError(f"no display: neither {' nor '.join(NAMES)} is set; {INSTEAD}")
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what GLFW says of an error, which is read below
        if _opens():
            return
        said = glfw.get_error()[1] or "GLFW does not say why"
    shown = ", ".join(f"{name}={environment[name]}" for name in NAMES if environment.get(name))
    reason = said.decode() if isinstance(said, bytes) else said
    raise PictureError(f"no window can be opened ({shown}: {reason}); {INSTEAD}")


def _opens() -> bool:
    """Whether a window opens, which is not shown. GLFW stays up: it cannot be begun twice."""
    import glfw

    if not glfw.init():
        return False
    glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
    window = glfw.create_window(64, 64, "resonance-mj", None, None)
    glfw.default_window_hints()
    if window:
        glfw.destroy_window(window)
    return bool(window)
