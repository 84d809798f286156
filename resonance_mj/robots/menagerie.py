"""Arms of MuJoCo Menagerie by name, through its own package, which downloads them on first use."""

import difflib
import os
from importlib import import_module
from pathlib import Path
from types import ModuleType

from ..errors import RobotError

PREFIX = "menagerie:"
"""What a robot's name in the Menagerie begins with."""

ARMS = ("arm", "dual_arm")
"""Categories of the Menagerie that hold arms."""


def find(name: str) -> Path:
    """The MJCF file of a robot of the Menagerie, without a scene around it.

    The package looks in the folder MENAGERIE_ROOT where that is set, else in its own cache, into
    which it downloads what is missing.

    Args:
        name: `menagerie:NAME`, or `menagerie:NAME/MODEL` for another than the default model.

    Raises:
        RobotError: the package is not installed, it has no such robot, or it cannot be downloaded.
    """
    where = f"robot.mjcf = {name!r}"
    package = _package(where)
    robot_name, slash, model = name.removeprefix(PREFIX).partition("/")
    if robot_name not in package.names():
        raise RobotError(f"{where}: {_unknown(robot_name, package)}")
    robot = package.get(robot_name)
    if not slash:
        model = robot.default_model
    elif model not in robot.entry_names:
        raise RobotError(
            f"{where}: {robot_name} has no model {model!r}; it has {', '.join(robot.entry_names)}"
        )
    root = os.environ.get("MENAGERIE_ROOT")
    try:
        path = Path(robot.xml(model))
    except (package.MenagerieError, OSError) as error:
        raise RobotError(f"{where}: {_unavailable(robot_name, root, error)}") from None
    if not path.is_file():
        raise RobotError(
            f"{where}: {path}: no such file; "
            + (
                f"set MENAGERIE_ROOT to a checkout of mujoco_menagerie, not {root!r}"
                if root
                else f"delete {path.parent} to download it again"
            )
        )
    return path


def _package(where: str) -> ModuleType:
    try:
        return import_module("mujoco_menagerie")
    except ImportError:
        raise RobotError(
            f"{where}: robots of the Menagerie need the package mujoco-menagerie: "
            'pip install "resonance-mj[menagerie]"'
        ) from None


def _unknown(name: str, package: ModuleType) -> str:
    names = package.names()
    close = [one for one in names if name in one] or difflib.get_close_matches(name, names)
    close = close[:3] if name else []
    hint = f" (did you mean {' or '.join(map(repr, close))}?)" if close else ""
    arms = [robot.name for category in ARMS for robot in package.robots(category)]
    return f"no robot of the Menagerie is called {name!r}{hint}; its arms are {', '.join(arms)}"


def _unavailable(name: str, root: str | None, error: Exception) -> str:
    reason = " ".join(str(error).split()) or type(error).__name__
    if root:
        return f"{reason}; it must be the folder that holds {name}/, or unset to download it"
    return (
        f"cannot be downloaded: {reason}; with a local copy of mujoco_menagerie, set "
        f"MENAGERIE_ROOT to the folder that holds {name}/"
    )
