"""A sweep: many experiments in shards, each on disk before it counts, and one dataset of all."""

import csv
import hashlib
import io
import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import xarray as xr

from ..callback.callback import refuse_foreign
from ..claim import CLAIM, claimed
from ..errors import ExperimentError, OutputError, ResonanceError
from ..experiments.effects import refuse_idle
from ..experiments.experiment import Experiment
from ..experiments.sweeping import Sweep, load_sweep, of_values
from ..files import write
from ..plan.inputs import gather
from ..plan.plan import Followed
from ..progress import Asked, Progress, progressing
from ..results.run import versions
from . import dataset
from .cluster import spread
from .dataset import SETTINGS, TABLE, WHOLE, Outcome
from .shards import simulated

SHARD = 16
"""Experiments that are simulated together and kept together."""

REMEMBERED = 500
"""Arms, joint motions and optima that experiments of a sweep may have in common."""


def sweep(
    given: str | os.PathLike[str] | Experiment,
    keys: Mapping[str, Any] | None = None,
    *,
    how: str = "grid",
    count: int | None = None,
    method: str = "sobol",
    seed: int = 0,
    folder: str | os.PathLike[str] | None = None,
    threads: int = 0,
    dask: str | None = None,
    yes: bool = False,
    progress: Asked = None,
) -> xr.Dataset:
    """Simulate an experiment with many values of some of its keys.

    With a folder, each 16 experiments are written as they are finished: a sweep that was
    interrupted, in any way, goes on there with the same call, and ends with the same bits.

    Args:
        given: a sweep's TOML file, or an experiment (or its name) whose keys are varied.
        keys: of an experiment: a list of values of each, or a range
            {"from": 1, "to": 10, "count": 4, "scale": "log"}.
        how: grid, zip or sample.
        count: experiments of a sample.
        method: of a sample, sobol or random.
        seed: of a sample.
        folder: where shards and the result are written; nothing is if None.
        threads: how many to simulate with; 0 for all cores.
        dask: address of a Dask scheduler whose workers simulate in their place, such as
            tcp://host:8786, or local:N for N workers on this machine.
        yes: allow a grid of more than a million experiments.
        progress: called as experiments are done with how many are, how many there are, and how many
            of those done are not ok; a bar in a terminal or a notebook if not given, nothing for
            False.

    Returns:
        Dimensions named after the keys of a grid, else `run`; motion, joint and cycle. Per motion
        the figures of the last cycle beside the optimum's, per cycle torque² and tracking error;
        the status of each run, "refused" with the reason for one that could not begin.

    Raises:
        ExperimentError: a key or a value is not valid.
        OutputError: the folder cannot be written, or is of another sweep.
        ClusterError: the Dask cluster cannot be reached, is lost, or has other versions.
    """
    refuse_foreign()
    base = given if isinstance(given, Experiment) else None
    name = given.name if isinstance(given, Experiment) else os.fspath(given)
    if keys is None and base is not None:
        raise ExperimentError(f"sweep of {name}: keys are missing: which values to try")
    if keys is None:
        settings = load_sweep(name)
    else:
        values: dict[str, Any] = {"experiment": name, "keys": dict(keys), "how": how}
        values |= {"method": method, "seed": seed, "count": count}
        settings = of_values(Sweep, values, f"sweep of {name}")
    experiments = settings.experiments(base, yes=yes)
    refuse_idle(experiments, settings.keys, f"sweep of {name}")
    with (
        claimed(folder) if folder else nullcontext() as at,
        progressing(progress, f"sweep of {settings.experiment}", "runs") as show,
    ):
        return _swept(settings, experiments, at, threads, dask, show)


def _swept(
    settings: Sweep,
    experiments: Sequence[Experiment],
    folder: Path | None,
    threads: int,
    dask: str | None,
    progress: Progress,
) -> xr.Dataset:
    shards = [experiments[i : i + SHARD] for i in range(0, len(experiments), SHARD)]
    made = Made()
    names = [made.name(shard) for shard in shards]
    whole = hashlib.sha256("".join(names).encode()).hexdigest()
    if folder is not None:
        claim(folder, settings.model_dump(mode="json", by_alias=True), experiments)
        if (found := _finished(folder, whole)) is not None:
            shutil.rmtree(folder / "shards", ignore_errors=True)
            return found
    made_of = dict(zip(names, shards, strict=True))
    kept = {} if folder is None else _kept(folder, names)
    missing = {name: shard for name, shard in made_of.items() if name not in kept}
    bad = 0

    def count(outcomes: list[Outcome]) -> None:
        nonlocal bad
        bad += sum(one.status != "ok" for one in outcomes)
        progress(sum(map(len, kept.values())), len(experiments), bad)

    for outcomes in kept.values():
        count(outcomes)
    several = (
        spread(missing, dask, predict=settings.predict) if dask is not None and missing else None
    )
    for name, outcomes in several or _here(missing, threads, predict=settings.predict):
        if folder is not None:
            write(folder / "shards", {name: dataset.written(outcomes)})
        kept[name] = outcomes
        count(outcomes)
    outcomes = [one for name in names for one in kept[name]]
    found = dataset.of(settings, outcomes).assign_attrs(key=whole)
    if folder is not None:
        finished(folder, settings, outcomes, found)
        shutil.rmtree(folder / "shards", ignore_errors=True)
    return found


def finished(folder: Path, settings: Sweep, outcomes: Sequence[Outcome], found: xr.Dataset) -> None:
    """Write the dataset and the table of a sweep."""
    whole = bytes(found.to_netcdf(engine="h5netcdf"))
    write(folder, {WHOLE: whole, TABLE: _table(settings, outcomes)})


def _kept(folder: Path, names: Sequence[str]) -> dict[str, list[Outcome]]:
    """The shards that a folder holds, by their names."""
    found = ((name, dataset.read(folder / "shards" / name)) for name in names)
    return {name: outcomes for name, outcomes in found if outcomes is not None}


def _here(
    shards: Mapping[str, Sequence[Experiment]], threads: int, *, predict: bool
) -> Iterator[tuple[str, list[Outcome]]]:
    """What comes of shards in this process, one after the other."""
    followed: Followed = {}
    for name, shard in shards.items():
        yield name, simulated(shard, threads, followed, predict=predict)
        if len(followed) > REMEMBERED:  # of a sweep whose motions differ
            followed.clear()


class Made:
    """The names of shards: other ones for other experiments, files or versions."""

    def __init__(self) -> None:
        self._versions = json.dumps(versions())
        self._inputs: dict[tuple[str, ...], list[str]] = {}

    def name(self, shard: Sequence[Experiment]) -> str:
        """Of a shard."""
        told = hashlib.sha256(self._versions.encode())
        for experiment in shard:
            files = [experiment.robot.mjcf, *experiment.robot.packages, experiment.law.kind]
            files += [motion.file or "" for motion in experiment.motion]
            if tuple(files) not in self._inputs:
                try:
                    found = [one.digest for one in gather(experiment)]
                except (ResonanceError, OSError) as error:  # said of the run
                    found = [str(error)]
                self._inputs[tuple(files)] = found
            told.update(experiment.to_toml().encode())
            told.update("".join(self._inputs[tuple(files)]).encode())
        return told.hexdigest()


def claim(folder: Path, values: Mapping[str, Any], experiments: Sequence[Experiment]) -> None:
    """Take a folder for a sweep or a search of these settings; refused if it is another's."""
    told = hashlib.sha256()
    for experiment in experiments:
        told.update(experiment.to_toml().encode())
    said = json.dumps({**values, "experiments": told.hexdigest()}, indent=2) + "\n"
    path = folder / SETTINGS
    if path.is_file():
        if path.read_text(encoding="utf-8") != said:
            raise OutputError(
                f"{folder}: holds another sweep, or this one with other settings; give another "
                "folder, or remove it"
            )
        return
    if any(path.name != CLAIM for path in folder.iterdir()):
        raise OutputError(f"{folder}: is not empty, and no sweep's; give another folder")
    write(folder, {SETTINGS: said.encode()})


def _finished(folder: Path, whole: str) -> xr.Dataset | None:
    """The result that a folder holds, if it is of these experiments, files and versions."""
    try:
        found = dataset.opened(folder / WHOLE)
    except OutputError:
        return None
    return found if found.attrs.get("key") == whole else None


def _table(settings: Sweep, outcomes: Sequence[Outcome]) -> bytes:
    """A line per experiment and motion, for a spreadsheet."""
    text = io.StringIO()
    lines = csv.writer(text)
    names = list(settings.keys)
    lines.writerow([*names, "status", "motion", *dataset.FIGURES, "message"])
    for point, outcome in zip(settings.points(), outcomes, strict=True):
        values = [json.dumps(v) if isinstance(v, list | dict) else v for v in point.values()]
        for motion, figures in enumerate(outcome.motions or [{}]):
            cells = ["" if figures.get(name) is None else figures[name] for name in dataset.FIGURES]
            lines.writerow([*values, outcome.status, motion + 1, *cells, outcome.message])
    return text.getvalue().encode()
