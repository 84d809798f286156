"""Runs that have been simulated before, in memory and on disk, for tests that share them."""

from __future__ import annotations

import hashlib
import os
import shutil
import uuid
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import fields, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from ...errors import OutputError, ResonanceError
from ...experiments.expectations import Expect
from ...experiments.experiment import Experiment
from ...laws.laws import LAWS
from ...results.run import Run, versions
from ...robots.robot import build
from ...simulation.simulation import simulate

KEPT = 20
"""Runs that stay on disk, the last used of them."""

PACKAGE = Path(__file__).parents[2]
"""The sources that make a run."""


class RunCache:
    """Simulates an experiment once, for all processes that share a folder.

    A run is found again if nothing that it depends on has changed: see `fingerprint`. What a law of
    a user's file reads and imports is not known, and its runs are always made anew. Processes may
    read, write and clear the folder at the same time: a run takes its name when it is complete, and
    one that vanishes, or is not what was written, is simulated again.

    Args:
        folder: where runs are kept; None for in memory alone.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._known: dict[str, Run] = {}

    def run(self, experiment: Experiment) -> Run:
        """The run of an experiment, with its expectations and with data of its own.

        Raises:
            ResonanceError: the experiment cannot be simulated.
        """
        if experiment.law.kind not in LAWS:
            return simulate(experiment)
        key = fingerprint(experiment)
        found = self._known.get(key) or self._load(key)
        if found is None:
            found = simulate(experiment)
            if fingerprint(experiment) != key:  # A file was written meanwhile.
                return found
            self._keep(found, key)
        self._known[key] = found
        mine = {"name": experiment.name, "expect": experiment.expect}
        return replace(
            found,
            experiment=found.experiment.model_copy(update=mine),
            data=found.data.copy(deep=True),
        )

    def _load(self, key: str) -> Run | None:
        if self._folder is None:
            return None
        with suppress(ResonanceError, OSError):
            run = Run.load(self._folder / key)
            if run.experiment.name == key:
                os.utime(self._folder / key)
                return run
        return None

    def _keep(self, run: Run, key: str) -> None:
        if self._folder is None:
            return
        beside = self._folder / f"{uuid.uuid4().hex}.tmp"
        try:
            # Under the seal of its file the run has its key as its name.
            named = run.experiment.model_copy(update={"name": key})
            replace(run, experiment=named).save(beside)
            # What could not be read is in the way; a run that another process put there stays.
            if self._load(key) is None:
                shutil.rmtree(self._folder / key, ignore_errors=True)
                with suppress(OSError):
                    beside.rename(self._folder / key)
            self._forget()
        except (OutputError, OSError):
            pass  # a folder that cannot be written costs time, and no test
        finally:
            shutil.rmtree(beside, ignore_errors=True)

    def _forget(self) -> None:
        """Delete all runs but the last used."""
        assert self._folder is not None
        used = {}
        for path in self._folder.iterdir():
            if path.suffix != ".tmp":
                with suppress(OSError):
                    used[path] = path.stat().st_mtime
        for path in sorted(used, key=lambda path: used[path], reverse=True)[KEPT:]:
            shutil.rmtree(path, ignore_errors=True)


def fingerprint(experiment: Experiment) -> str:
    """A name for everything that the run of an experiment depends on.

    That is the experiment, the arm as it is simulated, which all its files and keyframes have gone
    into, the files of its motions, this package's sources, what the environment tells Numba, and
    the versions of what the run is computed with.
    """
    digest = hashlib.sha256()
    for part in _parts(experiment):
        digest.update(len(part).to_bytes(8, "big") + part)
    return digest.hexdigest()[:32]


def _parts(experiment: Experiment) -> Iterator[bytes]:
    bare = experiment.model_copy(update={"name": "run", "expect": Expect()})
    yield bare.to_toml().encode()
    told = {name: value for name, value in os.environ.items() if name.startswith("NUMBA_")}
    yield repr(sorted((versions() | {"scipy": version("scipy")} | told).items())).encode()
    robot = build(experiment)
    for field in fields(robot):
        yield field.name.encode()
        yield _as_bytes(getattr(robot, field.name))
    named = [Path(motion.file) for motion in experiment.motion if motion.file]
    for path in filter(Path.is_file, [*named, *sorted(PACKAGE.rglob("*.py"))]):
        yield str(path).encode()
        yield path.read_bytes()


def _as_bytes(value: Any) -> bytes:
    if isinstance(value, mujoco.MjModel):
        compiled = np.empty(mujoco.mj_sizeModel(value), np.uint8)
        mujoco.mj_saveModel(value, None, compiled)
        return compiled.tobytes()
    return value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode()
