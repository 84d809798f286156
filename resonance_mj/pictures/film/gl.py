"""The OpenGL that pictures are drawn with where there is no display, and what to install."""

import os
import sys
from collections.abc import Mapping

KEPT = "RESONANCE_MJ_GIVEN_GL"
"""Where the user's MUJOCO_GL is in the environment of a process that draws nothing itself."""


def set_aside() -> None:
    """Let this process import MuJoCo without OpenGL, which a wrong MUJOCO_GL would keep it from.

    The processes that it starts to draw are given what the user has set.
    """
    os.environ.setdefault(KEPT, os.environ.get("MUJOCO_GL", ""))
    os.environ["MUJOCO_GL"] = "disable"


def given(environment: Mapping[str, str] = os.environ) -> str:
    """MUJOCO_GL as the user has set it; empty if not."""
    value = environment.get("MUJOCO_GL", "")
    return environment.get(KEPT, value) if value == "disable" else value


def backends(environment: Mapping[str, str] = os.environ) -> tuple[str | None, ...]:
    """Values of MUJOCO_GL to try in turn; None leaves the choice to MuJoCo.

    MUJOCO_GL decides alone where the user has set it. It must be in the environment before mujoco
    is first imported, which only a process that is started for it can promise.
    """
    if chosen := given(environment):
        return (chosen,)
    return ("egl", "osmesa") if sys.platform == "linux" else (None,)


def missing(tried: Mapping[str, str]) -> str:
    """One line on why nothing can be drawn.

    Args:
        tried: what each backend said.
    """
    reasons = [f"{name}: {reason}" for name, reason in tried.items()]
    if given():
        reasons.append("MUJOCO_GL was set by you: unset it to have egl and osmesa tried")
    return (
        f"no OpenGL that draws without a display was found ({'; '.join(reasons)}); install one: "
        "Debian or Ubuntu `apt install libegl1 libgl1`, Fedora `dnf install mesa-libEGL "
        "mesa-libGL`; macOS needs no package but a session with a display"
    )
