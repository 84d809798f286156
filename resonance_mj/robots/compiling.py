"""An editable model is compiled, with MuJoCo's own message and the file in the error."""

from __future__ import annotations

from pathlib import Path

import mujoco

from ..errors import RobotError


def compile_spec(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    """Compile, with MuJoCo's own message and the file in the error.

    Raises:
        RobotError: MuJoCo rejects the model.
    """
    try:
        return spec.compile()
    except ValueError as error:
        raise RobotError(rejected(path, error)) from None


def rejected(path: Path, error: ValueError) -> str:
    """What to say of a file that MuJoCo rejects."""
    return f"{path}: MuJoCo rejects it: {' '.join(str(error).split())}"
