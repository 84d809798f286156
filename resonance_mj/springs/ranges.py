"""Between which stiffnesses the best springs may lie, and cost hardly more."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, cast

import numpy as np

from .bounds import JointBounds
from .elements import NO_ELEMENTS, Element
from .fit import fit, reach
from .material import Material
from .spring import STILL

if TYPE_CHECKING:
    from .optimum import Optimum

SEARCHES, LARGEST = 12, 1e9
"""Halvings of the interval in which the end of a range is looked for, and how far away at most
[N m/rad]."""


def stiffness_range(best: Optimum, rise: float) -> np.ndarray:
    """`Optimum.stiffness_range`: in closed form of torque², and else by search."""
    bounds = best.bounds
    if bounds.objective is not None or bounds.material is not None or bounds.resolution:
        return _searched(best, rise * best.rate(best.torque_without_springs))
    mean = best.q.mean(axis=0)
    low, high = reach(bounds, mean)
    others = best.springs.others
    needed = best.torque_without_springs
    needed = needed - others.torque(best.q) if others.elements else needed
    z, level = best.q - mean, needed.mean(axis=0)
    rest = needed - level
    allowed = rise * best.torque_squared_without_springs
    most = (best.torque**2).mean(axis=0) + allowed
    ends = np.stack([np.broadcast_to(end, level.shape) for end in bounds.stiffness], axis=1)
    squared, both, alone = (z**2).mean(axis=0), (z * rest).mean(axis=0), (rest**2).mean(axis=0)
    for j in np.flatnonzero(squared > STILL):

        def beyond(k: float, j: int = int(j)) -> float:
            """How far torque² is above the most with a stiffness and its best offset."""
            bounded = np.isfinite(low[j]) and np.isfinite(high[j])
            reachable = (k * low[j], k * high[j]) if bounded else (-np.inf, np.inf)
            miss = min(max(level[j], reachable[0]), reachable[1]) - level[j]
            return float(squared[j] * k**2 + 2 * both[j] * k + alone[j] + miss**2 - most[j])

        # It exceeds that of the best k* by var(q) (k - k*)² at least.
        at, furthest = best.stiffness[j], np.sqrt(allowed / squared[j])
        for side, bound in enumerate(ends[j]):
            end = bound
            if abs(bound - at) > furthest:
                end = at + (2 * side - 1) * 1.001 * furthest
            if beyond(end) > 0:
                ends[j, side] = _crossing(beyond, at, end)
    return ends


def _searched(best: Optimum, allowed: float) -> np.ndarray:
    bounds, n = cast("JointBounds", best.bounds), best.q.shape[1]
    most = best.rate(best.torque) + allowed
    ends = np.stack([np.broadcast_to(end, n) for end in bounds.stiffness], axis=1)
    needed = best.torque + replace(best.springs, others=NO_ELEMENTS).torque(best.q, best.dq)
    for j in np.flatnonzero(best.q.var(axis=0) > STILL):

        def beyond(k: float, j: int = int(j)) -> float:
            """How far the cost is above the most with a stiffness and its best offset."""
            given = [np.broadcast_to(end, n).copy() for end in bounds.stiffness]
            given[0][j] = given[1][j] = k
            within = bounds._replace(stiffness=(given[0], given[1]), elements=())
            others = np.arange(n) != j
            for end in within.stiffness:
                end[others] = best.stiffness[others]
            left = best.torque.copy()
            if bounds.material is not None:  # which is fitted joint by joint
                left[:, j] = _left(best, needed, j, k)
            else:
                spring = fit(best.q, needed, within, best.center, best.dq)
                left[:, j] = (needed - spring.torque(best.q))[:, j]
            return best.rate(left) - most

        ends[j] = _between(beyond, float(best.stiffness[j]), *ends[j].tolist())
    return ends


def ranges_of_elements(best: Optimum, rise: float) -> list[tuple[float, float] | None]:
    """The same of each element besides, the others and the joints' springs as they are.

    Args:
        best: the optimum.
        rise: how much more they cost at most, as a share of what none cost.

    Returns:
        Least and greatest [N/m] of each; None for a cubic one, which has no one stiffness.
    """
    bounds, n = cast("JointBounds", best.bounds), best.q.shape[1]
    none = np.zeros(n)
    alone = bounds._replace(
        stiffness=(none, none), equilibrium=(none, none), about_zero=np.zeros(n, bool)
    )
    most = best.rate(best.torque) + rise * best.rate(best.torque_without_springs)
    found: list[tuple[float, float] | None] = []
    for element, p in best.springs.others.each():
        if element.kind == "cubic":
            found.append(None)
            continue
        needed = best.torque + np.outer(element.exerted(best.q, p), element.radii)

        def beyond(k: float, element: Element = element, needed: np.ndarray = needed) -> float:
            """How far the cost is above the most with a stiffness and its best rest."""
            within = alone._replace(elements=(element._replace(stiffness=(k, k)),))
            spring = fit(best.q, needed, within, best.center, best.dq)
            return best.rate(needed - spring.torque(best.q)) - most

        low, high = element.stiffness
        if element.pair is not None:
            low = max(low, element.softest(best.q))
        found.append(_between(beyond, float(p[0]), low, high))
    return found


def _between(
    beyond: Callable[[float], float], at: float, low: float, high: float
) -> tuple[float, float]:
    """The ends of what is not beyond about a stiffness, at most from low to high, by search."""
    ends = []
    for sign, bound in ((-1, low), (1, high)):
        end, step = at, max(abs(at), 1e-3) / 8
        while end != bound and beyond(end) <= 0 and step < LARGEST:
            end, step = float(np.clip(at + sign * step, low, high)), 2 * step
        ends.append(_crossing(beyond, at, end, SEARCHES) if beyond(end) > 0 else bound)
    return ends[0], ends[1]


def _left(best: Optimum, needed: np.ndarray, j: int, k: float) -> np.ndarray:
    """What a spring of a material, of a stiffness, leaves at best of a joint's torque (N,)."""
    bounds = cast("JointBounds", best.bounds)
    one, rates = slice(j, j + 1), tuple(each[j : j + 1] for each in bounds.material or ())
    ends = tuple(np.broadcast_to(end, best.q.shape[1])[one] for end in bounds.equilibrium)
    fixed = np.array([k])
    own = JointBounds(
        (fixed, fixed), (ends[0], ends[1]), bounds.about_zero[one], material=Material(*rates)
    )
    spring = fit(best.q[:, one], needed[:, one], own, best.center[one], best.dq[:, one])
    return (needed[:, one] - spring.torque(best.q[:, one], best.dq[:, one]))[:, 0]


def _crossing(
    beyond: Callable[[float], float], inside: float, outside: float, times: int = 60
) -> float:
    """Where an increasing function passes zero between two points, to rounding."""
    for _ in range(times):
        middle = (inside + outside) / 2
        inside, outside = (inside, middle) if beyond(middle) > 0 else (middle, outside)
    return inside
