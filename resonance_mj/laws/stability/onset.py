"""When an unstable loop of learning shows: what grows, and the cycle in which it passes a limit.

What grows grows from what is there. A smooth motion has nothing far above its own frequencies but
this: where a cycle ends and the next begins, the learned torque changes at once from that of one
cycle to that of the next, and the motion itself may begin with a jump of the state. Both are at the
beginning of the cycle, where the packet of waves that they leave stays and grows with the pose that
the arm has there. Elsewhere there are rounding errors only. Low harmonics are in the torque τ_d
that the motion needs.
"""

from collections.abc import Callable, Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np

from ..gains import Gains
from .sampled_loop import SampledLoop
from .stability import GROWTH, GROWTH_LOW, LearningLoop, ahead, low_harmonics, on_circle, two_sided

SETTLED = 16
"""Cycles after which the beginnings of the cycles leave nothing new that counts."""

DOUBLINGS = 24
"""Cycles are counted up to 2 to this power."""

ROUNDING = 1e-16
"""Relative size of rounding errors."""


class Onset(NamedTuple):
    """What grows, and when it shows.

    Attributes:
        first: the lowest harmonic of 1/T that grows.
        fastest: the one that grows fastest.
        growth: of its amplitude in a cycle: 0.05 for 5 %.
        cycle: the first in which what has grown passes the limit, counted from 1, the first that
            teaches; inf if that takes more than 2^24 cycles.
    """

    first: int
    fastest: int
    growth: float
    cycle: float


class Beginning:
    """Learning from the first cycle on, with the pose held that the arm has when a cycle begins.

    The harmonics U_i of the learned torque of cycle i follow

        Y_i = G (U_i - τ_d) + z C (z I - A)⁻¹ e_i / N
        U_{i+1} = U_i - β e^{jωδΔt} Y_i,        e_{i+1} = x̄(U_i) - x̄(U_{i+1})

    with e_i the difference, when the cycle begins, of the arm's state from the periodic one, and
    x̄(U) the periodic state under U.

    Args:
        arm: at poses of the motion, first that at which a cycle begins.
        gains: of the law: β, δ, and the harmonics that the learned torque keeps.
        torque: τ_d (N, n) [N m].
        jump: (Δq, Δq̇) when the first cycle begins (2n,); None for a smooth passage.
    """

    def __init__(
        self, arm: SampledLoop, gains: Gains, torque: np.ndarray, jump: np.ndarray | None
    ) -> None:
        self.gains, (self.steps, n) = gains, torque.shape
        half = self.steps // 2
        last = half if gains.harmonics is None else min(gains.harmonics, half)
        h = np.arange(last + 1)
        z = on_circle(h, self.steps)[:, None, None]
        A, B, C, F = (part[0] for part in arm)
        resolvent = np.linalg.inv(z * np.eye(len(A)) - A)
        self._state = resolvent @ B
        # There are harmonics h and -h of a real signal; one of the mean and of half the sampling.
        self._both = np.where((h == 0) | (2 * h == self.steps), 1.0, 2.0)[:, None]
        self._motors = np.eye(n) - F @ self._state
        gain = ahead(h, gains.lead, self.steps)[:, None, None] * gains.learning
        self.P = np.eye(n) - gain @ C @ self._state
        self._transient = gain @ (z * (C @ resolvent)) / self.steps
        self.needed = np.fft.rfft(torque, axis=0)[: last + 1] / self.steps
        self._e = np.zeros(len(A))
        if jump is not None:
            self._e = self._periodic(self.needed)
            self._e[: 2 * n] += jump

    def learned(self) -> Iterator[np.ndarray]:
        """Harmonics of the learned torque of the first cycle, the second, and so on (H, n)."""
        U, e = np.zeros_like(self.needed), self._e
        while True:
            yield U
            new = self.needed + _times(self.P, U - self.needed) - self._transient @ e
            U, e = new, self._periodic(U) - self._periodic(new)

    def torque_squared(self, U: np.ndarray, first: int) -> float:
        """Mean torque² of the motors by the harmonics U of `first` and above [N² m²]."""
        torque = _times(self._motors[first:], U)
        return float((self._both[first:] * np.abs(torque) ** 2).sum())

    def _periodic(self, U: np.ndarray) -> np.ndarray:
        return (self._both * _times(self._state, U)).real.sum(axis=0)


def at_the_beginning(limit: float, begins: Beginning) -> Onset | None:
    """What grows where a cycle begins, above the low harmonics, until torque² passes a limit."""
    growth = np.abs(np.linalg.eigvals(begins.P)).max(axis=-1) - 1
    growth[: low_harmonics(begins.steps) + 1] = 0
    if growth.max() <= GROWTH:
        return None
    first = int(np.argmax(growth > GROWTH))

    def below(U: np.ndarray) -> bool:
        return begins.torque_squared(U, first) <= limit

    learned = [U[first:] for U in islice(begins.learned(), SETTLED)]
    cycle = next((i for i, U in enumerate(learned, 1) if not below(U)), SETTLED)
    more = _times_until(below, begins.P[first:], learned[cycle - 1])
    return Onset(first, int(growth.argmax()), float(growth.max()), cycle + more)


def of_low_harmonics(
    limit: float, loop: LearningLoop, begins: Beginning, first: int
) -> Onset | None:
    """What grows of the low harmonics together, until its mean square passes a limit [N² m²].

    Args:
        limit: [N² m²].
        loop: the loop of learning along the cycle.
        begins: gives what is there to grow: τ_d, and what the first cycle teaches beside it.
        first: the lowest that grows.
    """
    coupled = loop.coupled(begins.gains.lead, begins.gains.harmonics)
    P = np.eye(len(coupled)) - coupled
    values, vectors = np.linalg.eig(P)
    growth = np.abs(values) - 1
    grows = growth > GROWTH_LOW
    if not grows.any():
        return None
    n = begins.needed.shape[1]
    low = len(P) // n // 2
    _, second = islice(begins.learned(), 2)
    beside = second - begins.needed + _times(begins.P, begins.needed)
    beside, needed = (two_sided(U[: low + 1]).ravel() for U in (beside, begins.needed))
    left = beside - P @ needed
    share = np.linalg.solve(vectors, left)[grows, None]
    shapes = vectors[:, grows]

    def below(share: np.ndarray) -> bool:
        return float((np.abs(shapes @ share) ** 2).sum()) <= limit

    power = (np.abs(vectors[:, growth.argmax()].reshape(-1, n)) ** 2).sum(axis=1)
    fastest = int(np.bincount(np.abs(np.arange(-low, low + 1)), power).argmax())
    more = _times_until(below, values[grows, None, None], share)
    return Onset(first, fastest, float(growth.max()), 2 + more)


def elsewhere(loop: LearningLoop, lead: int) -> Onset | None:
    """What grows from rounding errors, above the low harmonics, at any pose of the cycle."""
    growth = loop.multiplier(lead).max(axis=0) - 1
    growth[loop.low] = 0
    if growth.max() <= GROWTH:
        return None
    first, fastest = (loop.harmonics[at] for at in (np.argmax(growth > GROWTH), growth.argmax()))
    cycle = np.ceil(-np.log(ROUNDING) / np.log1p(growth.max()))
    return Onset(int(first), int(fastest), float(growth.max()), float(cycle))


def _times_until(below: Callable[[np.ndarray], bool], P: np.ndarray, U: np.ndarray) -> float:
    """How often P is applied to U until it is no longer below."""
    if not below(U):
        return 0.0
    powers, count = [P], 0
    with np.errstate(all="ignore"):
        while below(_times(powers[-1], U)):
            if len(powers) > DOUBLINGS:
                return np.inf
            powers.append(powers[-1] @ powers[-1])
        for exponent in reversed(range(len(powers))):
            further = _times(powers[exponent], U)
            if below(further):
                U, count = further, count + 2**exponent
    return count + 1.0


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Each matrix (H, a, b) times its vector (H, b)."""
    return (matrices @ vectors[..., None])[..., 0]
