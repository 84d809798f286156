"""An editable model is compiled, with MuJoCo's own message and the file in the error."""

from __future__ import annotations

import threading
import warnings
from pathlib import Path

import mujoco

from ..errors import RobotError
from . import warned

_turn = threading.Lock()


def compile_spec(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    """Compile, with MuJoCo's own message and the file in the error; its warnings are heard.

    Raises:
        RobotError: MuJoCo rejects the model.
    """
    # What Python warns of is recorded for the whole process: one thread at a time.
    with _turn, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            model = spec.compile()
        except ValueError as error:
            raise RobotError(rejected(path, error)) from None
    for one in said:
        warned.hear(str(one.message))
    return model


def rejected(path: Path, error: Exception) -> str:
    """What to say of a file that MuJoCo rejects."""
    return f"{path}: MuJoCo rejects it: {' '.join(str(error).split())}"
