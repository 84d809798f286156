"""The mark of functions that run at each control step: plain Python that can also be compiled.

Marking imports no compiler: a run whose machine code is on disk never needs one.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

STEP_FUNCTIONS: list[Callable[..., Any]] = []
"""All functions that the control step is made of, in the order of their definition."""


SOURCES: dict[str, bytes] = {}
"""The files that compiled code comes from, as they were when they were imported.

One that is edited later is not what a process runs, nor what it compiles.
"""


def keep_source(file: str) -> bytes:
    """The text of a file that is being imported, or was."""
    if file not in SOURCES:
        SOURCES[file] = Path(file).read_bytes()
    return SOURCES[file]


def step_function(function: Function) -> Function:
    """Mark a function, of scalars and arrays alone, that `compilation` shall compile."""
    keep_source(function.__code__.co_filename)
    STEP_FUNCTIONS.append(function)
    return function
