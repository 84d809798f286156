"""The OpenGL that pictures are drawn with where there is no display, and what to install."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

INSTALL = (
    "install one: Debian or Ubuntu `apt install libegl1 libgl1`, Fedora `dnf install "
    "mesa-libEGL mesa-libGL`; macOS needs no package but a session with a display"
)


def backends(environment: Mapping[str, str] = os.environ) -> tuple[str | None, ...]:
    """Values of MUJOCO_GL to try in turn; None leaves the choice to MuJoCo.

    MUJOCO_GL decides alone where the user has set it. It must be in the environment before mujoco
    is first imported, which only a process that is started for it can promise.
    """
    if environment.get("MUJOCO_GL"):
        return (environment["MUJOCO_GL"],)
    return ("egl", "osmesa") if sys.platform == "linux" else (None,)


def import_mujoco() -> None:
    """Import MuJoCo without OpenGL: a MUJOCO_GL that does not work would keep it from that.

    Only the processes that draw, which are started with the MUJOCO_GL that stays, need it.
    """
    given = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        import mujoco  # noqa: F401
    finally:
        del os.environ["MUJOCO_GL"]
        if given is not None:
            os.environ["MUJOCO_GL"] = given


def missing(tried: Mapping[str, str]) -> str:
    """One line on why nothing can be drawn.

    Args:
        tried: what each backend said.
    """
    reasons = "; ".join(f"{name}: {reason}" for name, reason in tried.items())
    if os.environ.get("MUJOCO_GL"):
        reasons += "; MUJOCO_GL was set by you: unset it to have egl and osmesa tried"
    return f"no OpenGL that draws without a display was found ({reasons}); {INSTALL}"
