"""From one motion into the next: one takes over from the other, or shrinks before it grows."""

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
    steps = len(after.x)
    r = ((cycle + np.arange(steps) / steps) / cycles)[:, None]
    length = cycles * period
    sigma, d_sigma, dd_sigma = minimum_jerk(r)
    d_sigma, dd_sigma = d_sigma / length, dd_sigma / length**2
    gap, d_gap, dd_gap = after.x - before.x, after.dx - before.dx, after.ddx - before.ddx
    x = before.x + sigma * gap
    dx = before.dx + sigma * d_gap + d_sigma * gap
    ddx = before.ddx + sigma * dd_gap + 2 * d_sigma * d_gap + dd_sigma * gap
    return of_rates(x, dx, ddx, after.rotates)


def by_rest(
    before: Samples,
    after: Samples,
    middles: tuple[np.ndarray, np.ndarray],
    cycle: int,
    cycles: int,
    period: float,
) -> Samples:
    """One cycle of a passage that shrinks a motion to rest and lets the next grow from there.

    x = c + (1 - σ(2 r)) (x_before - c_before) + σ(2 r - 1) (x_after - c_after), each σ of minimum
    jerk within its half of the share r of the passage, about a middle c that goes from the one to
    the other: what lies between two motions may need more torque than either, and rest does not.

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
    steps = len(after.x)
    r = ((cycle + np.arange(steps) / steps) / cycles)[:, None]
    length = cycles * period
    moved, *moving = (part / length**i for i, part in enumerate(minimum_jerk(r)))
    way = middles[1] - middles[0]
    parts = [middles[0] + moved * way, *(part * way for part in moving)]
    took = OVERLAP * length
    shrunk, *shrinks = (p / took**i for i, p in enumerate(minimum_jerk(np.clip(r / OVERLAP, 0, 1))))
    ahead = np.clip((r - (1 - OVERLAP)) / OVERLAP, 0, 1)
    grown = [part / took**i for i, part in enumerate(minimum_jerk(ahead))]
    left = [1 - shrunk, *(-part for part in shrinks)]
    for share, one, middle in ((left, before, middles[0]), (grown, after, middles[1])):
        away = one.x - middle
        parts[0] = parts[0] + share[0] * away
        parts[1] = parts[1] + share[0] * one.dx + share[1] * away
        parts[2] = parts[2] + share[0] * one.ddx + 2 * share[1] * one.dx + share[2] * away
    x, dx, ddx = parts
    return of_rates(x, dx, ddx, after.rotates)


def _with_rates(samples: Samples) -> Samples:
    """With the rotation vector's own derivatives in place of angular velocity and acceleration."""
    x, dx, ddx = samples.x, samples.dx.copy(), samples.ddx.copy()
    dx[:, -3:], ddx[:, -3:] = rotations.to_rates(x[:, -3:], dx[:, -3:], ddx[:, -3:])
    return Samples(x, dx, ddx, True)
