"""A law from outside: a Python file named in the experiment, run through the same callback."""

import importlib
import inspect
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import ExperimentError
from ..experiments.experiment import Experiment
from ..experiments.law_section import KINDS
from ..files import read_text
from ..springs.fit import SPRINGS, LinearSprings
from ..text import cut, listed, one_line
from .controller import Command, standard
from .gains import Gains
from .learning import Cycle, Learn, Learned
from .views import own as views

COMMAND = ("J", "error", "rate", "q", "dq", "u", "parameters", "y", "tau")
"""Arguments of a custom law's `command`, which is compiled and fills y and tau at each step."""

LEARN = ("u", "y", "q", "stiffness", "offset", "center", "parameters", "bounds")
"""What a custom law's `learn` may take, by name; it returns u, stiffness, offset, center."""

_executing = threading.Lock()
"""Held while a law's file is executed: modules are the whole process's."""


def source_of(file: str) -> str:
    """The text of a law's file, of which nothing is executed.

    Raises:
        ExperimentError: there is no such file.
    """
    needed = f"give {', '.join(KINDS)}, or the path of a Python file with a function `command` or "
    return read_text(file, f"law.kind = {file!r}", f"{needed}`learn`")


def load(file: str, source: str) -> tuple[Command, Learn | None]:
    """Execute a law's file: each time anew, so that an edit counts.

    Args:
        file: its path.
        source: its text.

    Returns:
        The control step's part that sets y and τ, the transfer law's where the file has none; and
        what happens between two cycles, or None.

    Raises:
        ExperimentError: it cannot be executed, or its functions are not of the documented shape.
    """
    module = _executed(Path(file), source)
    command, learn = (getattr(module, name, None) for name in ("command", "learn"))
    if command is None and learn is None:
        raise ExperimentError(f"{file}: defines neither `command` nor `learn`; one is needed")
    if command is not None and (found := _arguments(file, "command", command)) != COMMAND:
        raise ExperimentError(
            f"{file}: command({', '.join(found)}): its arguments must be ({', '.join(COMMAND)})"
        )
    if learn is not None and (unknown := set(_arguments(file, "learn", learn)) - set(LEARN)):
        raise ExperimentError(
            f"{file}: learn has the argument {min(unknown)!r}; it may have {', '.join(LEARN)}"
        )

    def learned(cycle: Cycle, gains: Gains, experiment: Experiment) -> Learned:
        assert learn is not None
        return _learned(file, learn, cycle, gains, experiment)

    return standard if command is None else _adapted(command), learned if learn else None


def _learned(
    file: str, learn: Callable[..., Any], cycle: Cycle, gains: Gains, experiment: Experiment
) -> Learned:
    """What a file's `learn` returns for copies of a cycle's signals; refused if it is no good."""
    given = {name: getattr(cycle, name).copy() for name in ("u", "y", "q")}
    given |= {name: getattr(cycle.springs, name).copy() for name in SPRINGS}
    given |= {"parameters": np.array(experiment.law.parameters), "bounds": gains.bounds}
    names = inspect.signature(learn).parameters
    try:
        found = tuple(np.asarray(part, float) for part in learn(**{n: given[n] for n in names}))
    except (Exception, SystemExit) as error:
        raise ExperimentError(f"{file}: learn raised {said(error, file)}") from error
    wanted = [cycle.u.shape, *(given[name].shape for name in SPRINGS)]
    shapes = [part.shape for part in found]
    if shapes != wanted or not all(np.isfinite(part).all() for part in found):
        raise ExperimentError(
            f"{file}: learn returned {listed(map(str, shapes), 'nothing')}"
            f"{'' if shapes != wanted else ' with numbers that are not finite'}; finite u, "
            f"stiffness, offset, center of shapes {listed(map(str, wanted))} are needed"
        )
    u, *springs = found
    k, offset, center = springs
    return Learned(u, LinearSprings(k, offset, center, cycle.springs.others))


def _executed(path: Path, source: str) -> ModuleType:
    module = ModuleType(f"resonance_mj_law_{path.stem}")
    module.__file__ = str(path)
    try:
        with _executing, _fresh_modules(path.resolve().parent):
            exec(compile(source, str(path), "exec"), vars(module))
    except (Exception, SystemExit) as error:
        raise ExperimentError(f"{path}: cannot be executed: {said(error, str(path))}") from error
    return module


@contextmanager
def _fresh_modules(folder: Path) -> Iterator[None]:
    """Let what stands in a folder be imported, and anew; the process keeps what it had of it."""
    here = {each.stem for each in folder.iterdir()} - sys.stdlib_module_names

    def inside() -> dict[str, ModuleType]:
        modules = sys.modules.copy()
        files = {name: getattr(module, "__file__", None) for name, module in modules.items()}
        del files["__main__"]
        return {
            name: modules[name]
            for name, file in files.items()
            # One of that name which was imported from elsewhere is not meant.
            if name.partition(".")[0] in here or (file and Path(file).parent == folder)
        }

    before, path = inside(), list(sys.path)
    settings = sys.dont_write_bytecode, sys.pycache_prefix
    for name in before:
        del sys.modules[name]
    sys.path.insert(0, str(folder))
    # Bytecode is of this source only to the second.
    sys.dont_write_bytecode, sys.pycache_prefix = True, str(folder / "no-bytecode")
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path[:] = path
        sys.dont_write_bytecode, sys.pycache_prefix = settings
        for name in inside():
            del sys.modules[name]
        sys.modules.update(before)


def custom(command: Command) -> Callable[..., None] | None:
    """The function of a law's file that a command runs; None for the package's own commands."""
    cells = command.__closure__
    return cells[0].cell_contents if cells else None


def said(error: BaseException, file: str) -> str:
    """An error of a user's code in a line, with the line of the file where it is known."""
    line = getattr(error, "lineno", None) if isinstance(error, SyntaxError) else None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    at = f" in line {line}" if line else ""
    return f"{cut(one_line(f'{type(error).__name__}: {error}'), 300)}{at}"


def _arguments(file: str, name: str, function: object) -> tuple[str, ...]:
    if not inspect.isfunction(function):
        raise ExperimentError(f"{file}: {name} is {cut(repr(function))}; a function is needed")
    if inspect.isgeneratorfunction(function) or inspect.iscoroutinefunction(function):
        raise ExperimentError(f"{file}: {name} yields or awaits; a plain function is needed")
    return tuple(inspect.signature(function).parameters)


def _adapted(custom: Callable[..., None]) -> Command:
    """A custom `command` as the control step calls it."""

    def command(memory: np.ndarray) -> None:
        own = views(memory)
        for j in range(own.n):
            own.q[j], own.dq[j] = own.angle[j], own.speed[j]
        custom(
            own.J, own.error, own.rate, own.q, own.dq, own.learned, own.parameters, own.y, own.tau
        )

    return command
