"""Machine code kept on disk: a compiled function is loaded without its compiler."""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from platformdirs import user_cache_path

from ..errors import OutputError
from ..files import replacing, writable

_NAME = "resonance_mj"
_loaded: list[Any] = []


def load(key: bytes, translate: Callable[[], tuple[str, str]]) -> int:
    """Address of a function whose machine code is on disk, or is compiled and put there.

    Args:
        key: all that the function depends on, but for this processor and the compiler.
        translate: gives the function in LLVM's language, and its name.

    Returns:
        The address; valid as long as the process.

    Note:
        The code is in the user's cache folder, $XDG_CACHE_HOME/resonance-mj on Linux. Where that
        cannot be written, or a user has no home, each process compiles anew.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    processor, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    everything = (processor, features, version("numba"), version("llvmlite"), version("numpy"))
    digest = hashlib.sha256(key + repr(everything).encode()).hexdigest()[:24]
    path = _kept(f"control-{digest}.o")
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=processor, features=features, opt=3, codemodel="jitdefault", jit=True
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    try:
        needs, code = _parts(path.read_bytes() if path else b"")
    except (OSError, ValueError):
        written = _compiled(machine, *translate())
        if path:
            with contextlib.suppress(OutputError):
                writable(path.parent)
                with replacing(path) as beside:
                    beside.write_bytes(written)
        needs, code = _parts(written)
    _define_missing(needs)
    engine.add_object_file(code)
    engine.finalize_object()
    _loaded.append(engine)
    return int(engine.get_function_address(_NAME))


def _kept(name: str) -> Path | None:
    """Where a file is kept in the user's cache folder; None for a user who has no home."""
    try:
        path = user_cache_path("resonance-mj") / name
    except RuntimeError:
        return None
    return path if path.is_absolute() else None


def _parts(written: bytes) -> tuple[list[str], Any]:
    """What `_compiled` wrote: names and machine code; ValueError where it is not whole."""
    digest, _, rest = written.partition(b"\n")
    if digest != _digest(rest):
        raise ValueError("no machine code, or not the whole of it")
    needs, _, code = rest.partition(b"\n")
    return needs.decode().split(), llvm.ObjectFileRef.from_data(code)


def _compiled(machine: Any, text: str, name: str) -> bytes:
    """A line with the digest of the rest, one with the names that the code needs, and the code."""
    module = llvm.parse_assembly(text)
    module.get_function(name).name = _NAME
    outside = (*module.functions, *module.global_variables)
    needs = [one.name for one in outside if one.is_declaration and "llvm." not in one.name]
    rest = " ".join(needs).encode() + b"\n" + bytes(machine.emit_object(module))
    return _digest(rest) + b"\n" + rest


def _digest(code: bytes) -> bytes:
    return hashlib.sha256(code).hexdigest().encode()


def _define_missing(names: list[str]) -> None:
    """Let what is not in this process end it, if it were ever called.

    Compiled functions name what Numba needs to raise an exception, whether they ever do or not, and
    code with undefined names cannot be loaded. Where Numba is imported, they are its own.
    """
    abort = ctypes.cast(ctypes.CDLL(None).abort, ctypes.c_void_p).value
    for name in names:
        if llvm.address_of_symbol(name) is None:
            llvm.add_symbol(name, abort)
