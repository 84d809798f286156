"""Experiment files under test: those that hold [expect], found, read and held against the robot."""

import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ... import library
from ...errors import ExperimentError
from ...experiments.expectations import OfMotion
from ...experiments.experiment import Experiment
from ...experiments.loading import find, load
from ...text import listed, nearest, shown


def holds_expectations(path: Path) -> bool:
    """Whether a TOML file has a section [expect]; one that an edit has broken does by its text."""
    try:
        text = path.read_text(encoding="utf-8")
        return "expect" in tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return re.search(r"^\s*\[{1,2}\s*expect\b", text, re.MULTILINE) is not None
    except (OSError, UnicodeDecodeError):
        return False


def named(names: Sequence[str]) -> list[Path]:
    """The files that names, paths and folders stand for.

    Args:
        names: built-in names, TOML files, or folders, of which every TOML file with [expect] is
            meant. None at all mean those in the working folder and in its folder runs; where there
            are none either, those that come with the program.

    Raises:
        ExperimentError: there is no such file, or one holds no expectations.
    """
    if not names:
        here = [*_within(Path()), *_within(Path("runs"))]
        return here or [path for path in library.experiments().values() if holds_expectations(path)]
    files: list[Path] = []
    for name in names:
        if Path(name).is_dir():
            within = _within(Path(name))
            if not within:
                raise ExperimentError(f"{name}: no TOML file in this folder has a section [expect]")
            files += within
        else:
            files.append(find(name))
    return list(dict.fromkeys(files))


def _within(folder: Path) -> list[Path]:
    return [path for path in sorted(folder.glob("*.toml")) if holds_expectations(path)]


def read(path: str | os.PathLike[str], changes: Mapping[str, Any] | None = None) -> Experiment:
    """Load an experiment under test; its expectations fit its motions and its robot's joints.

    Raises:
        ExperimentError: the file is not valid, has no [expect], or expects something of a motion
            or a joint that is not there.
        RobotError: the robot cannot be loaded.
    """
    # MuJoCo is imported where an arm is built: a report judges without it.
    from ...robots.robot import build

    experiment = load(path).replace(changes or {})
    if not holds_expectations(find(path)):
        raise ExperimentError(
            f'{path}: has no section [expect], which says what to check; `stiffness = "optimal"` '
            "in it is enough"
        )
    fit(experiment, build(experiment).joints, str(path))
    return experiment


def fit(experiment: Experiment, joints: Sequence[str], source: str) -> None:
    """See that what is expected is of motions and joints that there are.

    Raises:
        ExperimentError: a list is not as long as it must be, or a joint does not exist.
    """
    motions, given = len(experiment.motion), len(experiment.expect.motion)
    if given not in (0, motions):
        raise ExperimentError(
            f"{source}: expect.motion has {given} tables, and there are {motions} motions: give a "
            "table [[expect.motion]] for each motion, in order, empty where nothing is expected"
        )
    tables: list[tuple[str, OfMotion]] = [("expect", experiment.expect)]
    tables += [(f"expect.motion.{i}", one) for i, one in enumerate(experiment.expect.motion)]
    each = [(f"{key}.{name}", one) for key, of in tables for name, one in of.figures().items()]
    for key, expected in each:
        unknown = next((name for name in expected.joints or () if name not in joints), None)
        if unknown is not None:
            raise ExperimentError(
                f"{source}: {key}.joints = {shown(expected.joints)}: {experiment.robot.mjcf} has "
                f"no joint {shown(unknown)} in its arm{nearest(unknown, joints)}; its joints are "
                f"{listed(joints)}"
            )
        meant = expected.joints or joints
        if isinstance(expected.value, tuple) and len(expected.value) != len(meant):
            raise ExperimentError(
                f"{source}: {key}.value = {shown(expected.value)}: {len(expected.value)} numbers "
                f"for {len(meant)} joints; give one for each of {listed(meant)}, or one for all"
            )
