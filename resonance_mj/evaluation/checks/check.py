"""Judge a run by what its experiment expects of it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...experiments.expectations import PER_JOINT, WITH_OPTIMUM, Expected, OfMotion
from ...results.metrics import OPTIMUM_BAND
from ...results.motions import MotionOfRun
from ...results.run import Run
from ...results.schema import OF_SLIDES, VARIABLES
from ...springs.cost import KINDS
from ...status import Status

OF_SPRING, OF_TORQUE = 0.01, 0.001
"""By which share of the optimal spring, or of the RMS torque without springs where that is more, a
spring that is to be optimal may differ from the optimum if no tolerance is given."""


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
        found: in the motion's last whole cycle; None if there is none.
        history: the figure in each whole cycle of the motion (cycles,); of cycles_to_optimum
            torque² as a multiple of the optimum's.
        why: there is none; else empty.
    """

    key: str
    motion: int
    figure: str
    joint: str
    unit: str
    band: Band
    found: float | str | None
    history: np.ndarray
    why: str = ""

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
    found = [_status("expect.status", 0, expect.status, run.status)]
    for index, motion in enumerate(run.experiment.motion):
        found += _of_motion(run, "expect", index + 1, expect)
        if expect.motion:
            own, key = expect.motion[index], f"expect.motion.{index}"
            if own.status is not None:
                # A motion is ok if it was simulated whole and the tool follows.
                made = run.motions[index]
                whole = len(made.cycles) == motion.cycles
                ended = Status.OK if whole and made.tracks[-1] else run.status
                found.append(_status(f"{key}.status", index + 1, own.status, ended))
            found += _of_motion(run, key, index + 1, own)
    return found


def _status(key: str, motion: int, expected: Status, found: Status) -> Judgement:
    words = Band(str(expected), False, math.nan, math.nan)
    return Judgement(key, motion, "status", "", "", words, str(found), np.empty(0))


def _of_motion(run: Run, key: str, number: int, expect: OfMotion) -> Iterator[Judgement]:
    motion, slides = run.motions[number - 1], run.data["slides"].values
    names, near = run.data["joint"].values.tolist(), _near(motion)
    for figure, expected in expect.figures().items():
        course = _course(motion, figure)
        unit = VARIABLES[figure].units.replace("1", "") if figure in VARIABLES else ""
        best = getattr(motion, f"{figure}_optimal") if figure in WITH_OPTIMUM else None
        joints = expected.joints or names if figure in PER_JOINT else [""]
        for row, joint in enumerate(joints):
            j = names.index(joint) if joint else ...
            of = course[:, j]
            found = motion.cycles_to_optimum if figure == "cycles_to_optimum" else _last(of)
            yield Judgement(
                key=f"{key}.{figure}",
                motion=number,
                figure=figure,
                joint=joint,
                unit=OF_SLIDES.get(unit, unit) if joint and slides[j] else unit,
                band=_band(expected, row, best, near.get(figure), j),
                found=found,
                history=of,
                why=_why_none(motion, figure) if found is None else "",
            )


def _course(motion: MotionOfRun, figure: str) -> np.ndarray:
    """A figure in each whole cycle of a motion (C,) or (C, n)."""
    if figure != "cycles_to_optimum":
        return np.asarray(getattr(motion, figure))
    cost, best = motion.cost, motion.cost_optimal
    return cost / best if best > 0 else np.full(len(cost), np.nan)


def _last(course: np.ndarray) -> float | None:
    return float(course[-1]) if len(course) and not np.isnan(course[-1]) else None


def _why_none(motion: MotionOfRun, figure: str) -> str:
    """Why there is no such figure of a motion."""
    if not len(motion.cycles):
        return "the run ended before a cycle of this motion was whole"
    if not motion.torque_squared_without_springs > 0:
        return "the motion needs no torque without springs"
    if figure == "torque_share":
        return "no spring helps: the best ones leave the torque² that there is without any"
    if not motion.cost_optimal > 0:
        return "the best springs leave no torque, and no cycle is within 5 % of none"
    return f"the last cycle is not within 5 % of the optimum's {KINDS[motion.kind].name}"


def _near(motion: MotionOfRun) -> dict[str, Any]:
    """Tolerances of what is to be optimal where none is given.

    Of stiffness and offset: a hundredth of the optimal one, or what makes a thousandth of the RMS
    torque that the motion needs without springs. A joint whose spring has next to nothing to do,
    and therefore no stiffness to speak of, passes by the second. Of the equilibrium angle: what
    such an offset turns. Of the reduction: what keeps torque² within `OPTIMUM_BAND`.
    """
    torque = OF_TORQUE * math.sqrt(motion.torque_squared_without_springs)
    k, offset = np.abs(motion.stiffness_optimal), np.abs(motion.offset_optimal)
    push = np.maximum(OF_SPRING * offset, torque)
    # What is divided by 0 is infinite, and nothing is 0.
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            "stiffness": np.maximum(
                OF_SPRING * k, np.where(torque == 0, 0.0, torque / _swing(motion))
            ),
            "offset": push,
            "equilibrium": np.where(push == 0, 0.0, push / k),
            "torque_reduction": OPTIMUM_BAND * (1 - motion.torque_reduction_optimal),
        }


def _swing(motion: MotionOfRun) -> np.ndarray:
    """Standard deviation of the joint angles in the last whole cycle that was kept (n,) [rad]."""
    of = motion.samples["cycle_of_sample"].values
    whole = of[np.isin(of, motion.cycles)]
    last = motion.samples["q"].values[of == whole[-1]] if len(whole) else np.empty((0, 0))
    return last.std(axis=0) if len(whole) else np.full(len(motion.stiffness_optimal), np.nan)


def _band(expected: Expected, row: int, best: Any, near: Any, j: Any) -> Band:
    """What passes, with the optimum's value and the tolerance that it has if none is given.

    Args:
        expected: of one figure.
        row: of its joints, the one.
        best: of the optimum (n,) or ().
        near: tolerance where none is given, likewise.
        j: number of the joint in the arm; ... for what has none.
    """
    given = expected.value[row] if isinstance(expected.value, tuple) else expected.value
    if given is None:
        low = -math.inf if expected.min is None else expected.min
        return Band(None, False, low, math.inf if expected.max is None else expected.max)
    optimal = given == "optimal"
    value = float(np.asarray(best)[j]) if optimal else float(given)
    if expected.abs is None and expected.rel is None:
        tolerance = float(np.asarray(near)[j])
    else:
        tolerance = max(expected.abs or 0.0, (expected.rel or 0.0) * abs(value))
    if math.isinf(tolerance):
        return Band(value, optimal, -math.inf, math.inf)
    return Band(value, optimal, value - tolerance, value + tolerance)
