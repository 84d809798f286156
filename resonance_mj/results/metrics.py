"""How good a run is: torque against the optimum, cycles until the optimum is reached."""

import numpy as np
from numpy.typing import ArrayLike

OPTIMUM_BAND = 0.05
"""Relative distance from the optimal torque² within which a cycle counts as at the optimum."""

NO_TORQUE = 1e-4
"""Share of torque² without springs below which two torques² are both nothing, and the same."""

TRACKING = 0.02
"""RMS error up to which a tool follows its path, as a share of the path's size; of rotation, which
has no size, in radians."""

LEAST_REDUCTION = 1e-9
"""Reduction of the optimum below which no spring helps, and a share of it means nothing."""


def reduction(torque_squared: ArrayLike, without: ArrayLike) -> np.ndarray:
    """1 - torque² / torque² without springs; NaN where no torque is needed.

    Args:
        torque_squared: of motors beside springs [N² m²].
        without: of motors without springs, broadcast [N² m²].
    """
    torque_squared, without = np.asarray(torque_squared, float), np.asarray(without, float)
    none = np.full(np.broadcast_shapes(torque_squared.shape, without.shape), np.nan)
    return 1.0 - np.divide(torque_squared, without, out=none, where=without > 0)


def share(reduced: ArrayLike, optimal: ArrayLike) -> np.ndarray:
    """A reduction as a share of that of the optimum; NaN where no spring helps."""
    reduced, optimal = np.asarray(reduced, float), np.asarray(optimal, float)
    none = np.full(np.broadcast_shapes(reduced.shape, optimal.shape), np.nan)
    return np.divide(reduced, optimal, out=none, where=optimal > LEAST_REDUCTION)


def tracks(
    position: ArrayLike,
    size: float,
    rotation: ArrayLike | None = None,
    joints: tuple[ArrayLike, float] | None = None,
) -> np.ndarray:
    """Whether a tool follows its path: to 2 % of the path's size, and 20 mrad.

    Of a task of the joints, whether these do, to 2 % of the widest swing among them.

    Args:
        position: RMS error of cycles (C,) [m].
        size: of the path [m].
        rotation: RMS error of the rotation (C,) [rad]; None for a task without.
        joints: RMS error of the joints (C,) and the widest swing [rad]; None for a task of the
            tool.
    """
    if joints is not None:
        return np.asarray(joints[0]) <= TRACKING * joints[1]
    follows = np.asarray(position) <= TRACKING * size
    return follows if rotation is None else follows & (np.asarray(rotation) <= TRACKING)


def cycles_to_optimum(
    cost: np.ndarray, optimal: float, without: float, tracks: np.ndarray
) -> int | None:
    """First cycle, counted from 1, from which the cost stays within 5 % of the optimum's.

    A cycle that does not track, or is below the band, counts as outside: it costs less
    because it makes another motion.

    Args:
        cost: torque² or another, per cycle of one motion (cycles,).
        optimal: of the optimum.
        without: of the motion without springs.
        tracks: whether the tool follows its path in each cycle (cycles,).

    Returns:
        The cycle, or None if the last cycle is outside, or the motion costs nothing.
    """
    if not without > 0:
        return None
    near = np.abs(cost - optimal) <= max(OPTIMUM_BAND * optimal, NO_TORQUE * without)
    outside = np.flatnonzero(~(near & tracks))
    first = int(outside[-1]) + 1 if outside.size else 0
    return first + 1 if first < len(cost) else None
