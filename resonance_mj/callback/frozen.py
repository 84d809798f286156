"""What compiling a function freezes: its code, its constants, and the globals that it reads."""

import builtins
from collections.abc import Callable, Iterator
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

KNOWN = ("math", "cmath", "numpy")
"""Modules whose contents do not change but with their versions."""

LARGEST = 1_000_000
"""Bytes of an array that Numba writes into its code; of larger ones it writes the address."""


def frozen(function: Callable[..., Any]) -> bytes | None:
    """All that the machine code of a function depends on, but for the compiler.

    Returns:
        None if it reads something that may change without a trace, such as a module of its own.
    """
    parts: list[str] = []
    return "\n".join(parts).encode() if _told(function, parts, set()) else None


def globals_read(function: FunctionType) -> dict[str, Any]:
    """The globals that a function and those inside it read, by name."""
    return {
        name: function.__globals__[name]
        for name in sorted(_names(function.__code__) & function.__globals__.keys())
    }


def _told(value: Any, parts: list[str], seen: set[int]) -> bool:
    """Add what a value is to `parts`, and say whether that is all of it."""
    if isinstance(value, FunctionType):
        parts.append(value.__qualname__)
        if id(value) in seen:
            return True
        seen.add(id(value))
        read = [cell.cell_contents for cell in value.__closure__ or ()]
        # The package's own functions change with its source files, which the caller knows.
        if str(value.__module__).partition(".")[0] != __package__.partition(".")[0]:
            if any(_of_numba(one) for one in value.__globals__.values()):
                return False  # what it tells the compiler is not in its code
            used = globals_read(value)
            read += [*(value.__defaults__ or ()), *(value.__kwdefaults__ or {}).values()]
            read += used.values()
            parts += [*_code(value.__code__), *used]
        return all(_told(one, parts, seen) for one in read)
    if isinstance(value, ModuleType | BuiltinFunctionType | np.ufunc):
        name = value.__name__ if isinstance(value, ModuleType) else f"numpy.{value!r}"
        owner = getattr(value, "__module__", None) or name
        parts.append(f"{owner} {name}")
        return owner.partition(".")[0] in (*KNOWN, "builtins")
    if isinstance(value, np.ndarray):
        parts.append(f"{value.dtype} {value.shape} {value.tobytes().hex()}")
        return value.dtype.kind in "biufc" and value.nbytes <= LARGEST
    if type(value) is tuple:
        parts.append(f"tuple {len(value)}")
        return all(_told(item, parts, seen) for item in value)
    if isinstance(value, type):
        parts.append(value.__qualname__)
        return value is getattr(builtins, value.__name__, None)
    if isinstance(value, np.number) or type(value) in (int, float, complex, str, bool, type(None)):
        parts.append(f"{type(value).__name__} {value!r}")
        return True
    return False


def _of_numba(value: Any) -> bool:
    own = "__name__" if isinstance(value, ModuleType) else "__module__"
    owners = (getattr(value, own, None), type(value).__module__)
    return any(str(owner).partition(".")[0] == "numba" for owner in owners)


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
