"""The springs that take the most of a torque: the least squares of (3), in (k, q̄_e).

There ∫τᵀτ dt is a convex quadratic, separate for each joint, and the springs' bounds are a convex
polygon, so that the best springs are unique: linear least squares, and with bounds the feasible
point nearest to it in the metric of the cost. The total torque along a motion does not depend on
who exerts it: the transfer law, the optimum and the certificates all ask the same of `fit`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from . import material, program, spring, taut
from .bounds import Bounds, JointBounds, steps
from .cost import Cost, usual_torque
from .elements import NO_ELEMENTS, Element, Elements
from .least_peak import least_peak
from .material import Material


@dataclass(frozen=True)
class LinearSprings:
    """One spring per joint: each exerts -k (q - q_c) + q̄_e; and elements besides.

    Unpacked, it is the stiffness, offset and centre of the joints' own springs.
    """

    stiffness: np.ndarray
    """k (n,) [N m/rad]."""
    offset: np.ndarray
    """Offset torque q̄_e about `center` (n,) [N m]."""
    center: np.ndarray
    """Centre q_c (n,) [rad]."""
    others: Elements = NO_ELEMENTS
    """Elements over any joints."""
    material: Material | None = None
    """What the joints' own springs do besides Hooke's law; None for nothing."""

    def __iter__(self) -> Iterator[np.ndarray]:
        """Stiffness, offset and centre (n,) each."""
        return iter((self.stiffness, self.offset, self.center))

    def torque(self, q: np.ndarray, dq: np.ndarray | None = None) -> np.ndarray:
        """Torque at joint angles (N, n) [N m].

        Args:
            q: joint angles (N, n) [rad].
            dq: joint velocities (N, n) [rad/s], which springs of a material depend on.
        """
        if self.material is None:
            own = spring.torque(self.stiffness, self.offset, q, self.center)
        else:
            assert dq is not None
            own = self.material.torque(self.stiffness, self.offset, self.center, q, dq)
        return own + self.others.torque(q) if self.others.elements else own

    def about(self, center: np.ndarray) -> LinearSprings:
        """The same springs, their offset torque about another centre (n,) [rad]."""
        offset = self.offset + self.stiffness * (self.center - center)
        return replace(self, offset=offset, center=center)


SPRINGS = ("stiffness", "offset", "center")
"""The arrays of `LinearSprings`, (n,) each."""


def fit(
    q: np.ndarray,
    torque: np.ndarray,
    bounds: Bounds,
    center: np.ndarray,
    dq: np.ndarray | None = None,
) -> LinearSprings:
    """The feasible constant springs that leave the least ∫(τ - τ_s)ᵀ(τ - τ_s) dt of a torque τ.

    Or the least of `bounds.objective`, if that is another.

    Args:
        q: joint angles over a cycle, equally spaced in time (N, n) [rad].
        torque: torque along it, of motor and spring together (N, n) [N m].
        bounds: of the stiffness and of the equilibrium angle.
        center: q_c, about which the offset torque is given (n,) [rad].
        dq: joint velocities along it (N, n) [rad/s], which costs of power depend on.

    Note:
        A joint that stands still gets no stiffness: torque over angle is arbitrary there.

    Raises:
        ValueError: no elements are within all of their bounds.
    """

    def of(others: JointBounds) -> LinearSprings:
        return fit(q, torque, others, center, dq)

    def left(springs: LinearSprings) -> np.ndarray:
        return np.asarray(((torque - springs.torque(q, dq)) ** 2).mean(axis=0))

    if bounds.resolution:
        return _in_steps(cast("JointBounds", bounds), of, left)
    if any(one.pair for one in bounds.elements):
        return _taut(cast("JointBounds", bounds), of, q)
    if bounds.material is not None:
        assert dq is not None
        return _of_material(q, torque, dq, bounds, bounds.material).about(center)
    if bounds.objective is not None:
        return _least(q, torque, bounds, bounds.objective, dq).about(center)
    if bounds.elements:
        return _together(q, torque, bounds).about(center)
    return feasible(asked_for(q, torque), q, bounds, center)


def _in_steps(
    bounds: JointBounds,
    of: Callable[[JointBounds], LinearSprings],
    left: Callable[[LinearSprings], np.ndarray],
) -> LinearSprings:
    """The best springs whose stiffness is set in steps: joint by joint one of the two next to it.

    Torque² is convex in the stiffness of each joint with its best offset.

    Args:
        bounds: of which the springs shall be the best.
        of: the best within others.
        left: torque² that springs leave of each joint (n,).
    """
    any_ = bounds._replace(resolution=0.0)
    low, high = steps(bounds, of(any_).stiffness)
    fixed = [any_._replace(stiffness=(k, k)) for k in (low, high)]
    below, above = (left(of(each)) for each in fixed)
    best = np.where(above < below, high, low)
    return of(any_._replace(stiffness=(best, best)))


def _taut(
    bounds: JointBounds, of: Callable[[JointBounds], LinearSprings], q: np.ndarray
) -> LinearSprings:
    """The best springs with antagonistic pairs of which no tendon is slack; arguments likewise."""

    def others(elements: tuple[Element, ...]) -> Elements:
        return of(bounds._replace(elements=elements)).others

    found = of(bounds._replace(elements=taut.linear(bounds.elements, q, others)))
    return replace(found, others=Elements(bounds.elements, found.others.parameters))


def _of_material(
    q: np.ndarray, torque: np.ndarray, dq: np.ndarray, bounds: Bounds, given: Material
) -> LinearSprings:
    """The best springs of a material, about the mean angle."""
    mean, n = q.mean(axis=0), q.shape[1]
    ends = tuple(np.broadcast_to(mean + end, n) for end in reach(bounds, mean))
    within = [np.broadcast_to(end, n) for end in bounds.stiffness]
    shapes = [given.of_joint(j) for j in range(n)]
    k, q_e = material.best(q, torque, dq, shapes, (within[0], within[1]), (ends[0], ends[1]))
    return LinearSprings(k, k * (q_e - mean), mean, material=given)


def nearest_to_nothing(bounds: Bounds, n: int) -> Elements:
    """The elements (of an arm of n joints) that exert least and are within their bounds."""
    still = np.zeros((1, n))
    return _together(still, still, bounds).others if bounds.elements else Elements()


def columns(q: np.ndarray, bounds: Bounds) -> program.Columns:
    """What springs and elements do along joint angles (N, n), and what they may be."""
    n, mean = q.shape[1], q.mean(axis=0)
    low, high = (np.broadcast_to(end, n) for end in reach(bounds, mean))
    least, most = (np.broadcast_to(end, n) for end in bounds.stiffness)
    return program.columns(q, bounds.elements, (least, most), (low, high))


def _together(q: np.ndarray, torque: np.ndarray, bounds: Bounds) -> LinearSprings:
    """The best springs and elements, about the mean angle."""
    given, first = columns(q, bounds), 2 * q.shape[1]
    weighed = torque
    if bounds.weights is not None:
        root = np.sqrt(bounds.weights)
        rows = np.tile(root, len(q))[:, None]
        given, weighed = given._replace(torque=rows * given.torque), root * torque
    best = program.best(given, weighed.ravel(), bounds.elements)
    found = Elements(bounds.elements, best[first:])
    within = np.concatenate([one.within(p) for one, p in found.each()])
    others = Elements(bounds.elements, within)
    # For what they leave, the springs in closed form: theirs is the last bit of a common optimum.
    mean = q.mean(axis=0)
    own = feasible(asked_for(q, torque - others.torque(q)), q, bounds, mean)
    return replace(own, others=others)


def _least(
    q: np.ndarray, torque: np.ndarray, bounds: Bounds, cost: Cost, dq: np.ndarray | None
) -> LinearSprings:
    """The best springs and elements for another cost than torque², about the mean angle."""
    given, n = columns(q, bounds), q.shape[1]
    if cost.kind == "peak":
        rated = cost.drives.rated_torque
        best = least_peak(given, torque.ravel(), bounds.elements, rated)
    else:
        speed = np.zeros_like(q) if dq is None else dq
        usual = usual_torque(torque)

        def each(left: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            value, slope, curvature = cost.smooth(left.reshape(q.shape), speed, usual)
            return value.ravel(), slope.ravel(), curvature.ravel()

        best = program.least(given, torque.ravel(), bounds.elements, each)
    least, most = (np.broadcast_to(end, n) for end in bounds.stiffness)
    within = [one.within(p) for one, p in Elements(bounds.elements, best[2 * n :]).each()]
    others = Elements(bounds.elements, np.concatenate([np.empty(0), *within]))
    stiffness, offset = np.clip(best[:n], least, most), best[n : 2 * n]
    low, high = (np.broadcast_to(end, n) for end in reach(bounds, q.mean(axis=0)))
    bounded = np.isfinite(low) & np.isfinite(high)
    # A joint that stands still: the softest spring that can hold the offset.
    side = np.where(offset > 0, high, low)
    holds = np.divide(offset, side, out=np.zeros_like(offset), where=bounded & (side != 0))
    still = q.var(axis=0) <= spring.STILL
    stiffness = np.where(still, np.clip(holds, least, most), stiffness)
    ends = [
        np.where(bounded, stiffness * np.where(bounded, end, 0), side)
        for end, side in ((low, -np.inf), (high, np.inf))
    ]
    return LinearSprings(stiffness, np.clip(offset, *ends), q.mean(axis=0), others)


def reach(bounds: Bounds, center: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest q_e - q_c of springs about a center q_c (n,): (n,), (n,) [rad]."""
    low, high = bounds.equilibrium
    origin = np.where(bounds.about_zero, center, 0.0)
    return low - origin, high - origin


def asked_for(q: np.ndarray, torque: np.ndarray) -> LinearSprings:
    """What `fit` would take if springs had no bounds: about the mean angle, by least squares."""
    mean = q.mean(axis=0)
    z = q - mean
    moves = (z**2).mean(axis=0) > spring.STILL
    slope = np.where(moves, spring_like_part(torque, z), 0.0)
    return LinearSprings(-slope, torque.mean(axis=0), mean)


def feasible(
    wanted: LinearSprings, q: np.ndarray, bounds: Bounds, center: np.ndarray
) -> LinearSprings:
    """The feasible springs nearest to `wanted` in the metric of the cost; arguments as in `fit`.

    Args:
        wanted: about the mean angle, where stiffness and offset do not interact in the cost.
        q: joint angles over a cycle.
        bounds: of the springs.
        center: q_c.
    """
    mean = wanted.center
    low, high = (end - (mean - center) for end in reach(bounds, center))
    variance = ((q - mean) ** 2).mean(axis=0)
    within = (*bounds.stiffness, low, high, variance)
    each = np.broadcast_arrays(wanted.stiffness, wanted.offset, *within)
    k, b = np.transpose([spring.nearest(*one) for one in np.transpose(each)])
    return LinearSprings(k, b, mean, wanted.others).about(center)


def spring_like_part(v: np.ndarray, q_bar: np.ndarray) -> np.ndarray:
    """Coefficients w of the part of a torque that a spring could exert, (10).

    Args:
        v: torque over a cycle (..., N, n) [N m].
        q_bar: regressor q̄ = q - q_s over the same cycle (..., N, n) [rad].

    Returns:
        w = ∫ v q̄ dt / ∫ q̄² dt per joint (..., n) [N m/rad]; 0 for a joint with q̄ = 0 throughout.
    """
    power = np.einsum("...tj,...tj->...j", q_bar, q_bar)
    return np.divide(
        np.einsum("...tj,...tj->...j", v, q_bar), power, out=np.zeros_like(power), where=power > 0
    )
