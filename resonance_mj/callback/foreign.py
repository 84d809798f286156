"""Callbacks that a user has installed in MuJoCo: none may act while this package simulates."""

from __future__ import annotations

import ctypes
import threading
from functools import cache
from pathlib import Path

import mujoco

from ..errors import CallbackError

ACTING = ("control", "passive", "contactfilter", "act_dyn", "act_gain", "act_bias", "sensor")
"""MuJoCo's callbacks, mjcb_NAME, that change what is simulated."""

installing = threading.Lock()
"""Held while this package's own control callback is installed."""


def refuse_foreign() -> None:
    """Raise a CallbackError that names a callback which acts in this process and is not ours.

    MuJoCo calls some of them while it compiles a model: the robot's file is not to blame.
    """
    for name in ACTING:
        if pointer(name) and not (name == "control" and installing.locked()):
            raise CallbackError(
                f"another callback, mjcb_{name}, is installed in this process and would act on the "
                f"robot: remove it with mujoco.set_mjcb_{name}(None) before"
            )


def pointer(name: str) -> int | None:
    """Address of the callback mjcb_NAME that is installed, None for none."""
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(libmujoco())), f"mjcb_{name}").value


@cache
def libmujoco() -> Path:
    """MuJoCo's shared library.

    Raises:
        CallbackError: it is not where the package mujoco has it.
    """
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll"):
        for path in sorted(folder.glob(pattern)):
            return path
    raise CallbackError(f"{folder}: no MuJoCo library was found there; reinstall mujoco")
