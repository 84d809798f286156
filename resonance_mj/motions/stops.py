"""Point to point: the tool moves from one point to the next with minimum jerk, and rests there."""

from __future__ import annotations

import numpy as np

from ..experiments.motion_section import Motion
from .minimum_jerk import minimum_jerk


def point_to_point(motion: Motion, steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, dx/dt and d²x/dt² over a cycle (N, m), which begins where the tool rests at the first.

    Each move takes x from a point to the next, from the last to the first again, along a straight
    line with the share σ = 10 r³ - 15 r⁴ + 6 r⁵ of the way at the share r of its time: velocity and
    acceleration are zero at both ends.

    Args:
        motion: of shape "points".
        steps: N, equal time steps of its cycle.
    """
    points = np.array(motion.points)
    rests, moves = motion.phases()
    # When each point is reached, and left; the first is reached at 0.
    leaves = np.cumsum(rests + np.concatenate([[0.0], moves[:-1]]))
    t = motion.period * np.arange(steps) / steps
    k = np.clip(np.searchsorted(leaves, t, side="right") - 1, 0, None)  # the last that was left
    r = np.clip((t - leaves[k]) / moves[k], 0.0, 1.0)[:, None]
    way = (np.roll(points, -1, axis=0) - points)[k]
    rate = (1.0 / moves[k])[:, None]
    sigma, d_sigma, dd_sigma = minimum_jerk(r)
    return points[k] + sigma * way, rate * d_sigma * way, rate**2 * dd_sigma * way
