"""Assertions on runs, for tests written in Python; a run comes from the fixture `resonance_run`.

What an assertion says when it fails is what `resonance-mj check` says: which joint, how far, in
which cycle it would have passed, and the convergence as a text plot.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .results.run import Run


def assert_converged(run: Run, *, motion: int | None = None, cycles: int | None = None) -> None:
    """The run ended well, and each motion's torque² came within 5 % of the optimum's to stay.

    Args:
        run: from the fixture `resonance_run`, or `simulate`.
        motion: number of the motion, from 1; all if None.
        cycles: cycles of the motion within which it must be there; as many as it has if None.

    Raises:
        AssertionError: it did not.
        ExperimentError: there is no such motion.
    """
    __tracebackhide__ = True
    most = max(one.cycles for one in run.experiment.motion) if cycles is None else cycles
    _hold(run, motion, "cycles_to_optimum", max=most)


def assert_stiffness(
    run: Run,
    expected: float | Sequence[float],
    *,
    rel: float | None = None,
    abs: float | None = None,
    joints: Sequence[str] | None = None,
    motion: int | None = None,
) -> None:
    """The springs ended at a stiffness.

    Args:
        run: from the fixture `resonance_run`, or `simulate`.
        expected: one number for all joints or one each [N m/rad], for slide joints [N/m].
        rel: tolerance as a share of `expected`; it or `abs` is needed, and the wider counts.
        abs: tolerance [N m/rad].
        joints: names of the joints that it is about; all if None.
        motion: number of the motion, from 1; all if None.

    Raises:
        AssertionError: they did not, or the run did not end well.
        ExperimentError: there is no such motion or joint, the list is not as long as it must be, or
            there is no tolerance.
    """
    __tracebackhide__ = True
    value = [*expected] if isinstance(expected, Sequence) else expected
    _hold(run, motion, "stiffness", value=value, rel=rel, abs=abs, joints=joints)


def assert_optimal(
    run: Run,
    *,
    rel: float | None = None,
    abs: float | None = None,
    joints: Sequence[str] | None = None,
    motion: int | None = None,
) -> None:
    """The springs ended at the optimal stiffness of this robot's own motion.

    Args:
        run: from the fixture `resonance_run`, or `simulate`.
        rel: tolerance as a share of the optimum.
        abs: tolerance [N m/rad]; if neither is given, 1 % of the optimum or what makes 0.1 % of the
            RMS torque without springs, whichever is wider.
        joints: names of the joints that it is about; all if None.
        motion: number of the motion, from 1; all if None.

    Raises:
        AssertionError: they did not, or the run did not end well.
        ExperimentError: there is no such motion or joint.
    """
    __tracebackhide__ = True
    _hold(run, motion, "stiffness", value="optimal", rel=rel, abs=abs, joints=joints)


def _hold(run: Run, motion: int | None, figure: str, **band: Any) -> None:
    """Hold a figure of a run against a band whose keys are those of a file."""
    __tracebackhide__ = True
    from dataclasses import replace

    from .errors import ExperimentError
    from .evaluation.checks.cases import fit
    from .evaluation.checks.check import judge
    from .evaluation.checks.convergence import report

    name, motions = run.experiment.name, range(1, len(run.experiment.motion) + 1)
    expect: dict[str, Any] = {figure: {k: v for k, v in band.items() if v is not None}}
    if motion is not None:
        if motion not in motions:
            raise ExperimentError(f"motion = {motion}: {name} has motions 1 to {len(motions)}")
        expect = {"motion": [expect if i == motion else {} for i in motions]}
    experiment = run.experiment.replace(
        {"expect": {}, **{f"expect.{key}": value for key, value in expect.items()}}
    )
    fit(experiment, run.data["joint"].values.tolist(), f"experiment {name!r}")
    if missed := report(run := replace(run, experiment=experiment), judge(run)):
        raise AssertionError(missed)
