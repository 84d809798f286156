"""What compiling a function freezes: its code, its constants, and the globals that it reads."""

from __future__ import annotations

import builtins
from collections.abc import Callable, Iterator
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

KNOWN = ("math", "cmath", "numpy")
"""Modules whose contents do not change but with their versions."""


def frozen(function: Callable[..., Any]) -> bytes | None:
    """All that the machine code of a function depends on, but for the compiler.

    Returns:
        None if it reads something that may change without a trace, such as a module of its own.
    """
    parts: list[str] = []
    seen: set[int] = set()
    return "\n".join(parts).encode() if _told(function, parts, seen) else None


def _told(value: Any, parts: list[str], seen: set[int]) -> bool:
    """Add what a value is to `parts`, and say whether that is all of it."""
    value = getattr(value, "py_func", value)  # of a function that Numba has decorated
    if isinstance(value, FunctionType):
        parts.append(value.__qualname__)
        if id(value) in seen:
            return True
        seen.add(id(value))
        read = [cell.cell_contents for cell in value.__closure__ or ()]
        # The package's own functions change with its source files, which the caller knows.
        if value.__module__.partition(".")[0] != __package__.partition(".")[0]:
            names = sorted(_names(value.__code__) & value.__globals__.keys())
            read += [*(value.__defaults__ or ()), *(value.__globals__[name] for name in names)]
            parts += [*_code(value.__code__), *names]
        return all(_told(one, parts, seen) for one in read)
    if isinstance(value, ModuleType | BuiltinFunctionType | np.ufunc):
        name = value.__name__ if isinstance(value, ModuleType) else f"numpy.{value!r}"
        owner = getattr(value, "__module__", None) or name
        parts.append(f"{owner} {name}")
        return owner.partition(".")[0] in KNOWN
    if isinstance(value, np.ndarray):
        parts.append(f"{value.dtype} {value.shape} {value.tobytes().hex()}")
        return value.dtype.kind in "biufc"
    if isinstance(value, tuple):
        parts.append(f"tuple {len(value)}")
        return all(_told(item, parts, seen) for item in value)
    parts.append(f"{type(value).__name__} {value!r}")
    if value is getattr(builtins, getattr(value, "__name__", ""), None):
        return True
    return isinstance(value, int | float | complex | str | bool | np.number | None)


def _code(code: CodeType) -> Iterator[str]:
    """The instructions and constants of code, with those of the functions inside it."""
    yield code.co_code.hex()
    yield repr((code.co_names, code.co_varnames, code.co_freevars))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _code(constant)
        else:
            yield repr(constant)


def _names(code: CodeType) -> set[str]:
    inner = (_names(one) for one in code.co_consts if isinstance(one, CodeType))
    return set(code.co_names).union(*inner)
