"""The pytest plugin: a TOML file with [expect] is a test, and `resonance_run` is a fixture.

Every pytest imports it where this package is installed: what is heavy is imported when it is used.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .experiments.experiment import Experiment
    from .results.run import Run


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option and the ini setting that make TOML files tests."""
    group = parser.getgroup("resonance", "runs of robots with adjustable springs (resonance-mj)")
    group.addoption(
        "--resonance",
        action="store_true",
        help="collect *.toml files with a section [expect], and hold their runs against it",
    )
    parser.addini("resonance", "as --resonance", type="bool", default=False)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """An experiment file that says what to expect, where the user has asked for such tests."""
    if file_path.suffix != ".toml":
        return None
    if not (parent.config.getoption("resonance") or parent.config.getini("resonance")):
        return None
    from .evaluation.checks.cases import holds_expectations

    saved = file_path.with_name("run.nc").exists()  # an experiment that a run was saved with
    if saved or not holds_expectations(file_path):
        return None
    return ExperimentFile.from_parent(parent, path=file_path)


class ExperimentFile(pytest.File):
    """A TOML file with [expect]."""

    def collect(self) -> Iterator[pytest.Item]:
        """The test that it is; bad input is an error of collection, in one line."""
        from .errors import ResonanceError
        from .evaluation.checks.cases import read

        try:
            experiment = read(self.path)
        except ResonanceError as error:
            raise self.CollectError(str(error)) from None
        item = ExperimentItem.from_parent(self, name=experiment.name)
        item.experiment = experiment
        yield item


class ExperimentItem(pytest.Item):
    """One experiment, simulated and held against what it expects."""

    experiment: Experiment

    def runtest(self) -> None:
        """Simulate it, and fail if it misses an expectation, or cannot be simulated."""
        from .errors import ResonanceError
        from .evaluation.checks.check import judge
        from .evaluation.checks.convergence import report
        from .simulation.simulation import simulate

        try:
            run = simulate(self.experiment)
            missed = report(run, judge(run))
        except ResonanceError as error:
            missed = str(error)
        if missed:
            pytest.fail(missed, pytrace=False)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the test stands, for reports."""
        return self.path, None, self.name


@pytest.fixture(scope="session")
def resonance_run() -> Callable[..., Run]:
    """The run of an experiment: `resonance_run("arm.toml", {"law.eta": 0.3})`.

    Each is simulated once in a session, and again if a file has changed that it depends on. What a
    law of a user's file reads and imports is not known: its runs are always made anew.
    """
    from .experiments.expectations import Expect
    from .experiments.experiment import Experiment
    from .experiments.loading import load
    from .laws.laws import LAWS
    from .plan.plan import plan_for
    from .simulation.simulation import simulate

    made: dict[Any, Run] = {}

    def run(
        experiment: str | os.PathLike[str] | Experiment, changes: Mapping[str, Any] | None = None
    ) -> Run:
        if not isinstance(experiment, Experiment):
            experiment = load(experiment)
        experiment = experiment.replace(changes or {})
        if experiment.law.kind not in LAWS:
            return simulate(experiment)
        bare = experiment.model_copy(update={"name": "run", "expect": Expect()}).to_toml()
        found = made.get((bare, plan_for(experiment).inputs))
        if found is None:
            found = simulate(experiment)
            made[bare, found.inputs] = found
        mine = {"name": experiment.name, "expect": experiment.expect}
        return replace(
            found,
            experiment=found.experiment.model_copy(update=mine),
            data=found.data.copy(deep=True),
        )

    return run
