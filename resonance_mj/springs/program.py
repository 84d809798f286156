"""Springs and elements together: the best of a convex set, where they act on the same joints.

∫(τ - Φ p)ᵀ(τ - Φ p) dt is a convex quadratic in all parameters p, and what they may be is a convex
polyhedron. With the metric of the cost taken out it is a least-distance problem, and that a
non-negative least squares problem (Lawson and Hanson, Solving Least Squares Problems, ch. 23),
which an active-set method solves exactly in a finite number of steps. Of another cost that is
convex and smooth, Newton's method solves one such problem at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from .elements import Element, regressor
from .spring import STILL

FLOOR = 1e-6
"""Singular value, of the largest, below which parameters cannot be told apart: there the least of
them that is feasible is taken."""

NEWTON_STEPS, SHORTEST = 50, 1e-6
"""Most of them, and how short one may be made to lower the cost."""

CLOSE, LAST = 1e-9, 2
"""Share of the cost that a step promises from which on it is close to the least, and how many such
steps make it exact."""

ROUNDS = 20
"""Times that the stiffness of cubic elements is looked at between where it is bounded."""


class Columns(NamedTuple):
    """What the parameters do along a motion, of n joints' springs and of P of elements."""

    torque: np.ndarray
    """Torque per parameter (N n, d): n of stiffness, n of offset, P of elements."""
    rows: np.ndarray
    """A (rows, d) of A p <= b."""
    ends: np.ndarray
    """b (rows,)."""
    free: np.ndarray
    """Which parameters may be other than 0 (d,)."""


def columns(
    q: np.ndarray,
    elements: tuple[Element, ...],
    stiffness: tuple[np.ndarray, np.ndarray],
    equilibrium: tuple[np.ndarray, np.ndarray],
) -> Columns:
    """The joints' springs about the mean angle, and the elements, along joint angles (N, n).

    Args:
        q: joint angles over a cycle (N, n) [rad].
        elements: on the arm.
        stiffness: bounds of the joints' own springs (n,), (n,) [N m/rad].
        equilibrium: bounds of their equilibrium angles about the mean (n,), (n,) [rad].
    """
    N, n = q.shape
    eye, z = np.eye(n), q - q.mean(axis=0)
    # Where a joint stands still torque over angle is arbitrary, and no stiffness exerts any.
    z = np.where((z**2).mean(axis=0) > STILL, z, 0.0)
    own = [-z[:, :, None] * eye, np.broadcast_to(eye, (N, n, n))]
    phi = np.concatenate([*own, regressor(elements, q)], axis=2).reshape(N * n, -1)
    nothing, d = np.zeros((n, n)), phi.shape[1]
    rows, ends = (
        [np.hstack([-eye, nothing]), np.hstack([eye, nothing])],
        [-stiffness[0], stiffness[1]],
    )
    low, high = equilibrium
    bounded = np.isfinite(low) & np.isfinite(high)
    cone = np.where(bounded, low, 0.0), np.where(bounded, high, 0.0)
    rows += [np.hstack([np.diag(cone[0]), -eye]), np.hstack([-np.diag(cone[1]), eye])]
    ends += [np.where(bounded, 0.0, np.inf)] * 2
    A = np.zeros((4 * n, d))
    A[:, : 2 * n] = np.concatenate(rows)
    parts, at = [A], 2 * n
    for element in elements:
        mine, limit = element.limits()
        parts.append(np.zeros((len(mine), d)))
        parts[-1][:, at : at + mine.shape[1]] = mine
        ends.append(limit)
        at += mine.shape[1]
    A, b = np.concatenate(parts), np.concatenate(ends)
    # A joint without a spring: beside an element there its parameters could not be told apart.
    none = bounded & (stiffness[0] == 0) & (stiffness[1] == 0)
    free = np.concatenate([~none, ~none, np.ones(d - 2 * n, bool)])
    return Columns(phi, A[np.isfinite(b)], b[np.isfinite(b)], free)


def best(given: Columns, torque: np.ndarray, elements: tuple[Element, ...]) -> np.ndarray:
    """Feasible parameters (d,) that leave the least of a torque (N n,) in the mean square.

    The stiffness of cubic elements is within its bounds at every length of their travel: where it
    is least or greatest a bound is added, until none is exceeded.

    Raises:
        ValueError: no parameters are feasible.
    """
    scale = _scale(np.sqrt((given.torque**2).mean(axis=0)))
    phi = given.torque / scale
    return _quadratic(phi.T @ phi, phi.T @ torque, scale, given, elements)


def least(
    given: Columns,
    torque: np.ndarray,
    elements: tuple[Element, ...],
    cost: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]],
) -> np.ndarray:
    """Feasible parameters (d,) that leave the least of a convex cost of each torque.

    Args:
        given: what parameters do.
        torque: of which they leave the least (N n,) [N m].
        elements: among them.
        cost: of what is left (N n,), its value, slope and curvature at each.

    Raises:
        ValueError: no parameters are feasible.
    """
    found, phi, close = best(given, torque, elements), given.torque, 0
    value, slope, curvature = cost(torque - phi @ found)
    for _ in range(NEWTON_STEPS):
        uphill, H = -(phi.T @ slope), phi.T @ (curvature[:, None] * phi)
        scale = _scale(np.sqrt(np.diag(H)))
        wanted = (H @ found - uphill) / scale
        way = _quadratic(H / np.outer(scale, scale), wanted, scale, given, elements) - found
        gain, length = float(-uphill @ way), 1.0
        # At the end the steps are whole, and what they gain is less than rounding.
        close += gain <= CLOSE * abs(value.sum())
        while True:
            there = cost(torque - phi @ (found + length * way))
            if close or there[0].sum() <= value.sum() - 1e-4 * length * gain or length < SHORTEST:
                break
            length *= 0.5
        found, (value, slope, curvature) = found + length * way, there
        if close == LAST or length < SHORTEST:
            break
    return found


def _scale(size: np.ndarray) -> np.ndarray:
    """Of each parameter, what it does; of one that does nothing, as much as the largest."""
    size[size <= FLOOR * size.max(initial=0.0)] = size.max(initial=0.0) or 1.0
    return size


def _quadratic(
    H: np.ndarray,
    wanted: np.ndarray,
    scale: np.ndarray,
    given: Columns,
    elements: tuple[Element, ...],
) -> np.ndarray:
    """Feasible p with the least pᵀ H p / 2 - wantedᵀ p, in units of `scale`."""
    free, rows, ends = given.free, given.rows, given.ends
    values, vectors = np.linalg.eigh(H[np.ix_(free, free)])
    root = np.sqrt(np.maximum(values, FLOOR**2 * values.max(initial=0.0)))
    root[root == 0] = 1.0  # nothing that is free does anything
    back = np.zeros((len(free), len(values)))
    back[free] = vectors / root / scale[free, None]
    wanted = (vectors / root).T @ wanted[free]
    for _ in range(ROUNDS):
        found = back @ _nearest(wanted, rows @ back, ends)
        more = list(exceeded(found, elements))
        if not more:
            break
        rows = np.vstack([rows, *(row for row, _ in more)])
        ends = np.append(ends, [end for _, end in more])
    return found


def _nearest(wanted: np.ndarray, A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The z nearest to `wanted` with A z <= b."""
    from scipy.optimize import nnls  # takes longer to import than a plan without elements

    # w = z - wanted: the least |w| with G w >= h.
    norms = np.linalg.norm(A, axis=1)
    A, b, norms = A[norms > 0], b[norms > 0], norms[norms > 0]
    G, h = -A / norms[:, None], (A @ wanted - b) / norms
    size = h.max(initial=0.0)
    if size <= 0.0:
        return wanted
    E = np.vstack([G.T, h / size])
    target = np.zeros(len(E))
    target[-1] = 1.0
    u, _ = nnls(E, target, maxiter=50 * E.shape[1])
    residual = E @ u - target
    if np.linalg.norm(residual) < 1e-9:
        raise ValueError("no parameters are within all bounds")
    return wanted - size * residual[:-1] / residual[-1]


def exceeded(
    found: np.ndarray, elements: tuple[Element, ...]
) -> Iterator[tuple[np.ndarray, float]]:
    """Rows of A and b that bound cubic elements where their stiffness exceeds its bounds."""
    at = len(found) - sum(len(one.parameters) for one in elements)
    for element in elements:
        mine = slice(at, at + len(element.parameters))
        at = mine.stop
        if element.kind != "cubic":
            continue
        slopes = element.slopes(element.extremes(found[mine]))
        tolerance = 1e-6 * np.abs(found[mine]).max()
        for slope, k in zip(slopes, slopes @ found[mine], strict=True):
            row = np.zeros_like(found)
            if k < element.stiffness[0] - tolerance:
                row[mine] = -slope
                yield row, -element.stiffness[0]
            elif k > element.stiffness[1] + tolerance:
                row[mine] = slope
                yield row, element.stiffness[1]


def alike(torque: np.ndarray, n: int) -> np.ndarray:
    """Which parameters (k) cannot be told apart along a motion, but by a constant.

    Args:
        torque: what each exerts (N n, d) [N m].
        n: number of joints.

    Returns:
        Indices of those of the weakest direction, in which the torque but for its mean vanishes;
        empty if there is none.
    """
    varies = torque.reshape(-1, n, torque.shape[1])
    varies = (varies - varies.mean(axis=0)).reshape(torque.shape)
    scale = np.sqrt((varies**2).mean(axis=0))
    moves = np.flatnonzero(scale > FLOOR * np.sqrt((torque**2).mean(axis=0)))
    phi = varies[:, moves] / scale[moves]
    values, vectors = np.linalg.eigh(phi.T @ phi)
    if not len(values) or values[0] > FLOOR**2 * values[-1]:
        return np.empty(0, int)
    share = np.abs(vectors[:, 0])
    return moves[share > 0.1 * share.max()]
