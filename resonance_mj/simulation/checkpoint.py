"""The whole state of a run between two cycles, as numbers that it holds, to go on exactly."""

from __future__ import annotations

import numpy as np

from ..errors import ExperimentError
from ..laws.doubting import Belief
from ..laws.tuning import Tuning
from ..plan.plan import Plan
from ..results.run import Run, versions
from ..status import Status
from ..text import listed

STATE = "checkpoint"
"""The variable of a run that holds it."""


DAMAGED = "the run's checkpoint is damaged, or was changed: begin it anew"
"""Of one that is not what `packed` has made of this experiment."""


def packed(physics: np.ndarray, parameters: np.ndarray, tuning: Tuning) -> np.ndarray:
    """State of MuJoCo and the law's memory (S,), parameters of elements (P,) and tuning, in a row.

    Each array stands behind its number of dimensions and their lengths.
    """
    lead = -1.0 if tuning.lead is None else float(tuning.lead)
    numbers = [tuning.share, lead, tuning.filtered, tuning.delay, tuning.ratio, tuning.pace]
    numbers += [tuning.least, tuning.noise, tuning.cycles, tuning.change]
    cross = None if tuning.known is None else np.stack([tuning.known[1].real, tuning.known[1].imag])
    weights = None if tuning.known is None else tuning.known[0]
    before = (None, None) if tuning.before is None else tuning.before
    arrays = [physics, parameters, np.array(numbers, float), np.array(tuning.last)]
    belief = tuning.springs or (None,) * len(Belief._fields)
    *fixed, waited, total, known = belief
    believed = [*fixed, np.array(waited or 0), total, *(known or (None, None))]
    every = (weights, cross, *before, *believed)
    arrays += [np.empty(0) if one is None else one for one in every]
    parts = [np.concatenate([[one.ndim, *one.shape], np.ravel(one)]) for one in arrays]
    return np.concatenate(parts)


def unpacked(state: np.ndarray) -> tuple[np.ndarray, np.ndarray, Tuning]:
    """What `packed` has put in a row.

    Raises:
        ExperimentError: it is not what `packed` makes.
    """
    try:
        return _unpacked(state)
    except (ValueError, IndexError, OverflowError):
        raise ExperimentError(DAMAGED) from None


def _unpacked(state: np.ndarray) -> tuple[np.ndarray, np.ndarray, Tuning]:
    arrays, at = [], 0
    while at < len(state):
        dims = int(state[at])
        shape = state[at + 1 : at + 1 + dims].astype(int)
        begin = at + 1 + dims
        at = begin + int(shape.prod())
        arrays.append(state[begin:at].reshape(shape))
    physics, parameters, numbers, last, weights, cross, total, y, *believed = arrays
    a, squares, products, near, waited, needed, features, v = believed
    belief = Belief(
        a=a,
        squares=squares,
        products=products,
        near=near,
        waited=int(waited),
        before=needed if needed.size else None,
        known=(features, v) if v.size else None,
    )
    share, lead, filtered, delay, ratio, pace, least, noise, cycles, change = numbers.tolist()
    tuning = Tuning(
        share=share,
        lead=None if lead < 0 else int(lead),
        filtered=bool(filtered),
        delay=int(delay),
        ratio=ratio,
        pace=pace,
        least=least,
        last=tuple(last.tolist()),
        noise=noise,
        known=(weights, cross[0] + 1j * cross[1]) if weights.size else None,
        cycles=int(cycles),
        change=change,
        before=(total, y) if total.size else None,
        springs=belief if a.size else None,
    )
    return physics, parameters, tuning


def check(run: Run, plan: Plan) -> None:
    """See that a run can go on as a plan.

    Raises:
        ExperimentError: it is of another experiment, other files or versions, or was interrupted
            without keeping its state.
    """
    name = f"run {run.experiment.name!r}"
    paths = {one.key: str(one.path) for one in run.inputs if one.key}
    same = plan.experiment.replace(paths) == run.experiment.replace(paths)
    digests = [[one.digest for one in inputs] for inputs in (plan.inputs, run.inputs)]
    if not same or digests[0] != digests[1]:
        raise ExperimentError(
            f"{name} is of another experiment, or its files have changed: give the keys and files "
            "that it had, or another --out to begin anew"
        )
    if run.versions != versions():
        other = [
            f"{key} {value}" for key, value in run.versions.items() if value != versions()[key]
        ]
        raise ExperimentError(
            f"{name} was begun with {listed(other)}: its end would be another; begin it anew"
        )
    if run.status is Status.INTERRUPTED and STATE not in run.data:
        raise ExperimentError(f"{name} did not keep the state that it takes to resume it")
