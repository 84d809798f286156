"""The transfer for springs that may not be linear: it moves them as far as it understands them.

The total torque that a motion needs is the same whoever exerts it. So when springs are changed, and
learning has settled again, what the motors give has changed by what the springs really do: of
springs that exert -k (a_1 x + a_3 x³), Δv = Δ(k x) a_1 + Δ(k x³) a_3, in which a is fitted to all
such changes. The springs of the next cycle are the best by a among those whose torque is near
to what it is now; how near grows where the change was as foretold, and shrinks where not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..springs import material
from ..springs.fit import LinearSprings, reach
from ..springs.spring import equilibrium_angles
from ..text import listed

if TYPE_CHECKING:
    from ..springs.bounds import Bounds
    from .learning import Cycle

FIRST = 0.05
"""How far, of the torque that a joint needs, the first change goes: a spring of x (1 + 2 x²), 3 rad
from its equilibrium, exerts 19 times what is expected."""

FORETOLD, WRONG = 0.25, 0.75
"""Of a change, what may have come otherwise to go farther the next time, and from where on less."""

FARTHER, LESS = 4.0, 0.5

SETTLED, MOST, PATIENCE = 0.1, 0.3, 12
"""Change of a joint's total torque from a cycle to the next below which it is known, over what its
spring may change (of which at most `MOST` counts); and how many cycles that is waited for."""

LEAST, LARGEST = (0.1, 0.0), (10.0, 100.0)
"""Between which a is: springs that push away or soften are none."""

SMALL = 0.03
"""Of the torque of the joint that needs most, what counts as none: a thousandth of torque²."""

WORTH = 1e-4
"""Saving, of what a joint's torque² is without a spring, for which springs are changed."""

TOLD = 0.01
"""Change of a spring's torque, of what the joint needs, from which something is to be learned."""

NOTABLE = 0.05
"""How far a is from (1, 0) to be spoken of."""

PRIOR = 1e-5
"""Weight of a = (1, 0) beside the squares of changes, over the torque² that a joint needs."""

SAMPLES = 256
"""Of a cycle, at most, in which the best springs are looked for."""


class Belief(NamedTuple):
    """What springs are taken to be, and how it was found."""

    a: np.ndarray
    """(n, 2)."""
    squares: np.ndarray
    """Of changes ΔP, their products (n, 2, 2), as shares of the torque² that a joint needs."""
    products: np.ndarray
    """And with Δv (n, 2)."""
    near: np.ndarray
    """How far springs go at once, of the torque that a joint needs (n,)."""
    waited: int = 0
    """Cycles since the springs were changed."""
    before: np.ndarray | None = None
    """Total torque of the cycle before (N, n)."""
    known: tuple[np.ndarray, np.ndarray] | None = None
    """P = k (x, x³) (N, n, 2) and v (N, n), when torque had settled the last time."""

    @classmethod
    def begins(cls, n: int) -> Belief:
        """That springs of n joints are linear, not yet tried."""
        a = np.tile([1.0, 0.0], (n, 1))
        squares = np.tile(PRIOR * np.eye(2), (n, 1, 1))
        return cls(a, squares, PRIOR * a, np.full(n, FIRST))

    def begun(self) -> Belief:
        """As another motion begins: its torque is another."""
        return self._replace(waited=0, before=None, known=None)

    def torque(self, springs: LinearSprings, q: np.ndarray) -> np.ndarray:
        """Torque of springs at joint angles (N, n), as believed [N m]."""
        return -np.einsum("tjp,jp->tj", _features(springs, q), self.a)

    def said(self) -> list[str]:
        """What was found of springs that are not what they are set to be, in a line."""
        found = self.a
        if np.abs(found[:, 0] - 1).max() < NOTABLE and found[:, 1].max() < NOTABLE:
            return []
        each = (listed([f"{one:.2f}" for one in column]) for column in found.T)
        return [
            "springs are not linear: joint by joint they exert -k (a x + b x³) with a = {} and "
            "b = {} 1/rad²".format(*each)
        ]

    def shapes(self) -> list[material.Shape]:
        """φ = a_1 x + a_3 x³ of each joint."""

        def shape(a: float, b: float) -> material.Shape:
            return lambda x, v: a * x + b * x**3

        return [shape(*own) for own in self.a.tolist()]


def _features(springs: LinearSprings, q: np.ndarray) -> np.ndarray:
    """P = k (x, x³) (N, n, 2) at joint angles (N, n)."""
    x = q - equilibrium_angles(*springs)
    return np.stack([springs.stiffness * x, springs.stiffness * x**3], axis=2)


def handed_over(
    belief: Belief, v: np.ndarray, q: np.ndarray, cycle: Cycle, bounds: Bounds
) -> tuple[np.ndarray, LinearSprings, Belief]:
    """Torque and springs of the next cycle, and what is believed of springs.

    Args:
        belief: before the cycle.
        v: what is learned from it (N, n) [N m].
        q: its joint angles (N, n) [rad].
        cycle: that was made.
        bounds: what springs may be.
    """
    springs, acting = cycle.springs, cycle.acting or cycle.springs
    total = v + belief.torque(acting, q)
    size = np.sqrt((total**2).mean(axis=0))
    size = np.maximum(size, SMALL * size.max())
    before, waited = belief.before, belief.waited + 1
    belief = belief._replace(before=total, waited=waited)
    # Springs on their way end the cycle elsewhere than they were in it.
    left = v if cycle.acting is None else total - belief.torque(springs, q)
    if before is None or before.shape != total.shape or cycle.passing or not size.all():
        return left, springs, belief
    moved = np.sqrt(((total - before) ** 2).mean(axis=0)) / size
    settled = moved <= SETTLED * np.minimum(belief.near, MOST)
    if not settled.all():
        if waited < PATIENCE:
            return left, springs, belief
        # It is noise that does not settle: changes shall stand out of it.
        above = np.minimum(np.maximum(belief.near, moved / SETTLED), MOST)
        belief = belief._replace(near=np.where(settled, belief.near, above))
    belief = _seen(belief, _features(acting, q), v, size)
    now, total = belief.torque(springs, q), v + belief.torque(acting, q)
    left = v if cycle.acting is None else total - now
    mean, few = q.mean(axis=0), slice(None, None, max(1, len(q) // SAMPLES))
    low, high = (mean + end for end in reach(bounds, mean))
    least, most = (np.broadcast_to(np.asarray(end, float), mean.shape) for end in bounds.stiffness)
    still, shapes, near = np.zeros_like(q[few]), belief.shapes(), (now[few], belief.near * size)
    ends = low, high
    k, q_e = material.best(q[few], total[few], still, shapes, (least, most), ends, near)
    if bounds.resolution:  # which may be farther away than what is near
        k = np.clip(np.round(k / bounds.resolution) * bounds.resolution, least, most)
        k, q_e = material.best(q[few], total[few], still, shapes, (k, k), ends)
    wanted = LinearSprings(k, k * (q_e - mean), mean, springs.others)
    with np.errstate(invalid="ignore"):
        then = belief.torque(wanted, q)
        saved = (left**2).mean(axis=0) - ((total - then) ** 2).mean(axis=0)
        changes = saved > (WORTH + moved**2) * size**2
    if not changes.any():
        return left, springs, belief
    own = springs.about(mean)
    wanted = LinearSprings(
        np.where(changes, k, own.stiffness),
        np.where(changes, wanted.offset, own.offset),
        mean,
        springs.others,
    )
    belief = belief._replace(waited=0, before=None)
    return total - belief.torque(wanted, q), wanted, belief


def _seen(belief: Belief, features: np.ndarray, v: np.ndarray, size: np.ndarray) -> Belief:
    """What is believed when torque has settled: v (N, n), with features P of the springs."""
    known = features, v
    if belief.known is None or belief.known[1].shape != v.shape:
        return belief._replace(known=known)
    change, came = features - belief.known[0], v - belief.known[1]
    foretold = np.einsum("tjp,jp->tj", change, belief.a)
    far = np.sqrt((foretold**2).mean(axis=0))
    tried = far > TOLD * size
    with np.errstate(divide="ignore", invalid="ignore"):
        wrong = np.sqrt(((foretold - came) ** 2).mean(axis=0)) / far
    rate = np.where(wrong < FORETOLD, FARTHER, np.where(wrong > WRONG, LESS, 1.0))
    weight = np.where(tried, 1.0 / (len(v) * size**2), 0.0)
    squares = belief.squares + weight[:, None, None] * np.einsum("tjp,tjr->jpr", change, change)
    products = belief.products + weight[:, None] * np.einsum("tjp,tj->jp", change, came)
    a = np.linalg.solve(squares, products[..., None])[..., 0]
    return belief._replace(
        a=np.clip(a, LEAST, LARGEST),
        squares=squares,
        products=products,
        near=np.where(tried, np.clip(belief.near * rate, FIRST / 4, 4.0), belief.near),
        known=known,
    )
