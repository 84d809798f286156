"""The law as MuJoCo's control callback, compiled or interpreted.

`mjcb_control` is one pointer for the whole process: `installed` sets it for the length of a `with`
block, and refuses where another callback is in place.
"""

from __future__ import annotations

import ctypes
import hashlib
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

import llvmlite.binding
import mujoco
import numba
import numpy as np
from numba import carray, types
from numba.core import cgutils
from numba.core.errors import NumbaError
from numba.extending import intrinsic

from . import controller, equations, memory, springs, structs
from .controller import Command, act, begins_step, end_stage, failed, hold, standard
from .errors import CallbackError
from .files import one_at_a_time
from .memory import Header, block, matrix

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
        jacobian = matrix(mem, Header.JACOBIAN, 6, int(mem[Header.DOFS]))
        rotational = jacobian[3:] if mem[Header.ROTATES] == 1.0 else None
        mujoco.mj_jacSite(model, data, jacobian[:3], rotational, site)
        orientation = data.site_xmat[site].reshape(3, 3)
        act(mem, data.qpos, data.qvel, data.site_xpos[site], orientation, data.ctrl, command)
    if failed(mem):
        hold(data.qvel, data.ctrl, data.qfrc_bias, data.qfrc_passive)
    end_stage(mem, model.jnt_stiffness, model.qpos_spring)


@cache
def _compiled(command: Command = standard) -> Callable[..., Any]:
    """The control callback as a C function, compiled once and cached on disk."""
    llvmlite.binding.load_library_permanently(str(_libmujoco()))
    try:
        # Numba's cache is an index and numbered files: of two processes that write different laws
        # at once, one would later load the other's.
        with one_at_a_time(Path(__file__)):
            function = _compile(
                structs.MODEL_OFFSETS, structs.DATA_OFFSETS, _fingerprint(), command
            )
    except NumbaError as error:
        reason = str(error).strip().splitlines()
        raise CallbackError(
            "the law cannot be compiled, try --interpret to debug it: "
            + " ".join(line.strip() for line in reason[:3])
        ) from error
    return ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(function.address)


def _compile(
    model_offsets: tuple[int, ...], data_offsets: tuple[int, ...], sources: int, command: Command
) -> Any:
    """Compile the callback for one layout of mjModel and mjData.

    Numba keys its disk cache with the values that a function closes over. That the offsets and the
    fingerprint of all sources are among them is what makes a cached callback safe to reuse: another
    MuJoCo, or an edit in any file of the law, compiles anew.
    """
    jnt_stiffness, qpos_spring, nq, nv, nu, njnt, nuserdata = model_offsets
    userdata, qpos, qvel, ctrl, site_xpos, site_xmat, qfrc_bias, qfrc_passive = data_offsets

    @numba.cfunc(types.void(types.intp, types.intp), cache=True, error_model="numpy")
    def control(model: int, data: int) -> None:
        sources  # noqa: B018
        user = _doubles(_word(data, userdata), _word(model, nuserdata))
        mem = block(user)
        if mem.size == 0:
            return
        speed = _doubles(_word(data, qvel), _word(model, nv))
        motors = _doubles(_word(data, ctrl), _word(model, nu))
        if begins_step(mem):
            site = int(mem[Header.SITE])
            jacobian = matrix(mem, Header.JACOBIAN, 6, int(mem[Header.DOFS]))
            rotational = jacobian[3:].ctypes.data if mem[Header.ROTATES] == 1.0 else 0
            _mj_jacSite(model, data, jacobian.ctypes.data, rotational, site)
            position = _word(data, site_xpos) + 24 * site
            orientation = _pointer(_word(data, site_xmat) + 72 * site)
            act(
                mem,
                _doubles(_word(data, qpos), _word(model, nq)),
                speed,
                _doubles(position, 3),
                carray(orientation, (3, 3), np.float64),
                motors,
                command,
            )
        if failed(mem):
            hold(
                speed,
                motors,
                _doubles(_word(data, qfrc_bias), _word(model, nv)),
                _doubles(_word(data, qfrc_passive), _word(model, nv)),
            )
        end_stage(
            mem,
            _doubles(_word(model, jnt_stiffness), _word(model, njnt)),
            _doubles(_word(model, qpos_spring), _word(model, nq)),
        )

    return control


# Resolved by name when the compiled code is loaded: an address could not be cached on disk.
_mj_jacSite = types.ExternalFunction(  # noqa: N816
    "mj_jacSite",
    types.void(types.intp, types.intp, types.uintp, types.uintp, types.int32),
)


@intrinsic
def _pointer(typing_context: Any, address: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), generate


@numba.extending.register_jitable
def _word(address: int, offset: int) -> int:
    """The 8-byte integer or pointer at `address + offset`."""
    return carray(_pointer(address + offset), 1, np.intp)[0]


@numba.extending.register_jitable
def _doubles(address: int, size: int) -> np.ndarray:
    """View of `size` doubles at `address`."""
    return carray(_pointer(address), size, np.float64)


def _fingerprint() -> int:
    digest = hashlib.sha256()
    for module in (equations, springs, memory, controller):
        digest.update(Path(str(module.__file__)).read_bytes())
    return int.from_bytes(digest.digest()[:7], "big")


def _libmujoco() -> Path:
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll"):
        for path in sorted(folder.glob(pattern)):
            return path
    raise CallbackError(f"{folder}: no MuJoCo library was found there; reinstall mujoco")


def _pointer_in_libmujoco() -> int | None:
    library = ctypes.CDLL(str(_libmujoco()))
    return ctypes.c_void_p.in_dll(library, "mjcb_control").value
