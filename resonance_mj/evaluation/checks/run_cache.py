"""Runs that have been simulated before, in memory and on disk, for tests that share them."""

from __future__ import annotations

import hashlib
import os
import shutil
import uuid
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from ...errors import OutputError, ResonanceError
from ...experiments.expectations import Expect
from ...experiments.experiment import Experiment
from ...results.run import Run, versions
from ...robots.robot import build
from ...simulation.simulation import simulate

KEPT = 20
"""Runs that stay on disk, the last used of them."""


class RunCache:
    """Simulates an experiment once, for all processes that share a folder.

    A run is found again if nothing that it depends on has changed: the experiment, the compiled
    model with its meshes, the files that the experiment names, this package's sources, and the
    versions of what it computes with. Processes may read, write and clear the folder at the same
    time: a run takes its name when it is complete, and one that vanishes is simulated again.

    Args:
        folder: where runs are kept; None for in memory alone.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._known: dict[str, Run] = {}

    def run(self, experiment: Experiment) -> Run:
        """The run of an experiment, with its expectations.

        Raises:
            ResonanceError: the experiment cannot be simulated.
        """
        key = fingerprint(experiment)
        if key not in self._known:
            self._known[key] = self._load(key) or self._simulate(experiment, key)
        found = self._known[key]
        mine = {"name": experiment.name, "expect": experiment.expect}
        return replace(found, experiment=found.experiment.model_copy(update=mine))

    def _load(self, key: str) -> Run | None:
        if self._folder is None:
            return None
        with suppress(ResonanceError, OSError):
            run = Run.load(self._folder / key)
            os.utime(self._folder / key)
            return run
        return None

    def _simulate(self, experiment: Experiment, key: str) -> Run:
        run = simulate(experiment)
        if self._folder is not None:
            beside = self._folder / f"{uuid.uuid4().hex}.tmp"
            try:
                run.save(beside)
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
        return run

    def _forget(self) -> None:
        """Delete all runs but the last used."""
        assert self._folder is not None
        runs = [path for path in self._folder.iterdir() if path.suffix != ".tmp"]
        used = {}
        for path in runs:
            with suppress(OSError):
                used[path] = path.stat().st_mtime
        for path in sorted(used, key=lambda path: used[path], reverse=True)[KEPT:]:
            shutil.rmtree(path, ignore_errors=True)


def fingerprint(experiment: Experiment) -> str:
    """A name for everything that the run of an experiment depends on."""
    digest = hashlib.sha256()
    bare = experiment.model_copy(update={"name": "run", "expect": Expect()})
    digest.update(bare.to_toml().encode())
    digest.update(repr(sorted(versions().items())).encode())
    model = build(experiment).model
    compiled = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, compiled)
    digest.update(compiled.tobytes())
    named = [experiment.law.kind, *(motion.file for motion in experiment.motion)]
    files = [Path(name) for name in named if name and Path(name).is_file()]
    for path in [*files, *sorted(Path(__file__).parents[1].rglob("*.py"))]:
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:32]
