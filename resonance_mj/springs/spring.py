"""A joint's adjustable spring: its torque, its equilibrium angle, and what it can do at all.

A spring is the pair (k, q̄_e) of stiffness [N m/rad] and offset torque [N m] about a centre q_c:
it exerts -k (q - q_c) + q̄_e, which is -k (q - q_e) with q_e = q̄_e / k + q_c (Sec. IV-B).

Bounds on k and on q_e - q_c make a convex polygon of pairs (k, q̄_e): a part of the cone
k (q_e,min - q_c) <= q̄_e <= k (q_e,max - q_c). At its apex, k = 0, a spring exerts nothing.

The functions are plain Python and compile under Numba when compiled code calls them.
"""

import math

import numpy as np

from ..step_functions import step_function

STILL = 1e-8
"""Variance of a joint angle [rad²] up to which the joint stands still: a tenth of a milliradian. It
needs no stiffness, only an offset: torque over angle is arbitrary there."""

LIMP = 1e-12
"""Stiffness [N m/rad] in place of 0 where a spring without bounds must exert an offset torque."""


@step_function
def torque(k: np.ndarray, offset: np.ndarray, q: np.ndarray, q_c: np.ndarray) -> np.ndarray:
    """Torque -k (q - q_c) + q̄_e of a spring [N m]."""
    return offset - k * (q - q_c)


@step_function
def equilibrium(k: float, offset: float, q_c: float) -> tuple[float, float]:
    """Stiffness to write and equilibrium angle q_e = q̄_e / k + q_c of a spring.

    Returns:
        k [N m/rad], which is `LIMP` instead of 0 if the offset torque is not 0, and q_e [rad].
    """
    if k == 0.0:
        if offset == 0.0:
            return 0.0, q_c
        k = LIMP
    return k, offset / k + q_c


def equilibrium_angles(
    k: np.ndarray, offset: np.ndarray, center: np.ndarray, limp: float = LIMP
) -> np.ndarray:
    """Equilibrium angles of many springs, broadcast (..., n) [rad]; `equilibrium` has it of one.

    Args:
        k: stiffness (..., n) [N m/rad].
        offset: offset torque about `center` (..., n) [N m].
        center: q_c (..., n) [rad].
        limp: stiffness in place of 0 where a spring pushes; with 0 its angle is inf or -inf.
    """
    k = np.where((k == 0) & (offset != 0), limp, k)
    with np.errstate(divide="ignore"):
        return np.divide(offset, k, out=np.zeros_like(k), where=(k != 0) | (offset != 0)) + center


@step_function
def nearest(
    k: float, offset: float, k_min: float, k_max: float, low: float, high: float, weight: float
) -> tuple[float, float]:
    """The feasible spring nearest to (k, q̄_e) in the metric weight (Δk)² + (Δq̄_e)².

    With weight = var(q) it is the projection of the cost (3), with weight = γ_qe / γ_k that of the
    Lyapunov function (16): the distance to any feasible spring, the optimum included, never grows.

    Args:
        k: stiffness [N m/rad].
        offset: offset torque q̄_e [N m].
        k_min: lower bound of k [N m/rad]; at least 0 if `low` and `high` are finite.
        k_max: upper bound of k [N m/rad].
        low: lower bound of q_e - q_c [rad]; -inf for none.
        high: upper bound of q_e - q_c [rad]; inf for none.
        weight: weight of the stiffness [rad^2].

    Returns:
        Stiffness [N m/rad] and offset torque [N m].
    """
    inside = min(max(k, k_min), k_max)
    if not (math.isfinite(low) and math.isfinite(high)):
        return inside, offset
    if inside == k and k * low <= offset <= k * high:
        return k, offset
    # Outside: the nearest point lies on one of the edges, two of the cone and two of the stiffness.
    best_k, best_offset, best = inside, min(max(offset, inside * low), inside * high), math.inf
    for edge in range(4):
        if edge < 2:
            slope = low if edge == 0 else high
            if weight + slope * slope == 0.0:
                continue
            at_k = (weight * k + slope * offset) / (weight + slope * slope)
            at_k = min(max(at_k, k_min), k_max)
            at_offset = slope * at_k
        else:
            at_k = k_min if edge == 2 else k_max
            if not math.isfinite(at_k):
                continue
            at_offset = min(max(offset, at_k * low), at_k * high)
        distance = weight * (at_k - k) ** 2 + (at_offset - offset) ** 2
        if distance < best:
            best_k, best_offset, best = at_k, at_offset, distance
    return best_k, best_offset
