"""The law as MuJoCo's control callback, compiled or interpreted.

`mjcb_control` is one pointer for the whole process. What it points to finds all that it needs in
the memory of the robot that is stepped, which command of a law included, so that threads with
compiled laws share it; one whose law is interpreted waits for its turn.
"""

import ctypes
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

import mujoco

from ..errors import CallbackError, ExperimentError
from ..laws import memory
from ..laws.adjusting import deviate
from ..laws.controller import (
    COMMANDS,
    Command,
    act,
    begins_step,
    end_stage,
    failed,
    hold,
    standard,
)
from ..laws.custom_law import custom, said
from ..laws.memory import Header
from ..laws.misjudging import misjudge
from ..laws.views import block, own
from ..step_functions import STEP_FUNCTIONS, keep_source
from ..turns import compiling
from .frozen import frozen

ACTING = ("control", "passive", "contactfilter", "act_dyn", "act_gain", "act_bias", "sensor")
"""MuJoCo's callbacks, mjcb_NAME, that change what is simulated."""

_turn = threading.Condition()
"""Held while one of these changes."""

_installed: Any = None
"""The function that is in place, of this package; None if none is."""

_users: list[int] = []
"""Threads that it is in place for, one as often as it has installed it."""

_waiting: list[object] = []
"""Those that wait for it to be removed, in the order in which they came."""

_compiling = threading.Lock()
"""Held while a law is compiled or loaded: threads that need the same one compile it once."""

_ready: dict[bytes, int] = {}
"""Addresses of this process's compiled functions by all that these depend on."""

_functions: dict[int, Callable[..., Any]] = {}
"""The control callback by its address: one object, whichever thread was first."""

_NESTED = (
    "a simulation of another law is running in this thread, and MuJoCo has one control callback "
    "for a process: start this one when it has ended"
)


@contextmanager
def installed(*, interpret: bool = False, command: Command = standard) -> Iterator[None]:
    """Install the control callback while the `with` block runs, and remove it after.

    Where another law of this package is in place, for another thread, this waits until its runs
    have ended; threads take turns in the order in which they came.

    Args:
        interpret: run the law as plain Python, for a debugger, instead of compiled.
        command: where it is interpreted the part of the control step that sets y and τ; compiled,
            the robots' memory has it: see `command_of`.

    Raises:
        CallbackError: a control callback of another program is installed, or this thread is itself
            in the middle of a run of another law.
    """
    global _installed
    refuse_foreign()
    function = partial(_interpreted, command) if interpret else _compiled()
    this = threading.get_ident()
    with _turn:
        if this not in _users:
            _wait_for_turn(function)
        elif function is not _installed:
            raise CallbackError(_NESTED)
        if not _users:
            refuse_foreign()
            if interpret:
                compiling.acquire()
            _installed = function
            mujoco.set_mjcb_control(function)
        _users.append(this)
    try:
        yield
    finally:
        with _turn:
            _users.remove(this)
            if not _users:
                mujoco.set_mjcb_control(None)
                _installed = None
                if interpret:
                    compiling.release()
                _turn.notify_all()


def stepping(
    model: mujoco.MjModel, data: mujoco.MjData, *, interpret: bool, command: Command
) -> Callable[[], None]:
    """The control callback as a function, for a model and data that MuJoCo does not step.

    Args:
        model: of the robot; its springs are written.
        data: with the controller's block, whose number `outside` is 1; `ctrl` is written.
        interpret: as of `installed`.
        command: as of `installed`.
    """
    if interpret:
        return partial(_interpreted, command, model, data)
    header = block(data.userdata)
    header[Header.COMMAND], header[Header.CUSTOM] = command_of(command)
    return partial(_compiled(), model._address, data._address)


def _wait_for_turn(function: Any) -> None:
    """Return when nobody uses another function and nobody came before who waits for that."""
    ticket = object()
    _waiting.append(ticket)
    try:
        while _waiting[0] is not ticket or (_users and function is not _installed):
            _turn.wait(1.0)  # now and then, so that an interrupt is heard wherever Python runs
    finally:
        _waiting.remove(ticket)
        _turn.notify_all()


def not_kept() -> str:
    """Why the compiled law is not on disk for other processes, in a line; empty if it is."""
    from . import machine_code

    return machine_code.not_kept()


def refuse_foreign() -> None:
    """Raise a CallbackError that names a callback which acts in this process and is not ours.

    MuJoCo calls some of them while it compiles a model: the robot's file is not to blame.
    """
    for name in ACTING:
        with _turn:
            ours = name == "control" and _users
            if ours and isinstance(_installed, partial) and threading.get_ident() in _users:
                raise CallbackError(_NESTED)
            if pointer(name) and not ours:
                raise CallbackError(
                    f"another callback, mjcb_{name}, is installed in this process and would act on "
                    f"the robot: remove it with mujoco.set_mjcb_{name}(None) before"
                )


def pointer(name: str) -> int | None:
    """Address of the callback mjcb_NAME that is installed, None for none."""
    return _pointer(name).value


@cache
def _pointer(name: str) -> ctypes.c_void_p:
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(_libmujoco())), f"mjcb_{name}")


@cache
def _libmujoco() -> Path:
    """MuJoCo's shared library."""
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll"):
        for path in sorted(folder.glob(pattern)):
            return path
    raise CallbackError(f"{folder}: no MuJoCo library was found there; reinstall mujoco")


def _interpreted(command: Command, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """The control callback as plain Python: the same functions that `_compiled` compiles."""
    mem = block(data.userdata)
    if mem.size == 0:
        return
    if begins_step(mem):
        seen = own(mem)
        if not seen.outside:
            rotational = seen.jacobian[3:] if seen.rotates or seen.misjudged else None
            mujoco.mj_jacSite(model, data, seen.jacobian[:3], rotational, seen.site)
        orientation = data.site_xmat[seen.site].reshape(3, 3)
        position = data.site_xpos[seen.site]
        if seen.misjudged:
            misjudge(mem, data.qpos, data.xanchor, position, orientation)
        try:
            act(mem, data.qpos, data.qvel, position, orientation, data.ctrl, command)
        except (Exception, SystemExit) as error:
            if (law := custom(command)) is None:
                raise
            file = law.__code__.co_filename
            raise ExperimentError(f"{file}: command raised {said(error, file)}") from error
    deviate(mem, data.qpos, data.qvel, model.jnt_stiffness, model.qpos_spring, data.qfrc_passive)
    if failed(mem):
        hold(data.qvel, data.ctrl, data.qfrc_bias, data.qfrc_passive)
    end_stage(mem, model.jnt_stiffness, model.qpos_spring, model.dof_damping)


def command_of(command: Command) -> tuple[int, int]:
    """What compiled code finds a command by: its number, and the address of a custom law's own.

    A custom command is compiled apart from the rest of the step, and kept on disk; one that reads
    what may change without a trace is compiled anew each time.

    Raises:
        ExperimentError: Numba cannot compile the command of a law's file.
    """
    if command in COMMANDS:
        return COMMANDS.index(command), 0

    def translate() -> tuple[str, str]:
        from . import compilation

        return compilation.translate_command(command)

    import numba

    # Compiling anything defines what a law needs that allocates or raises.
    numba.cfunc("void()")(lambda: None)
    depends_on = frozen(command)
    key = None if depends_on is None else _sources(command) + depends_on
    return len(COMMANDS), _loaded(key, translate)


@cache
def _compiled() -> Callable[..., Any]:
    """The control callback as a C function, compiled once and kept on disk."""
    import llvmlite.binding

    with compiling:
        from . import structs

    llvmlite.binding.load_library_permanently(str(_libmujoco()))
    layout = (structs.MODEL_OFFSETS, structs.DATA_OFFSETS)

    def translate() -> tuple[str, str]:
        from . import compilation

        return compilation.translate(*layout)

    address = _loaded(repr(layout).encode() + _sources(*COMMANDS), translate)
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(address)
    return _functions.setdefault(address, function)


def _loaded(key: bytes | None, translate: Callable[[], tuple[str, str]]) -> int:
    """Address of a function; see `machine_code.load`."""
    with compiling:
        from . import machine_code
    with _compiling:
        if key in _ready:
            return _ready[key]
        address = machine_code.load(key, translate)
        if key is not None:
            _ready[key] = address
        return address


def _sources(*commands: Command) -> bytes:
    """All source code that control steps are made of, as it was imported."""
    folder = Path(__file__).parent
    files = {str(folder / "compilation.py"), str(folder / "compiled_views.py"), memory.__file__}
    files |= {function.__code__.co_filename for function in (*STEP_FUNCTIONS, *commands)}
    return b"".join(map(keep_source, sorted(files)))
