"""The mark of functions that run at each control step: plain Python that can also be compiled.

Marking imports no compiler: a run whose machine code is on disk never needs one.
"""

from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

STEP_FUNCTIONS: list[Callable[..., Any]] = []
"""All functions that the control step is made of, in the order of their definition."""


def step_function(function: Function) -> Function:
    """Mark a function, of scalars and arrays alone, that `compilation` shall compile."""
    STEP_FUNCTIONS.append(function)
    return function
