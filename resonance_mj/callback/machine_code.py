"""Machine code kept on disk: a compiled function is loaded without its compiler."""

import ctypes
import hashlib
import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from platformdirs import user_cache_path

from ..errors import OutputError
from ..files import replacing

KEPT = 16
"""Files that the cache keeps, the newest."""

LARGEST = 8_000_000
"""Bytes that such a file may have."""

_NAME = "resonance_mj"
_loaded: list[Any] = []
_reasons: list[str] = []
_ABORT = ctypes.CFUNCTYPE(None)(os.abort)


def load(key: bytes | None, translate: Callable[[], tuple[str, str]]) -> int:
    """Address of a function whose machine code is on disk, or is compiled and put there.

    Args:
        key: all that the function depends on, but for this processor and the compiler; None for one
            that is to be compiled and not kept.
        translate: gives the function in LLVM's language, and its name.

    Returns:
        The address; valid as long as the process.

    Note:
        The code is in the user's cache folder, $XDG_CACHE_HOME/resonance-mj on Linux, and is loaded
        only if folder and file are the user's own and nobody else may write them. Where there is no
        such folder, each process compiles anew, and `not_kept` says why.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    processor, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=processor, features=features, opt=3, codemodel="jitdefault", jit=True
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    everything = (processor, features, version("numba"), version("llvmlite"), version("numpy"))
    digest = hashlib.sha256((key or b"") + repr(everything).encode()).hexdigest()[:24]
    path = None
    if key is not None:
        with _said_if_not_kept():
            path = _trusted_folder() / f"control-{digest}.o"
    try:
        needs, code = _parts(b"" if path is None else _read(path))
    except (OSError, ValueError):
        written = _compiled(machine, *translate())
        if path is not None:
            _keep(path, written)
        needs, code = _parts(written)
    _define_missing(needs)
    engine.add_object_file(code)
    engine.finalize_object()
    _loaded.append(engine)
    return int(engine.get_function_address(_NAME))


def not_kept() -> str:
    """Why this process's machine code is not on disk, in a line; empty if it is."""
    return _reasons[-1] if _reasons else ""


@contextmanager
def _said_if_not_kept() -> Iterator[None]:
    """Remember why something cannot be kept, instead of failing."""
    try:
        yield
    except (OutputError, OSError, RuntimeError) as error:
        reason = str(error) if isinstance(error, OutputError) else error
        _reasons.append(
            f"the compiled law is not kept, and each process compiles it anew: {reason}"
        )


def _trusted_folder() -> Path:
    """The user's cache folder; an OSError or RuntimeError where others could write there."""
    folder = user_cache_path("resonance-mj")
    if not folder.is_absolute():
        raise OSError("the user has no home, and XDG_CACHE_HOME names no folder")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not _own(folder.lstat(), stat.S_ISDIR):
        raise OSError(f"{folder} is not the user's own, or others may write there")
    return folder


def _own(found: os.stat_result, kind: Callable[[int], bool]) -> bool:
    """Whether a file or folder is this user's, and nobody else may write it."""
    mine = not hasattr(os, "geteuid") or found.st_uid == os.geteuid()
    return mine and kind(found.st_mode) and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _read(path: Path) -> bytes:
    careful = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    descriptor = os.open(path, os.O_RDONLY | careful)
    with os.fdopen(descriptor, "rb") as file:
        if not _own(os.fstat(descriptor), stat.S_ISREG):
            raise OSError(f"{path}: is not this user's own file")
        return file.read(LARGEST)


def _keep(path: Path, written: bytes) -> None:
    """Write a file into the cache, and drop the oldest of too many."""
    with _said_if_not_kept():
        with replacing(path) as beside:
            beside.write_bytes(written)
            beside.chmod(0o600)
        others = sorted(path.parent.glob("control-*.o"), key=lambda file: -file.stat().st_mtime)
        for file in others[KEPT:]:
            file.unlink()


def _parts(written: bytes) -> tuple[list[str], Any]:
    """What `_compiled` wrote: names and machine code; ValueError where it is not whole."""
    digest, _, rest = written.partition(b"\n")
    if digest != hashlib.sha256(rest).hexdigest().encode():
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
    return hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest


def _define_missing(names: list[str]) -> None:
    """Let what is not in this process end it, if it were ever called.

    Compiled functions name what Numba needs to raise an exception, whether they ever do or not, and
    code with undefined names cannot be loaded. Where Numba is imported, they are its own.
    """
    for name in names:
        if llvm.address_of_symbol(name) is None:
            llvm.add_symbol(name, ctypes.cast(_ABORT, ctypes.c_void_p).value)
