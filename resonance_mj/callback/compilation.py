"""The control callback, and the commands of laws' files, translated by Numba."""

from collections.abc import Callable
from types import FunctionType
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import carray, types
from numba.core import cgutils
from numba.core.errors import NumbaError
from numba.extending import intrinsic, register_jitable

from ..errors import ExperimentError
from ..laws.adjusting import deviate
from ..laws.controller import (
    Command,
    act,
    begins_step,
    end_stage,
    failed,
    hold,
    joint_space,
    joint_task,
    standard,
)
from ..laws.custom_law import custom
from ..laws.memory import Header
from ..laws.misjudging import misjudge
from ..laws.views import block, own, row
from ..step_functions import STEP_FUNCTIONS
from ..text import cut
from . import compiled_views  # noqa: F401  so that Numba knows the views
from .frozen import globals_read


def translate(model_offsets: tuple[int, ...], data_offsets: tuple[int, ...]) -> tuple[str, str]:
    """The callback in LLVM's language.

    Args:
        model_offsets: of `structs.MODEL_FIELDS` in mjModel [bytes].
        data_offsets: of `structs.DATA_FIELDS` in mjData [bytes].

    Returns:
        The text, and the name of the C function in it: `void (mjModel *, mjData *)`.
    """
    _register()
    jnt_stiffness, qpos_spring, dof_damping, nq, nv, nu, njnt, nuserdata = model_offsets
    userdata, qpos, qvel, ctrl, *place_of, qfrc_bias, qfrc_passive = data_offsets
    site_xpos, site_xmat, xanchor = place_of

    def control(model: int, data: int) -> None:
        user = _doubles(_word(data, userdata), _word(model, nuserdata))
        mem = block(user)
        if mem.size == 0:
            return
        speed = _doubles(_word(data, qvel), _word(model, nv))
        motors = _doubles(_word(data, ctrl), _word(model, nu))
        if begins_step(mem):
            seen = own(mem)
            if not seen.outside:
                turns = seen.rotates or seen.misjudged
                rotational = seen.jacobian[3:].ctypes.data if turns else 0
                _mj_jacSite(model, data, seen.jacobian.ctypes.data, rotational, seen.site)
            position = _doubles(_word(data, site_xpos) + 24 * seen.site, 3)
            address = _pointer(_word(data, site_xmat) + 72 * seen.site)
            orientation = carray(address, (3, 3), np.float64)
            place = _doubles(_word(data, qpos), _word(model, nq))
            if seen.misjudged:
                joints = _word(model, njnt), 3
                anchor = carray(_pointer(_word(data, xanchor)), joints, np.float64)
                misjudge(mem, place, anchor, position, orientation)
            act(mem, place, speed, position, orientation, motors, _command)
        place = _doubles(_word(data, qpos), _word(model, nq))
        stiffness = _doubles(_word(model, jnt_stiffness), _word(model, njnt))
        rest = _doubles(_word(model, qpos_spring), _word(model, nq))
        passive = _doubles(_word(data, qfrc_passive), _word(model, nv))
        deviate(mem, place, speed, stiffness, rest, passive)
        if failed(mem):
            hold(speed, motors, _doubles(_word(data, qfrc_bias), _word(model, nv)), passive)
        end_stage(mem, stiffness, rest, _doubles(_word(model, dof_damping), _word(model, nv)))

    compiled = numba.cfunc(_SIGNATURE, error_model="numpy")(control)
    return compiled.inspect_llvm(), compiled.native_name


def translate_command(command: Command) -> tuple[str, str]:
    """The command of a law's file in LLVM's language.

    Returns:
        The text, and the name of the C function in it: `void (double *memory, intp_t size)`.

    Raises:
        ExperimentError: Numba cannot compile it.
    """
    law = custom(command)
    assert law is not None
    _register()
    guarded = _guarded(command, law)

    def act_on(memory: int, size: int) -> None:
        guarded(_doubles(memory, size))

    try:
        compiled = numba.cfunc(_SIGNATURE, error_model="numpy")(act_on)
    except Exception as error:
        raise ExperimentError(
            f"{law.__code__.co_filename}: command cannot be compiled: {_reason(law, error)}; "
            "--interpret runs it as plain Python"
        ) from error
    return compiled.inspect_llvm(), compiled.native_name


@register_jitable
def _command(memory: np.ndarray) -> None:
    """Set y and τ by the command whose number is in the memory."""
    number = memory[Header.COMMAND]
    if number == 0.0:
        standard(memory)
    elif number == 1.0:
        joint_task(memory)
    elif number == 2.0:
        joint_space(memory)
    else:
        _call(int(memory[Header.CUSTOM]), memory.ctypes.data, memory.size)


def _register() -> None:
    """Let compiled code call the step functions."""
    for function in STEP_FUNCTIONS:
        # What makes a row is inlined, so that a view that is not used costs nothing.
        register_jitable(forceinline=function is row)(function)


def _guarded(command: Command, law: Callable[..., None]) -> Command:
    """A custom command that fails the run where it raises an exception or leaves an array."""
    register_jitable(command)
    for function in _reached(law, {}):
        register_jitable(boundscheck=True)(function)

    @register_jitable
    def guarded(memory: np.ndarray) -> None:
        try:
            command(memory)
        except Exception:
            memory[Header.FAILED_STEP] = memory[Header.STEP] + 1.0
            memory[Header.FAILED_JOINT] = -1.0

    return guarded


def _reached(function: Any, found: dict[Any, None]) -> dict[Any, None]:
    """A function and those that it calls by their names, but for this package's."""
    if isinstance(function, FunctionType) and function not in (*found, *STEP_FUNCTIONS):
        found[function] = None
        for called in globals_read(function).values():
            _reached(called, found)
    return found


def _reason(law: Callable[..., None], error: Exception) -> str:
    """Why Numba cannot compile a law: what it says of the law alone, if it does, with the line."""
    vector = numba.float64[::1]
    try:
        numba.njit((numba.float64[:, ::1], *[vector] * 8), error_model="numpy")(law)
    except Exception as alone:
        error = alone
    said = str(error)
    if isinstance(error, NumbaError):
        said = said.partition("\n")[2] or said  # the first line names a pass of the compiler
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    reason = " ".join(lines[: 2 if lines and lines[0].endswith(":") else 1])
    line = getattr(getattr(error, "loc", None), "line", None)
    at = f" in line {line}" if line else ""
    return f"{cut(reason or type(error).__name__, 300)}{at}"


# Resolved by name when the machine code is loaded: an address could not be kept on disk.
_mj_jacSite = types.ExternalFunction(  # noqa: N816
    "mj_jacSite", types.void(types.intp, types.intp, types.uintp, types.uintp, types.int32)
)


_SIGNATURE = types.void(types.intp, types.intp)


@intrinsic
def _call(typing_context: Any, function: Any, memory: Any, size: Any) -> Any:
    """Call the C function at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = context.get_value_type(types.intp)
        kind = ir.FunctionType(ir.VoidType(), [word, word])
        address = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(address, arguments[1:])
        return context.get_dummy_value()

    return types.void(types.intp, types.uintp, types.intp), generate


@intrinsic
def _pointer(typing_context: Any, address: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), generate


@register_jitable
def _word(address: int, offset: int) -> int:
    """The 8-byte integer or pointer at `address + offset`."""
    return carray(_pointer(address + offset), 1, np.intp)[0]


@register_jitable
def _doubles(address: int, size: int) -> np.ndarray:
    """View of `size` doubles at `address`."""
    return carray(_pointer(address), size, np.float64)
