"""The law as MuJoCo's control callback, compiled or interpreted.

`mjcb_control` is one pointer for the whole process: `installed` sets it for the length of a `with`
block, and refuses where another callback is in place.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

import llvmlite.binding
import mujoco

from ..errors import CallbackError
from ..laws.controller import Command, act, begins_step, end_stage, failed, hold, standard
from ..laws.memory import Header, block, matrix
from ..step_functions import STEP_FUNCTIONS
from . import machine_code, structs

_installing = threading.Lock()

_BUSY = (
    "a simulation is already running in this process, and MuJoCo has one control callback per "
    "process: run them one after the other, together with simulate_many, or in processes of their "
    "own"
)
_FOREIGN = (
    "another control callback is installed in this process: remove it with "
    "mujoco.set_mjcb_control(None) before a simulation"
)


@contextmanager
def installed(*, interpret: bool = False, command: Command = standard) -> Iterator[None]:
    """Install the control callback while the `with` block runs, and remove it after.

    Args:
        interpret: run the law as plain Python, for a debugger, instead of compiled.
        command: the part of the control step that sets y and τ; a custom law's, or the standard.

    Raises:
        CallbackError: a control callback is installed already, by this package or another.
    """
    function = partial(_interpreted, command) if interpret else _compiled(command)
    if not _installing.acquire(blocking=False):
        raise CallbackError(_BUSY)
    try:
        if _pointer_in_libmujoco():
            raise CallbackError(_FOREIGN)
        mujoco.set_mjcb_control(function)
        try:
            yield
        finally:
            mujoco.set_mjcb_control(None)
    finally:
        _installing.release()


def refuse_another() -> None:
    """Raise a CallbackError if a control callback is in place, this package's or another.

    Checked before a robot is loaded, because MuJoCo calls it while it compiles a model.
    """
    if _installing.locked():
        raise CallbackError(_BUSY)
    if _pointer_in_libmujoco():
        raise CallbackError(_FOREIGN)


def _interpreted(command: Command, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """The control callback as plain Python: the same functions that `_compiled` compiles."""
    mem = block(data.userdata)
    if mem.size == 0:
        return
    if begins_step(mem):
        site = int(mem[Header.SITE])
        jacobian = matrix(mem, mem[Header.JACOBIAN], 6, int(mem[Header.DOFS]))
        rotational = jacobian[3:] if mem[Header.ROTATES] == 1.0 else None
        mujoco.mj_jacSite(model, data, jacobian[:3], rotational, site)
        orientation = data.site_xmat[site].reshape(3, 3)
        act(mem, data.qpos, data.qvel, data.site_xpos[site], orientation, data.ctrl, command)
    if failed(mem):
        hold(data.qvel, data.ctrl, data.qfrc_bias, data.qfrc_passive)
    end_stage(mem, model.jnt_stiffness, model.qpos_spring)


@cache
def _compiled(command: Command = standard) -> Callable[..., Any]:
    """The control callback as a C function, compiled once and kept on disk."""
    llvmlite.binding.load_library_permanently(str(_libmujoco()))
    layout = (structs.MODEL_OFFSETS, structs.DATA_OFFSETS)

    def translate() -> tuple[str, str]:
        from . import compilation

        return compilation.translate(*layout, command)

    address = machine_code.load(repr(layout).encode() + _sources(command), translate)
    return ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(address)


def _sources(command: Command) -> bytes:
    """All source code that the callback is made of: an edit in any of its files compiles anew."""
    cells = (cell.cell_contents for cell in command.__closure__ or ())
    functions = [command, *(value for value in cells if callable(value))]
    files = [str(Path(__file__).with_name("compilation.py"))]
    files += sorted({function.__code__.co_filename for function in (*STEP_FUNCTIONS, *functions)})
    names = repr([function.__qualname__ for function in functions]).encode()
    return names + b"".join(Path(file).read_bytes() for file in files)


def _libmujoco() -> Path:
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll"):
        for path in sorted(folder.glob(pattern)):
            return path
    raise CallbackError(f"{folder}: no MuJoCo library was found there; reinstall mujoco")


def _pointer_in_libmujoco() -> int | None:
    library = ctypes.CDLL(str(_libmujoco()))
    return ctypes.c_void_p.in_dll(library, "mjcb_control").value
