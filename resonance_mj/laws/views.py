"""The controller's block as a control step sees it: `own.tau_min[j]`, `own.alpha`, a row to record.

Compiled, a view costs nothing but the arithmetic of its address, and one that is not used nothing.
"""

import math
from collections import namedtuple
from typing import Any

import numpy as np

from ..step_functions import step_function
from .memory import ARRAYS, COLUMNS, SIGNATURE, Header


@step_function
def block(userdata: np.ndarray) -> np.ndarray:
    """The controller's block of `userdata`; empty if the model has none.

    The callback is called for every model that the process steps, forwards or compiles.
    """
    end = userdata.size - 2
    if end < 0 or userdata[end + 1] != SIGNATURE:
        return userdata[:0]
    return userdata[int(userdata[end]) : end]


def vector(memory: np.ndarray, start: float, size: int) -> np.ndarray:
    """View of `size` numbers of the block from `start`."""
    return memory[int(start) : int(start) + size]


_COUNTS = "joints coordinates dofs columns wide more given site form slots delay torque_delay hold"
INTEGERS = [*_COUNTS.split(), "clock", "step"]
"""Numbers of the header that count."""

FLAGS = [
    "rotates",
    "difference",
    "inertial",
    "differs",
    "driven",
    "material",
    "misjudged",
    "outside",
]
"""Numbers of the header that are yes or no."""

TABLES = ("steps", "noisy")
"""First sizes of the tables over the cycle, of which a control step sees its row."""


SIZES = {"three": 3, "six": 6}
"""Sizes of arrays that are no numbers of the header."""


def header_name(name: str) -> str:
    """Name in the header of a number by its name in the paper."""
    return {"n": "joints", "m": "coordinates"}.get(name, name)


class Own:
    """The block as a control step sees it, and of the tables over the cycle this step's rows.

    Each number of the header and each array is an attribute, made when it is first asked for.

    Args:
        memory: the controller's block.
    """

    def __init__(self, memory: np.ndarray) -> None:
        self.memory = memory

    def __getattr__(self, name: str) -> Any:
        key = header_name(name)
        value: Any = self.memory[getattr(Header, key.upper())]
        if key in ARRAYS:
            row = ARRAYS[key][0] in TABLES
            shape = [
                SIZES[size] if size in SIZES else getattr(self, size) for size in ARRAYS[key][row:]
            ]
            start = int(value) + row * self.step * shape[0]
            value = self.memory[start : start + math.prod(shape)].reshape(shape)
        elif key in INTEGERS:
            value = int(value)
        elif key in FLAGS:
            value = bool(value == 1.0)
        setattr(self, name, value)
        return value


def own(memory: np.ndarray) -> Own:
    """The block as a control step sees it."""
    return Own(memory)


_named: Any = namedtuple  # whose names a type checker cannot follow

Row = _named("Row", list(COLUMNS))
"""What a control step records."""


@step_function
def row(memory: np.ndarray, n: int, m: int, step: int) -> Any:
    """What this control step records."""
    start = memory[Header.RECORD] + step * memory[Header.COLUMNS]
    return Row(
        q=vector(memory, start, n),
        dq=vector(memory, start + n, n),
        x=vector(memory, start + 2 * n, m),
        y=vector(memory, start + 2 * n + m, n),
        tau=vector(memory, start + 3 * n + m, n),
        u=vector(memory, start + 4 * n + m, n),
        stiffness=vector(memory, start + 5 * n + m, n),
        offset=vector(memory, start + 6 * n + m, n),
    )
