"""Elastic elements over any joints: the torque of each is linear in its parameters.

An element has a length l = Σ r_j q_j over joints of radius r_j, and exerts a force f(l) along it,
the torque r_j f(l) at each joint. With x = l - c about a given length c it is

    linear   f = p_0 - k x
    cubic    f = p_0 - k_1 x - k_2 x² - k_3 x³
    above    f = -k max(x, 0), and below f = -k min(x, 0)

and an antagonistic pair of tendons that stiffen is a linear one as long as neither is slack.

What an element may be is a convex set of parameters p, the rows A p <= b of `limits`: of a cubic
one the stiffness -df/dl wherever its joints can go is within its bounds, so that with a lower bound
of 0 its potential is convex. The joints' own springs are the case that `fit` solves in closed form.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .antagonist import Pair
from .spring import equilibrium

LOOKED_AT = 17
"""Lengths at which the stiffness of a cubic element is bounded from the first."""

PARAMETERS = {
    "linear": ("stiffness", "force"),
    "cubic": ("stiffness", "quadratic", "cubic", "force"),
    "above": ("stiffness",),
    "below": ("stiffness",),
    "antagonistic": ("stiffness", "force"),
}
"""Of each kind of element: k, or k_1, k_2, k_3, and p_0."""


class Element(NamedTuple):
    """An elastic element on an arm of n joints."""

    name: str
    kind: str
    radii: np.ndarray
    """r (n,), 0 for joints that it does not act on [m], or 1 for a length in radians."""
    stiffness: tuple[float, float]
    """Least and greatest stiffness [N/m]."""
    rest: tuple[float, float] | None
    """Least and greatest rest length; None for any."""
    center: float
    """c, about which the parameters are."""
    travel: tuple[float, float]
    """Lengths between which the joints can bring it."""
    pair: Pair | None = None
    """Of an antagonistic one, its tendons."""
    further: tuple[np.ndarray, np.ndarray] | None = None
    """Further rows of A p <= b."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of its parameters."""
        return PARAMETERS[self.kind]

    def length(self, q: np.ndarray) -> np.ndarray:
        """How far l is from c: x at joint angles (..., n): (...,)."""
        return q @ self.radii - self.center

    def forces(self, q: np.ndarray) -> np.ndarray:
        """df/dp, what each parameter exerts along the length at joint angles (N, n): (N, p)."""
        x = self.length(q)
        if self.kind == "above":
            return -np.maximum(x, 0.0)[:, None]
        if self.kind == "below":
            return -np.minimum(x, 0.0)[:, None]
        powers = -np.cumprod(np.broadcast_to(x, (len(self.parameters) - 1, *x.shape)), axis=0)
        return np.stack([*powers, np.ones_like(x)], axis=1)

    def exerted(self, q: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """What it exerts along its length at joint angles (N, n): (N,)."""
        if self.pair is None:
            return self.forces(q) @ parameters
        return self.pair.force(q @ self.radii, self.pair.ends(*self.rests(parameters)))

    def rests(self, parameters: np.ndarray) -> tuple[float, float]:
        """Stiffness and rest length, of a cubic one those of its linear part."""
        if len(parameters) == 1:
            return float(parameters[0]), self.center
        return equilibrium(parameters[0], parameters[-1], self.center)

    def softest(self, q: np.ndarray, rest: float | None = None) -> float:
        """Least stiffness with which a pair is taut along joint angles (N, n) [N/m].

        Args:
            q: joint angles.
            rest: length at which it rests; that with the least stiffness if not given.
        """
        assert self.pair is not None
        low, high = self.ends(q)
        rest = (low + high) / 2 if rest is None else rest
        return self.pair.softest(float(np.clip(rest, *(self.rest or (-np.inf, np.inf)))), low, high)

    def ends(self, q: np.ndarray) -> tuple[float, float]:
        """Least and greatest length at joint angles (N, n)."""
        length = q @ self.radii
        return float(length.min()), float(length.max())

    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """A (rows, p) and b (rows,) of A p <= b: what its parameters may be."""
        low, high = self.stiffness
        at = np.linspace(*self.travel, LOOKED_AT if self.kind == "cubic" else 1)
        slopes = self.slopes(at)
        rows, ends = [*-slopes, *slopes], [-low] * len(at) + [high] * len(at)
        if self.rest is not None and len(self.parameters) > 1:
            # k (rest - c) between the bounds of the rest length.
            first, last = (end - self.center for end in self.rest)
            middle = [0.0] * (len(self.parameters) - 2)
            rows += [np.array([first, *middle, -1.0]), np.array([-last, *middle, 1.0])]
            ends += [0.0, 0.0]
        if self.further is not None:
            rows, ends = [*rows, *self.further[0]], [*ends, *self.further[1]]
        finite = np.isfinite(ends)
        return np.array(rows)[finite], np.array(ends)[finite]

    def slopes(self, length: np.ndarray) -> np.ndarray:
        """What each parameter adds to the stiffness -df/dl at lengths (N,): (N, p)."""
        powers = len(self.parameters) - 1
        x = length - self.center
        rates = [np.ones_like(x), *(power * x ** (power - 1) for power in range(2, powers + 1))]
        return np.stack([*rates, *[np.zeros_like(x)] * bool(powers)], axis=1)

    def within(self, parameters: np.ndarray) -> np.ndarray:
        """Parameters that are within the bounds but for rounding, within them to the last bit."""
        if self.kind == "cubic":
            return parameters
        k = np.clip(parameters[0], *self.stiffness)
        if len(parameters) == 1 or self.rest is None:
            return np.array([k, *parameters[1:]])
        low, high = (k * (end - self.center) for end in self.rest)
        return np.array([k, np.clip(parameters[1], low, high)])

    def extremes(self, parameters: np.ndarray) -> np.ndarray:
        """Lengths at which a cubic element's stiffness is least or greatest (at most 3,)."""
        _, quadratic, cubic, _ = parameters
        ends = list(self.travel)
        turns = self.center - quadratic / (3 * cubic) if cubic else np.inf
        return np.array([*ends, turns] if self.travel[0] < turns < self.travel[1] else ends)


class Elements(NamedTuple):
    """Elements with the parameters that they have."""

    elements: tuple[Element, ...] = ()
    parameters: np.ndarray = np.empty(0)
    """Of all elements in a row (P,)."""

    def torque(self, q: np.ndarray) -> np.ndarray:
        """Torque that they exert at joint angles (N, n): (N, n) [N m]."""
        if not any(one.pair for one in self.elements):
            return regressor(self.elements, q) @ self.parameters
        along = [one.exerted(q, p)[:, None] * one.radii for one, p in self.each()]
        return np.sum(along, axis=0)

    def each(self) -> list[tuple[Element, np.ndarray]]:
        """The elements, each with its own parameters."""
        ends = np.cumsum([0, *(len(one.parameters) for one in self.elements)])
        parts = [self.parameters[start:end] for start, end in pairwise(ends)]
        return list(zip(self.elements, parts, strict=True))

    def rest(self) -> list[float]:
        """Rest length of each; of a cubic one that of its linear part."""
        return [one.rests(p)[1] for one, p in self.each()]


NO_ELEMENTS = Elements()


def regressor(elements: tuple[Element, ...], q: np.ndarray) -> np.ndarray:
    """What each parameter exerts at each joint at joint angles (N, n): (N, n, P) [N m]."""
    found, at = np.zeros((*q.shape, sum(len(one.parameters) for one in elements))), 0
    for one in elements:
        mine = slice(at, at + len(one.parameters))
        at, forces = mine.stop, one.forces(q)
        for j in np.flatnonzero(one.radii):
            found[:, j, mine] = one.radii[j] * forces
    return found


def names(elements: tuple[Element, ...]) -> list[str]:
    """Names of all parameters in a row, as ELEMENT.PARAMETER."""
    return [f"{one.name}.{parameter}" for one in elements for parameter in one.parameters]
