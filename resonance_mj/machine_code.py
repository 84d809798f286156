"""Machine code kept on disk: a compiled function is loaded without its compiler."""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import llvmlite.binding as llvm
from platformdirs import user_cache_path

from .errors import OutputError
from .files import replacing, writable

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
        cannot be written, each process compiles anew.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    processor, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    everything = (processor, features, version("numba"), version("llvmlite"), version("numpy"))
    digest = hashlib.sha256(key + repr(everything).encode()).hexdigest()[:24]
    path = user_cache_path("resonance-mj") / f"control-{digest}.o"
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=processor, features=features, opt=3, codemodel="jitdefault", jit=True
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    try:
        code = path.read_bytes()
    except OSError:
        code = _compiled(machine, *translate())
        with contextlib.suppress(OutputError):
            writable(path.parent)
            with replacing(path) as beside:
                beside.write_bytes(code)
    needs, _, code = code.partition(b"\n")
    _define_missing(needs.decode().split())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _loaded.append(engine)
    return int(engine.get_function_address(_NAME))


def _compiled(machine: Any, text: str, name: str) -> bytes:
    """A line with the names of what the machine code needs from outside, and the code."""
    module = llvm.parse_assembly(text)
    module.get_function(name).name = _NAME
    outside = (*module.functions, *module.global_variables)
    needs = [one.name for one in outside if one.is_declaration and "llvm." not in one.name]
    return " ".join(needs).encode() + b"\n" + bytes(machine.emit_object(module))


def _define_missing(names: list[str]) -> None:
    """Let what is not in this process end it, if it were ever called.

    Compiled functions name what Numba needs to raise an exception, whether they ever do or not, and
    code with undefined names cannot be loaded. Where Numba is imported, they are its own.
    """
    abort = ctypes.cast(ctypes.CDLL(None).abort, ctypes.c_void_p).value
    for name in names:
        if llvm.address_of_symbol(name) is None:
            llvm.add_symbol(name, abort)
