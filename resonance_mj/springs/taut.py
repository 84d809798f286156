"""Antagonistic pairs at their best, of which no tendon is slack along a motion.

What a pair may be is not convex in what its torque is linear in, but for the tangents about one
stiffness (`antagonist`). The best springs within these are what the next ones are about, each time
with less left, until the stiffness that is found is that about which it was sought: the
convex-concave procedure (Yuille and Rangarajan, Neural Computation 15, 2003), by the secant.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from .antagonist import Pair
from .elements import Element, Elements

ROUNDS, SETTLED = 50, 1e-6
"""Most times that springs are sought, and the relative change of stiffness that is none."""

STEEPEST = 0.98
"""Most that a stiffness found is taken to follow that about which it was sought."""


def linear(
    elements: tuple[Element, ...],
    q: np.ndarray,
    best: Callable[[tuple[Element, ...]], Elements],
) -> tuple[Element, ...]:
    """The elements with each pair as the linear one that it is while taut, about the best.

    Args:
        elements: pairs among others.
        q: joint angles over a cycle (N, n) [rad].
        best: finds the best parameters of elements without pairs.
    """
    pairs = [at for at, one in enumerate(elements) if one.pair]
    ends = [(float(x.min()), float(x.max())) for x in (q @ one.radii for one in elements)]

    def about(stiffness: np.ndarray) -> tuple[Element, ...]:
        found = list(elements)
        for at, k in zip(pairs, stiffness, strict=True):
            found[at] = _linear(elements[at], k, *ends[at])
        return tuple(found)

    free = best(tuple(one._replace(pair=None) for one in elements)).each()
    softest = np.array([_softest(elements[at], *ends[at]) for at in pairs])
    taut = [_softest(elements[at], *ends[at], free[at][0].rests(free[at][1])[1]) for at in pairs]
    sought, before = np.maximum(taut, [free[at][1][0] for at in pairs]), None
    for _ in range(ROUNDS):
        each = best(about(sought)).each()
        k = np.array([each[at][1][0] for at in pairs])
        if np.allclose(k, sought, rtol=SETTLED, atol=0.0):
            break
        slope = np.zeros_like(k)
        if before is not None:
            apart = sought - before[0]
            slope = np.divide(k - before[1], apart, out=slope, where=apart != 0)
        before = sought, k
        sought = np.maximum(sought + (k - sought) / (1 - np.clip(slope, 0.0, STEEPEST)), softest)
    return about(sought)


def _softest(one: Element, low: float, high: float, rest: float | None = None) -> float:
    """The least stiffness with which a pair is taut, or its greatest if that is less.

    Args:
        one: the pair.
        low: least length along the motion.
        high: greatest length.
        rest: length at which it rests; that with the least stiffness if not given.
    """
    rest = (low + high) / 2 if rest is None else rest
    rest = float(np.clip(rest, *(one.rest or (-np.inf, np.inf))))
    return min(cast("Pair", one.pair).softest(rest, low, high), one.stiffness[1])


def _linear(one: Element, k: float, low: float, high: float) -> Element:
    """A pair as a linear element, with what keeps it taut about a stiffness."""
    pair = cast("Pair", one.pair)
    further = pair.limits(k, one.center, *pair.held(k, low, high))
    return one._replace(pair=None, further=further)
