"""A law from outside: a Python file named in the experiment, run through the same callback."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import ExperimentError
from ..experiments.law_section import KINDS
from ..step_functions import step_function
from .controller import Command, standard
from .own import own as views

COMMAND = ("J", "error", "rate", "q", "dq", "u", "parameters", "y", "tau")
"""Arguments of a custom law's `command`, which is compiled and fills y and tau at each step."""

LEARN = ("u", "y", "q", "stiffness", "offset", "center", "parameters")
"""Arguments of a custom law's `learn`, which returns u, stiffness, offset, center."""


@dataclass(frozen=True)
class CustomLaw:
    """What a law's file gives; what it does not give is the transfer law's.

    Attributes:
        command: the control step's part that sets y and τ.
        learn: what happens between two cycles, or None.
    """

    command: Command
    learn: Callable[..., Any] | None
    file: str = ""

    def learned(
        self, signals: tuple[np.ndarray, ...], parameters: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """What the file's `learn` returns for a cycle: u (N, n), stiffness, offset, center (n,).

        Raises:
            ExperimentError: it raises, or what it returns is not of these shapes or not finite.
        """
        assert self.learn is not None
        try:
            found = tuple(np.asarray(part, float) for part in self.learn(*signals, parameters))
        except Exception as error:
            raise ExperimentError(f"{self.file}: learn raised {error!r}") from error
        u, _, _, stiffness, offset, center = signals
        wanted = [part.shape for part in (u, stiffness, offset, center)]
        if [part.shape for part in found] != wanted or not all(
            np.isfinite(part).all() for part in found
        ):
            raise ExperimentError(
                f"{self.file}: learn returned shapes {[part.shape for part in found]}; finite u, "
                f"stiffness, offset, center of shapes {wanted} are needed"
            )
        return found


@cache
def load(file: str) -> CustomLaw:
    """Load a law's file.

    Raises:
        ExperimentError: there is no such file, it cannot be imported, or its functions are not of
            the documented shape.
    """
    path = Path(file)
    if not path.is_file():
        raise ExperimentError(
            f"law.kind = {file!r}: no such file; give {', '.join(KINDS)}, or the path of a Python "
            "file with a function `command` or `learn`"
        )
    module = _imported(path)
    command, learn = (getattr(module, name, None) for name in ("command", "learn"))
    if command is None and learn is None:
        raise ExperimentError(f"{path}: defines neither `command` nor `learn`; one is needed")
    for function, arguments in ((command, COMMAND), (learn, LEARN)):
        if function is not None:
            _check_shape(path, function, arguments)
    return CustomLaw(standard if command is None else _adapted(command), learn, str(path))


def _imported(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"resonance_mj_law_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ExperimentError(f"{path}: is no Python file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ExperimentError(f"{path}: cannot be imported: {error!r}") from error
    return module


def _check_shape(path: Path, function: Callable[..., Any], arguments: tuple[str, ...]) -> None:
    found = tuple(inspect.signature(function).parameters)
    if found != arguments:
        raise ExperimentError(
            f"{path}: {function.__name__}({', '.join(found)}): its arguments must be "
            f"({', '.join(arguments)})"
        )


def _adapted(custom: Callable[..., None]) -> Command:
    """A custom `command` as the control step calls it."""
    # Its runtime must be there: a compiled law of one's own may allocate or raise.
    importlib.import_module("numba")
    step_function(custom)

    @step_function
    def command(memory: np.ndarray, qpos: np.ndarray, qvel: np.ndarray) -> None:
        own = views(memory)
        for j in range(own.n):
            own.q[j] = qpos[int(own.qpos_address[j])]
            own.dq[j] = qvel[int(own.dof_address[j])]
        custom(
            own.J, own.error, own.rate, own.q, own.dq, own.learned, own.parameters, own.y, own.tau
        )

    return command
