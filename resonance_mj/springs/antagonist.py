"""Two tendons that stiffen and pull against each other: their rest lengths set k and q_e.

Each pulls with a x + b x² where it is stretched by x. Along the element's length l one is stretched
by l - r_1, the other by r_2 - l, and as long as neither is slack

    f = -(a + b s) (2 l - r_1 - r_2),  s = r_2 - r_1,

which is a linear spring of stiffness k = 2 (a + b s) that rests at (r_1 + r_2) / 2: pulled in
together they stiffen the joint, moved together they turn its equilibrium. This is why stiffening
tendons are needed, and why those that stiffen evenly (b x²) decouple the two.

Both are taut between lengths l_1 and l_2 where r_1 <= l_1 and r_2 >= l_2. In (k, rest) that is
convex; in (k, p_0 = k (rest - c)), in which the torque is linear, it is what lies between two
parabolas that are curved the other way. `limits` has their tangents: they allow less, never more,
and what is best within them leaves less at each round in which they are taken where it was.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class Pair(NamedTuple):
    """The tendons of an antagonistic pair, which are alike."""

    rate: float
    """a [N/m]."""
    hardening: float
    """b [N/m²]."""
    pretension: float = 0.0
    """What each pulls with at least [N]."""
    holding: float = 0.0
    """Power that an actuator takes to hold a tension, over its square [W/N²]."""

    @property
    def stretch(self) -> float:
        """How far each is stretched at least [m]."""
        a, b = self.rate, self.hardening
        return (math.sqrt(a * a + 4 * b * self.pretension) - a) / (2 * b)

    def ends(self, k: float, rest: float) -> tuple[float, float]:
        """Rest lengths r_1 and r_2 of the two, of a pair of stiffness k that rests at a length."""
        half = (k / 2 - self.rate) / (2 * self.hardening)
        return rest - half, rest + half

    def spring(self, ends: tuple[float, float]) -> tuple[float, float]:
        """Stiffness and length at rest of the pair, of the rest lengths of the two."""
        k = 2 * (self.rate + self.hardening * (ends[1] - ends[0]))
        return k, (ends[0] + ends[1]) / 2

    def tension(self, length: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
        """What each pulls with at lengths (N,), 0 where it is slack: (N, 2) [N]."""
        x = self._stretched(length, ends)
        return self.rate * x + self.hardening * x**2

    def stored(self, length: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
        """What each stores (N, 2) [J]; arguments as in `tension`."""
        x = self._stretched(length, ends)
        return self.rate * x**2 / 2 + self.hardening * x**3 / 3

    def force(self, length: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
        """What both exert along the length (N,) [N], slack or not."""
        first, second = self.tension(length, ends).T
        return second - first

    def slack(self, length: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
        """How far each hangs loose at lengths (N,): (N, 2) [m]."""
        return self._stretched(-np.asarray(length), (-ends[0], -ends[1]))

    def softest(self, rest: float, low: float, high: float) -> float:
        """Least stiffness with which a pair that rests at a length is taut from low to high."""
        half = max(rest - low, high - rest) + self.stretch
        return 2 * self.rate + 4 * self.hardening * half

    def held(self, k: float, low: float, high: float) -> tuple[float, float]:
        """The middle of lengths from low to high, as far as a pair of stiffness k is taut."""
        middle = (low + high) / 2
        half = min((high - low) / 2, (k / 2 - self.rate) / (2 * self.hardening) - self.stretch)
        return middle - max(half, 0.0), middle + max(half, 0.0)

    def limits(
        self, k: float, center: float, low: float, high: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """A (2, 2) and b (2,) of A (k, p_0) <= b: taut from low to high, by the tangents at k."""
        a, b = self.rate, self.hardening
        slope = (k - a) / (2 * b)
        first, last = low - self.stretch - center, high + self.stretch - center
        rows = np.array([[-(first + slope), 1.0], [-(slope - last), -1.0]])
        return rows, np.full(2, -(k**2) / (4 * b))

    def _stretched(self, length: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
        length = np.asarray(length)
        return np.maximum(np.stack([length - ends[0], ends[1] - length], axis=-1), 0.0)
