"""The keys that are best by a figure under constraints, asked of Optuna and told in batches."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import xarray as xr

from ..callback.callback import refuse_foreign
from ..claim import claimed
from ..errors import ExperimentError
from ..experiments.effects import refuse_idle
from ..experiments.experiment import Experiment
from ..experiments.loading import load
from ..experiments.sweeping import Range, Sweep, of_values
from ..experiments.tuning import Tuning, load_tuning
from ..files import write
from ..plan.plan import Followed
from ..progress import Asked, Progress, progressing
from ..text import listed, nearest, shown
from . import dataset
from .cluster import Cluster, connected
from .dataset import Outcome
from .judging import NO_FIGURE, OF_RUN, beyond, objective
from .shards import simulated
from .sweep import REMEMBERED, SHARD, Made, claim, finished

if TYPE_CHECKING:
    from optuna import Study
    from optuna.distributions import BaseDistribution


BEST = "best.toml"
"""The experiment with the best values, in the folder of a search."""


@dataclass(frozen=True, repr=False)
class Tuned:
    """What was found.

    Attributes:
        keys: the best values, by their keys; empty if no trial is ok within the constraints.
        value: of the figure with them; NaN for none.
        figure: its name.
        experiment: with the best values; as it was, if there are none.
        data: all trials, as of a sweep over `run`, with `objective` and `feasible`.
    """

    keys: dict[str, Any]
    value: float
    figure: str
    experiment: Experiment
    data: xr.Dataset

    def __repr__(self) -> str:
        found = ", ".join(f"{key} = {shown(value)}" for key, value in self.keys.items())
        return f"<Tuned: {self.figure} {self.value:.4g} with {found or 'nothing'}>"


def tune(
    given: str | os.PathLike[str] | Experiment,
    keys: Mapping[str, Any] | None = None,
    *,
    minimize: str | None = None,
    maximize: str | None = None,
    constraints: Mapping[str, Mapping[str, float]] | None = None,
    trials: int = 64,
    seed: int = 0,
    folder: str | os.PathLike[str] | None = None,
    threads: int = 0,
    dask: str | None = None,
    progress: Asked = None,
) -> Tuned:
    """Look for the values of keys that are best by a figure, by Optuna's TPE sampler.

    Sixteen experiments are tried at a time. With a folder they are written as they are finished: a
    search that was interrupted goes on there with the same call, and ends with the same bits.

    Args:
        given: a tuning's TOML file, or an experiment (or its name) whose keys are looked for.
        keys: of an experiment: a list of values of each, or a range {"from": 1, "to": 10,
            "scale": "log"}.
        minimize: the figure of `summary.json` to be least, such as cycles_to_optimum,
            electrical_energy or peak_torque, the worst of all motions.
        maximize: the figure to be greatest, in its place.
        constraints: figures that must be within ends, {"peak_torque": {"max": 0.3}}.
        trials: experiments that are tried.
        seed: of the search.
        folder: where shards and the result are written; nothing is if None.
        threads: how many to simulate with; 0 for all cores.
        dask: as of `sweep`: each batch is parted among the cluster's threads.
        progress: as of `sweep`.

    Raises:
        ExperimentError: a key, a value or a figure is not valid, or Optuna is not installed.
        ClusterError: the cluster cannot be reached, is lost, or has workers of another version.
        OutputError: the folder cannot be written, or is of another search.
    """
    refuse_foreign()
    base = given if isinstance(given, Experiment) else None
    name = given.name if isinstance(given, Experiment) else os.fspath(given)
    if keys is None and base is not None:
        raise ExperimentError(f"tuning of {name}: keys are missing: which values to look among")
    if keys is None:
        settings = load_tuning(name)
    else:
        goal = {"minimize": minimize, "maximize": maximize}
        values = {"experiment": name, "keys": dict(keys), "trials": trials, "seed": seed, **goal}
        values["constraints"] = dict(constraints or {})
        settings = of_values(Tuning, values, f"tuning of {name}")
    base = (load(settings.experiment) if base is None else base).replace(settings.fixed)
    _check(settings, base)
    with (
        claimed(folder) if folder else nullcontext() as at,
        progressing(progress, f"tuning of {settings.experiment}", "trials") as show,
        _study(settings) as study,
        connected(dask) if dask is not None else nullcontext() as cluster,
    ):
        if at is not None:
            claim(at, settings.model_dump(mode="json", by_alias=True), [base])
        followed: Followed = {}

        def simulate(shard: list[Experiment], name: str) -> list[Outcome]:
            if cluster is not None:
                return _parted(cluster, shard, name)
            if len(followed) > REMEMBERED:
                followed.clear()
            return simulated(shard, threads, followed)

        points, outcomes = _tried(settings, base, study, at, simulate, show)
        found = _found(settings, base, points, outcomes)
        if at is not None:
            finished(at, _as_sweep(settings, points), outcomes, found.data)
            if found.keys:
                write(at, {BEST: found.experiment.to_toml().encode()})
    return found


def _tried(
    settings: Tuning,
    base: Experiment,
    study: Study,
    folder: Path | None,
    simulate: Callable[[list[Experiment], str], list[Outcome]],
    progress: Progress,
) -> tuple[list[dict[str, Any]], list[Outcome]]:
    """The trials that a study asks for, batch by batch, and what came of each."""
    points: list[dict[str, Any]] = []
    outcomes: list[Outcome] = []
    made = Made()
    while len(points) < settings.trials:
        count = min(SHARD, settings.trials - len(points))
        asked = [study.ask(_distributions(settings)) for _ in range(count)]
        batch = [_values(settings, trial.params) for trial in asked]
        shard, refused = _valid(base, batch)
        name = made.name(shard)
        kept = None if folder is None else dataset.read(folder / "shards" / name)
        if kept is None:
            kept = simulate(shard, name)
            if folder is not None:
                write(folder / "shards", {name: dataset.written(kept)})
        simulations = iter(kept)
        kept = [refused[i] if i in refused else next(simulations) for i in range(count)]
        for trial, outcome in zip(asked, kept, strict=True):
            for at_end, value in beyond(settings, outcome).items():
                trial.set_constraint(at_end, value)
            study.tell(trial, objective(settings, outcome))
        points += batch
        outcomes += kept
        progress(len(points), settings.trials, sum(one.status != "ok" for one in outcomes))
    return points, outcomes


def _parted(cluster: Cluster, shard: list[Experiment], name: str) -> list[Outcome]:
    """What comes of a batch whose parts a cluster simulates side by side."""
    parts = min(cluster.threads, len(shard))
    each = {f"{name}-{part}-{parts}": shard[part::parts] for part in range(parts)}
    outcomes = dict(cluster.spread(each))
    found: list[Outcome | None] = [None] * len(shard)
    for part, key in enumerate(each):
        found[part::parts] = outcomes[key]
    return cast("list[Outcome]", found)


def _check(settings: Tuning, base: Experiment) -> None:
    """Raise where a figure does not exist, or a key cannot have one of its values."""
    known = (*dataset.FIGURES, *OF_RUN)
    for figure in (settings.figure, *settings.constraints):
        if figure not in known:
            raise ExperimentError(
                f"tuning of {settings.experiment}: {shown(figure)} is no figure of a motion"
                f"{nearest(figure, known)}; there are {listed(known, most=40)}"
            )
    ends: dict[str, list[Any]] = {
        key: [values.start, values.stop] if isinstance(values, Range) else values
        for key, values in settings.keys.items()
    }
    tried: list[Experiment] = []
    for key, values in ends.items():
        alone, refused = _valid(base, [{key: value} for value in values])
        if refused and (not alone or isinstance(settings.keys[key], Range)):
            raise ExperimentError(next(iter(refused.values())).message)
        tried += alone
    most = max(map(len, ends.values()))
    corners = [{key: v[min(i, len(v) - 1)] for key, v in ends.items()} for i in range(most)]
    tried += _valid(base, corners)[0]
    refuse_idle(tried, settings.keys, f"tuning of {settings.experiment}")


def _valid(
    base: Experiment, points: Sequence[Mapping[str, Any]]
) -> tuple[list[Experiment], dict[int, Outcome]]:
    """Experiments of points, and what is said of those that are none, by their places."""
    shard, refused = [], {}
    for index, point in enumerate(points):
        try:
            shard.append(base.replace(point))
        except ExperimentError as error:
            refused[index] = Outcome.refused(str(error))
    return shard, refused


@contextmanager
def _study(settings: Tuning) -> Iterator[Study]:
    """A study of Optuna in memory, which says nothing of its own."""
    try:
        import optuna
    except ImportError:
        raise ExperimentError("tune needs Optuna: pip install 'resonance-mj[tune]'") from None
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        sampler = optuna.samplers.TPESampler(
            seed=settings.seed, multivariate=True, constant_liar=True
        )
        least = optuna.study.StudyDirection.MINIMIZE
        most = optuna.study.StudyDirection.MAXIMIZE
        yield optuna.create_study(sampler=sampler, direction=least if settings.minimize else most)
    finally:
        optuna.logging.set_verbosity(before)


def _distributions(settings: Tuning) -> dict[str, BaseDistribution]:
    from optuna.distributions import CategoricalDistribution, FloatDistribution

    found: dict[str, BaseDistribution] = {}
    for key, given in settings.keys.items():
        among = _listed(given)
        if isinstance(given, Range) and among is None:
            found[key] = FloatDistribution(given.start, given.stop, log=given.scale == "log")
        else:  # by place: a value may be a list
            found[key] = CategoricalDistribution(list(range(len(among or ()))))
    return found


def _values(settings: Tuning, params: Mapping[str, Any]) -> dict[str, Any]:
    """Values of the keys, with twelve digits."""
    found: dict[str, Any] = {}
    for key, given in settings.keys.items():
        among = _listed(given)
        found[key] = float(f"{params[key]:.12g}") if among is None else among[params[key]]
    return found


def _listed(given: Range | list[Any]) -> list[Any] | None:
    """The values among which one is looked for; None for all of a range."""
    if isinstance(given, list):
        return given
    return None if given.count is None else given.at(np.linspace(0.0, 1.0, given.count))


def _as_sweep(settings: Tuning, points: Sequence[Mapping[str, Any]]) -> Sweep:
    """The trials as a sweep that has them all."""
    keys = {key: [point[key] for point in points] for key in settings.keys}
    values = {"experiment": settings.experiment, "how": "zip", "keys": keys}
    return of_values(Sweep, values | {"fixed": settings.fixed}, f"tuning of {settings.experiment}")


def _found(
    settings: Tuning,
    base: Experiment,
    points: Sequence[dict[str, Any]],
    outcomes: Sequence[Outcome],
) -> Tuned:
    values = [objective(settings, one) for one in outcomes]
    feasible = [max(beyond(settings, one).values()) <= 0 for one in outcomes]
    data = dataset.of(_as_sweep(settings, points), outcomes)
    data = data.assign(
        objective=("run", [math.nan if abs(v) >= NO_FIGURE else v for v in values]),
        feasible=("run", feasible),
    )
    data["objective"].attrs = {"units": "1", "long_name": settings.figure}
    sign = 1.0 if settings.minimize else -1.0
    ranked = [(sign * values[i], i) for i in range(len(values)) if feasible[i]]
    if not ranked:
        return Tuned({}, math.nan, settings.figure, base, data)
    at = min(ranked)[1]
    best = base.replace(points[at])
    return Tuned(points[at], values[at], settings.figure, best, data.assign_attrs(best=at))
