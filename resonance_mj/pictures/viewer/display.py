"""Whether there is a display to open a window on, and what to do where there is none."""

import os
import sys
import warnings

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


def check() -> None:
    """See that a window can be opened, by opening one that is not shown.

    MuJoCo's viewer would wait for ever for one that cannot.

    Raises:
        PictureError: there is no display, or no OpenGL on it.
    """
    if sys.platform != "linux":
        return  # On macOS only mjpython may try, on a thread of its own; `Window` says so.
    shown = ", ".join(f"{name}={os.environ[name]}" for name in NAMES if os.environ.get(name))
    if not shown:
        raise PictureError(f"no display: neither {' nor '.join(NAMES)} is set; {INSTEAD}")
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what GLFW says of an error, which is read below
        if glfw.init():  # it stays up: GLFW cannot be begun twice
            glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
            window = glfw.create_window(64, 64, "resonance-mj", None, None)
            glfw.default_window_hints()
            if window:
                glfw.destroy_window(window)
                return
        said = glfw.get_error()[1] or "GLFW does not say why"
    reason = said.decode() if isinstance(said, bytes) else said
    raise PictureError(f"no window can be opened ({shown}: {reason}); {INSTEAD}")
