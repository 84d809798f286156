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

    def about(stiffness: np.ndarray) -> tuple[Element, ...]:
        found = list(elements)
        for at, k in zip(pairs, stiffness, strict=True):
            found[at] = _linear(elements[at], k, q)
        return tuple(found)

    def softest(at: int, rest: float | None = None) -> float:
        return min(elements[at].softest(q, rest), elements[at].stiffness[1])

    free = best(tuple(one._replace(pair=None) for one in elements)).each()
    taut = [softest(at, free[at][0].rests(free[at][1])[1]) for at in pairs]
    least = np.array([softest(at) for at in pairs])
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
        sought = np.maximum(sought + (k - sought) / (1 - np.clip(slope, 0.0, STEEPEST)), least)
    return about(sought)


def _linear(one: Element, k: float, q: np.ndarray) -> Element:
    """A pair as a linear element, with what keeps it taut about a stiffness."""
    pair = cast("Pair", one.pair)
    further = pair.limits(k, one.center, *pair.held(k, *one.ends(q)))
    return one._replace(pair=None, further=further)
