"""The files that an experiment names: a run's folder keeps copies, so that it can be sent."""

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from .. import library
from ..experiments.experiment import Experiment
from ..robots import mjcf, source


class Input(NamedTuple):
    """A file that a run depends on."""

    name: str
    """Its path within the run's folder of inputs."""
    path: Path
    """Where it is."""
    digest: str
    """SHA-256 of its contents when the run was planned."""
    key: str = ""
    """The key of the experiment that names it; empty for what another file refers to."""

    @property
    def unchanged(self) -> bool:
        """Whether the file is still there and as it was."""
        return self.path.is_file() and digest(self.path) == self.digest


def gather(experiment: Experiment) -> tuple[Input, ...]:
    """The files that an experiment depends on: its robot's, the MJCF first, law and waypoints.

    A robot that comes with the program is known by its name and the program's version.

    Raises:
        RobotError: the robot's file is missing, or MuJoCo rejects it.
    """
    path = mjcf.find(experiment.robot.mjcf)
    built_in = path in library.robots().values()
    robot = [] if built_in else source.files(path, experiment.robot.packages)
    root = os.path.commonpath([file.parent for file in robot]) if robot else ""
    keys = ["robot.mjcf", *[""] * len(robot)]
    named = [
        (file.relative_to(root).as_posix(), file, key)
        for file, key in zip(robot, keys, strict=False)
    ]
    others = {f"motion.{i}.file": motion.file for i, motion in enumerate(experiment.motion)}
    law = experiment.law.kind
    for key, given in {"law.kind": law if law.endswith(".py") else None, **others}.items():
        if given:
            name = f"{key.rpartition('.')[0]}-{Path(given).name}"
            named.append((name, Path(given).absolute(), key))
    return tuple(Input(name, path, digest(path), key) for name, path, key in named)


def folder_name(inputs: Iterable[Input]) -> str:
    """The name of the folder that these files are kept in: another for other contents."""
    text = "".join(f"{one.name}\0{one.digest}\0" for one in inputs)
    return f"inputs-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def digest(path: Path) -> str:
    """SHA-256 of a file's contents."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
