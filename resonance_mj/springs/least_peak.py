"""Springs and elements that leave the least peak torque: a linear program."""

from __future__ import annotations

import numpy as np

from .elements import Element
from .program import FLOOR, Columns, best, exceeded

ROUNDS, CLOSE, SECOND = 60, 1e-6, 1e-3
"""Linear programs that are solved at most; how much higher than all that it sees a peak may be; and
the weight of the motors' own peaks, of 1 for the largest."""


def least_peak(
    given: Columns, torque: np.ndarray, elements: tuple[Element, ...], rated: np.ndarray
) -> np.ndarray:
    """Feasible parameters (d,) that leave the least peak, of the rated torque (n,) of each motor.

    Of those that leave the same, the ones with the least sum of the motors' own peaks. The linear
    program sees of each motor its highest peaks and is given more of them, until none is higher.

    Raises:
        ValueError: no parameters are feasible.
    """
    n, start = len(rated), best(given, torque, elements)
    left = (torque - given.torque @ start).reshape(-1, n) / rated
    usual = np.abs(left).max(initial=0.0)
    # Where parameters do nothing along the motion, they are as they are.
    rms = np.sqrt((given.torque**2).mean(axis=0))
    moves = rms > FLOOR * rms.max(initial=0.0)
    if not usual or not moves.any():
        return start
    phi = given.torque[:, moves].reshape(len(left), n, -1) / rated[:, None]
    unit = usual / np.sqrt((phi**2).mean(axis=(0, 1)))
    left, phi = left / usual, phi * unit / usual
    change, peaks, found = np.zeros(len(unit)), np.full(n, -np.inf), start
    seen: dict[tuple[int, int], None] = {}
    rows, ends = given.rows, given.ends
    for _ in range(ROUNDS):
        now, before = np.abs(left - phi @ change), len(seen)
        higher = (now >= np.roll(now, 1, axis=0)) & (now >= np.roll(now, -1, axis=0))
        higher &= now > peaks + CLOSE
        seen.update(dict.fromkeys(zip(*map(np.ndarray.tolist, np.nonzero(higher)), strict=True)))
        more = list(exceeded(found, elements))
        if len(seen) == before and not more:
            break
        rows = np.vstack([rows, *(row for row, _ in more)])
        ends = np.append(ends, [end for _, end in more])
        at, of = np.array(list(seen)).T
        within = rows[:, moves] * unit, ends - rows @ start
        solved = _solved(left[at, of], phi[at, of], np.eye(n)[of], within)
        if solved is None:
            break
        change, peaks = solved
        found = start.copy()
        found[moves] += unit * change
    return found


def _solved(
    level: np.ndarray, reach: np.ndarray, motor: np.ndarray, within: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray] | None:
    """Change (d,) of parameters for the least peak at some samples, and each motor's peak (n,).

    Args:
        level: torque at the samples (S,).
        reach: what a change takes from it (S, d).
        motor: 1 for the motor that a sample is of (S, n).
        within: rows and ends of what a change may be.

    Returns:
        None where the solver finds no least.
    """
    from scipy.optimize import linprog  # takes longer to import than a plan without it

    n, d = motor.shape[1], reach.shape[1]
    below = np.hstack([motor, np.zeros((len(motor), 1))])
    ordered = np.hstack([np.zeros((n, d)), np.eye(n), -np.ones((n, 1))])
    bounds = np.hstack([within[0], np.zeros((len(within[0]), n + 1))])
    A = np.vstack([np.hstack([-reach, -below]), np.hstack([reach, -below]), ordered, bounds])
    b = np.concatenate([-level, level, np.zeros(n), within[1]])
    size = np.abs(A).max(axis=1)
    A, b = A[size > 0] / size[size > 0, None], b[size > 0] / size[size > 0]
    goal = np.concatenate([np.zeros(d), np.full(n, SECOND / n), [1.0]])
    x = linprog(goal, A, b, bounds=[(None, None)] * d + [(0.0, None)] * (n + 1)).x
    return None if x is None else (x[:d], x[d : d + n])
