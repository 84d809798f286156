"""Judge a run by what its experiment expects of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...experiments.expectations import PER_JOINT, Expected, OfMotion
from ...results.metrics import OPTIMUM_BAND
from ...results.run import Run
from ...status import Status
from . import histories

OF_SPRING, OF_TORQUE = 0.01, 0.001
"""By which share of the optimal spring, or of the RMS torque without springs where that is more, a
spring that is to be optimal may differ from the optimum if no tolerance is given."""

UNITS = {
    "stiffness": ("N m/rad", "N/m"),
    "offset": ("N m", "N"),
    "equilibrium": ("rad", "m"),
    "torque_reduction": ("", ""),
    "torque_share": ("", ""),
    "tracking_rms": ("m", "m"),
    "cycles_to_optimum": ("", ""),
}
"""Of each figure, for hinge and for slide joints."""


class Band(NamedTuple):
    """What passes: from `low` to `high`, about the value that is expected."""

    expected: float | str | None
    """None where there are only bounds; a word for the status."""
    optimal: bool
    """Whether the value is that of the robot's own optimum."""
    low: float
    high: float


@dataclass(frozen=True)
class Judgement:
    """What is expected of one figure, and what a run shows.

    Attributes:
        key: of the expectation in the file, such as expect.motion.0.stiffness.
        motion: number of the motion, from 1; 0 for the whole run.
        figure: stiffness, status and so on.
        joint: its name; empty where the figure is not of a joint.
        unit: of the numbers.
        band: what passes.
        found: in the motion's last whole cycle; None if the run did not reach it.
        history: the figure in each whole cycle of the motion (cycles,); of cycles_to_optimum
            torque² as a multiple of the optimum's.
    """

    key: str
    motion: int
    figure: str
    joint: str
    unit: str
    band: Band
    found: float | str | None
    history: np.ndarray

    @property
    def passed(self) -> bool:
        """Whether the run shows what is expected."""
        if isinstance(self.found, str):
            return self.found == self.band.expected
        return self.found is not None and self.band.low <= self.found <= self.band.high


def judge(run: Run) -> list[Judgement]:
    """Hold a run against the expectations of its experiment, which `cases.fit` has checked.

    The figures are those of each motion's last whole cycle.

    Returns:
        A judgement for each expectation of each motion and joint, the status of the run first.
    """
    expect = run.experiment.expect
    found = [_status(run, "expect.status", 0, expect.status)]
    for index in range(len(run.experiment.motion)):
        found += _of_motion(run, "expect", index + 1, expect)
        if expect.motion:
            own, key = expect.motion[index], f"expect.motion.{index}"
            if own.status is not None:
                found.append(_status(run, f"{key}.status", index + 1, own.status))
            found += _of_motion(run, key, index + 1, own)
    return found


def _status(run: Run, key: str, motion: int, expected: Status) -> Judgement:
    """The status of the run, or of a motion: ok if all its cycles were simulated."""
    whole = motion and (
        len(run.motions[motion - 1].cycles) == run.experiment.motion[motion - 1].cycles
    )
    found = Status.OK if whole else run.status
    words = Band(str(expected), False, math.nan, math.nan)
    return Judgement(key, motion, "status", "", "", words, str(found), np.empty(0))


def _of_motion(run: Run, key: str, motion: int, expect: OfMotion) -> Iterator[Judgement]:
    data = run.data
    history, best = histories.of_motion(data, motion), histories.optimum(data, motion)
    near = _near(run, motion)
    names = data["joint"].values.tolist()
    for figure, expected in expect.figures().items():
        where = f"{key}.{figure}", motion, figure
        hinge, slide = UNITS[figure]
        if figure in PER_JOINT:
            for row, joint in enumerate(expected.joints or names):
                j = names.index(joint)
                unit = slide if data["slides"].values[j] else hinge
                band = _band(_of_joint(expected, row), best[figure][j], near[figure][j])
                course = history[figure][:, j]
                yield Judgement(*where, joint, unit, band, _last(course), course)
        elif figure == "cycles_to_optimum":
            reached = run.motions[motion - 1].cycles_to_optimum
            course = history["torque_squared_of_optimum"]
            yield Judgement(*where, "", hinge, _band(expected), reached, course)
        else:
            band = _band(expected, best.get(figure), near.get(figure))
            yield Judgement(*where, "", hinge, band, _last(history[figure]), history[figure])


def _near(run: Run, motion: int) -> dict[str, Any]:
    """Tolerances of what is to be optimal where none is given.

    Of stiffness and offset: a hundredth of the optimal one, or what makes a thousandth of the RMS
    torque that the motion needs without springs. A joint whose spring has next to nothing to do,
    and therefore no stiffness to speak of, passes by the second. Of the equilibrium angle: what
    such an offset turns. Of the reduction: what keeps torque² within `OPTIMUM_BAND`.
    """
    segment = run.data.sel(segment=motion)
    without = float(segment["torque_squared_without_springs"])
    torque = OF_TORQUE * math.sqrt(without)
    k, offset = (np.abs(segment[f"{name}_optimal"].values) for name in ("stiffness", "offset"))
    push = np.maximum(OF_SPRING * offset, torque)
    with np.errstate(divide="ignore"):
        return {
            "stiffness": np.maximum(OF_SPRING * k, torque / histories.swing(run.data, motion)),
            "offset": push,
            "equilibrium": push / k,
            "torque_reduction": OPTIMUM_BAND * float(segment["torque_squared_optimal"]) / without,
        }


def _of_joint(expected: Expected, row: int) -> Expected:
    """An expectation of joints, for one of them."""
    if isinstance(expected.value, tuple):
        return expected.model_copy(update={"value": expected.value[row]})
    return expected


def _band(expected: Expected, best: Any = None, near: Any = None) -> Band:
    """What passes, with the optimum's value and the tolerance that it has if none is given."""
    if expected.value is None:
        low, high = expected.min, expected.max
        return Band(
            None, False, -math.inf if low is None else low, math.inf if high is None else high
        )
    optimal = expected.value == "optimal"
    value = float(best) if optimal else float(expected.value)  # type: ignore[arg-type]
    if expected.abs is None and expected.rel is None:
        tolerance = float(near)
    else:
        tolerance = max(expected.abs or 0.0, (expected.rel or 0.0) * abs(value))
    if not math.isfinite(tolerance):
        return Band(value, optimal, -math.inf, math.inf)
    return Band(value, optimal, value - tolerance, value + tolerance)


def _last(course: np.ndarray) -> float | None:
    return float(course[-1]) if len(course) else None
