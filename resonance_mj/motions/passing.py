"""From one motion into the next: one takes over from the other, or shrinks as the other grows."""

from __future__ import annotations

import numpy as np

from . import rotations
from .minimum_jerk import minimum_jerk
from .motion import Samples, of_rates

OVERLAP = 0.6
"""Share of a passage by way of a small motion in which one shrinks, and in which the next grows."""


def blended(before: Samples, after: Samples, cycle: int, cycles: int, period: float) -> Samples:
    """One cycle of the passage from a motion to the next, smooth to the second derivative.

    x = x_before + σ (x_after - x_before), with the minimum-jerk σ = 10 r³ - 15 r⁴ + 6 r⁵ of the
    share r of the passage that has gone by. Of rotations it is the rotation vectors that are so
    joined.

    Args:
        before: the motion that is left, over one cycle of the new one (N, m).
        after: the motion that begins.
        cycle: which cycle of the passage, from 0.
        cycles: number of cycles of the passage.
        period: cycle time of the new motion [s].
    """
    if after.rotates:
        before, after = _with_rates(before), _with_rates(after)
    sigma, d_sigma, dd_sigma = _in_time(_gone(len(after.x), cycle, cycles), cycles * period)
    gap, d_gap, dd_gap = after.x - before.x, after.dx - before.dx, after.ddx - before.ddx
    x = before.x + sigma * gap
    dx = before.dx + sigma * d_gap + d_sigma * gap
    ddx = before.ddx + sigma * dd_gap + 2 * d_sigma * d_gap + dd_sigma * gap
    return of_rates(x, dx, ddx, after.rotates)


def by_a_small_motion(
    before: Samples,
    after: Samples,
    middles: tuple[np.ndarray, np.ndarray],
    cycle: int,
    cycles: int,
    period: float,
) -> Samples:
    """One cycle of a passage in which a motion shrinks while the next grows.

    x = c + (1 - σ(r / p)) (x_before - c_before) + σ((r - 1 + p) / p) (x_after - c_after), with σ as
    in `blended`, 0 before and 1 behind its range, p = `OVERLAP`, about a middle c = c_before +
    σ(r) (c_after - c_before): what lies half-way between two motions may need more torque than
    either, and a small one does not.

    Args:
        before: the motion that is left, over one cycle of the new one (N, m).
        after: the motion that begins.
        middles: mean of each over its cycle (m,).
        cycle: which cycle of the passage, from 0.
        cycles: number of cycles of the passage.
        period: cycle time of the new motion [s].
    """
    if after.rotates:
        before, after = _with_rates(before), _with_rates(after)
    r, length = _gone(len(after.x), cycle, cycles), cycles * period
    way = middles[1] - middles[0]
    moved, *moving = _in_time(r, length)
    x, dx, ddx = middles[0] + moved * way, *(part * way for part in moving)
    shrunk, *shrinks = _in_time(np.clip(r / OVERLAP, 0, 1), OVERLAP * length)
    left = 1 - shrunk, *(-part for part in shrinks)
    grown = _in_time(np.clip((r - 1 + OVERLAP) / OVERLAP, 0, 1), OVERLAP * length)
    for (share, d_share, dd_share), one, middle in (
        (left, before, middles[0]),
        (grown, after, middles[1]),
    ):
        away = one.x - middle
        x = x + share * away
        dx = dx + share * one.dx + d_share * away
        ddx = ddx + share * one.ddx + 2 * d_share * one.dx + dd_share * away
    return of_rates(x, dx, ddx, after.rotates)


def _gone(steps: int, cycle: int, cycles: int) -> np.ndarray:
    """Share of a passage that has gone by at each step of one of its cycles (N, 1)."""
    return ((cycle + np.arange(steps) / steps) / cycles)[:, None]


def _in_time(r: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """σ and its derivatives by time, of which r takes `length` [s] from 0 to 1."""
    sigma, d_sigma, dd_sigma = minimum_jerk(r)
    return sigma, d_sigma / length, dd_sigma / length**2


def _with_rates(samples: Samples) -> Samples:
    """With the rotation vector's own derivatives in place of angular velocity and acceleration."""
    x, dx, ddx = samples.x, samples.dx.copy(), samples.ddx.copy()
    dx[:, -3:], ddx[:, -3:] = rotations.to_rates(x[:, -3:], dx[:, -3:], ddx[:, -3:])
    return Samples(x, dx, ddx, True)
