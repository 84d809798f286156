"""The law as MuJoCo's control callback, compiled or interpreted.

`mjcb_control` is one pointer for the whole process: `installed` sets it for the length of a `with`
block, and refuses where another callback is in place.
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
from ..laws.controller import Command, act, begins_step, end_stage, failed, hold, standard
from ..laws.custom_law import custom, said
from ..laws.views import block, own
from ..step_functions import STEP_FUNCTIONS
from .frozen import frozen

ACTING = ("control", "passive", "contactfilter", "act_dyn", "act_gain", "act_bias", "sensor")
"""MuJoCo's callbacks, mjcb_NAME, that change what is simulated."""

_installing = threading.Lock()
"""Held while this package's own control callback is installed."""

_ready: dict[bytes, Any] = {}
"""Compiled callbacks of this process by all that they depend on."""

_BUSY = (
    "a simulation is already running in this process, and MuJoCo has one control callback per "
    "process: run them one after the other, together with simulate_many, or in processes of their "
    "own"
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
    refuse_another()
    function = partial(_interpreted, command) if interpret else _compiled(command)
    if not _installing.acquire(blocking=False):
        raise CallbackError(_BUSY)
    try:
        mujoco.set_mjcb_control(function)
        yield
    finally:
        mujoco.set_mjcb_control(None)
        _installing.release()


def refuse_another() -> None:
    """Raise a CallbackError if a callback is in place, this package's or another.

    Checked before a robot is loaded, because MuJoCo calls them while it compiles a model.
    """
    if _installing.locked():
        raise CallbackError(_BUSY)
    refuse_foreign()


def refuse_foreign() -> None:
    """Raise a CallbackError that names a callback which acts in this process and is not ours.

    MuJoCo calls some of them while it compiles a model: the robot's file is not to blame.
    """
    for name in ACTING:
        if pointer(name) and not (name == "control" and _installing.locked()):
            raise CallbackError(
                f"another callback, mjcb_{name}, is installed in this process and would act on the "
                f"robot: remove it with mujoco.set_mjcb_{name}(None) before"
            )


def pointer(name: str) -> int | None:
    """Address of the callback mjcb_NAME that is installed, None for none."""
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(_libmujoco())), f"mjcb_{name}").value


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
        rotational = seen.jacobian[3:] if seen.rotates else None
        mujoco.mj_jacSite(model, data, seen.jacobian[:3], rotational, seen.site)
        orientation = data.site_xmat[seen.site].reshape(3, 3)
        position = data.site_xpos[seen.site]
        try:
            act(mem, data.qpos, data.qvel, position, orientation, data.ctrl, command)
        except (Exception, SystemExit) as error:
            if (law := custom(command)) is None:
                raise
            file = law.__code__.co_filename
            raise ExperimentError(f"{file}: command raised {said(error, file)}") from error
    if failed(mem):
        hold(data.qvel, data.ctrl, data.qfrc_bias, data.qfrc_passive)
    end_stage(mem, model.jnt_stiffness, model.qpos_spring)


def _compiled(command: Command = standard) -> Callable[..., Any]:
    """The control callback as a C function, compiled once and kept on disk.

    A command that reads what may change without a trace is compiled anew each time.
    """
    import llvmlite.binding

    if custom(command):
        import numba

        # Compiling anything defines what a law needs that allocates or raises.
        numba.cfunc("void()")(lambda: None)

    from . import machine_code, structs

    llvmlite.binding.load_library_permanently(str(_libmujoco()))
    layout = (structs.MODEL_OFFSETS, structs.DATA_OFFSETS)

    def translate() -> tuple[str, str]:
        from . import compilation

        return compilation.translate(*layout, command)

    depends_on = frozen(command)
    key = None if depends_on is None else repr(layout).encode() + _sources(command) + depends_on
    if key in _ready:
        return _ready[key]
    address = machine_code.load(key, translate)
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(address)
    if key is not None:
        _ready[key] = function
    return function


def _sources(command: Command) -> bytes:
    """All source code that the callback is made of: an edit in any of its files compiles anew."""
    folder = Path(__file__).parent
    files = {str(folder / "compilation.py"), str(folder / "compiled_views.py"), memory.__file__}
    files |= {function.__code__.co_filename for function in (*STEP_FUNCTIONS, command)}
    return b"".join(Path(file).read_bytes() for file in sorted(files))
