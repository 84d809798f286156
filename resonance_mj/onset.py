"""When an unstable loop of learning shows: what grows, and the cycle in which it passes a limit.

What grows grows from what is there. A smooth motion has nothing far above its own frequencies but
this: where a cycle ends and the next begins, the learned torque changes at once from that of one
cycle to that of the next, and the motion itself may begin with a jump of the state. Both are at the
beginning of the cycle, where the packet of waves that they leave stays and grows with the pose that
the arm has there. Elsewhere there are rounding errors only. Low harmonics are in the torque τ_d
that the motion needs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .sampled_loop import SampledLoop
from .stability import GROWTH, GROWTH_LOW, LearningLoop, ahead, low_harmonics, on_circle

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


def at_the_beginning(
    limit: float,
    loop: SampledLoop,
    learning: np.ndarray,
    torque: np.ndarray,
    *,
    lead: int,
    kept: int | None,
    jump: np.ndarray | None,
) -> Onset | None:
    """What grows at the beginning of the cycle, above the low harmonics.

    With the pose held, the harmonics U_i of the learned torque of cycle i follow

        Y_i = G (U_i - τ_d) + z C (z I - A)⁻¹ e_i / N
        U_{i+1} = U_i - β e^{jωδΔt} Y_i,        e_{i+1} = x̄(U_i) - x̄(U_{i+1})

    with e_i the difference, at the beginning of a cycle, of the arm's state from the periodic one,
    and x̄(U) the periodic state under U.

    Args:
        limit: mean torque² of the motors, their feedback included [N² m²].
        loop: the arm at the pose at the beginning of the cycle, P = 1.
        learning: β (n, n) [N m s/rad].
        torque: τ_d (N, n) [N m].
        lead: δ [control periods].
        kept: harmonics that the learned torque keeps; None for all.
        jump: (Δq, Δq̇) at the beginning of the first cycle (2n,); None for a smooth passage.
    """
    steps, n = torque.shape
    last = steps // 2 if kept is None else min(kept, steps // 2)
    h = np.arange(last + 1)
    z = on_circle(h, steps)[:, None, None]
    A, B, C, F = (part[0] for part in loop)
    # Both harmonics ±h of a real signal; there is one of the mean, and one of half the sampling.
    both = np.where((h == 0) | (2 * h == steps), 1.0, 2.0)[:, None]
    resolvent = np.linalg.inv(z * np.eye(len(A)) - A)
    state = resolvent @ B
    gain = ahead(h, lead, steps)[:, None, None] * learning
    P = np.eye(n) - gain @ C @ state
    growth = np.abs(np.linalg.eigvals(P)).max(axis=-1) - 1
    growth[: low_harmonics(steps) + 1] = 0
    if growth.max() <= GROWTH:
        return None
    first = int(np.argmax(growth > GROWTH))
    motors = (np.eye(n) - F @ state)[first:]

    def periodic(U: np.ndarray) -> np.ndarray:
        return (both * _times(state, U)).real.sum(axis=0)

    def below(U: np.ndarray) -> bool:
        return float((both[first:] * np.abs(_times(motors, U)) ** 2).sum()) <= limit

    needed = np.fft.rfft(torque, axis=0)[: last + 1] / steps
    e = np.zeros(len(A))
    if jump is not None:
        e = periodic(needed)
        e[: 2 * n] += jump
    begun = gain @ (z * (C @ resolvent)) / steps
    U, cycle = np.zeros((last + 1, n), complex), 1
    while below(U[first:]) and cycle < SETTLED:
        new = needed + _times(P, U - needed) - begun @ e
        e = periodic(U) - periodic(new)
        U, cycle = new, cycle + 1
    more = _times_until(below, P[first:], U[first:])
    return Onset(first, int(growth.argmax()), float(growth.max()), cycle + more)


def of_low_harmonics(
    limit: float, loop: LearningLoop, torque: np.ndarray, *, lead: int, kept: int | None
) -> Onset | None:
    """What grows of the low harmonics, which the change of the pose couples.

    Args:
        limit: mean square of what has grown [N² m²].
        loop: the loop of learning along the cycle.
        torque: τ_d (N, n) [N m].
        lead: δ [control periods].
        kept: harmonics that the learned torque keeps; None for all.
    """
    steps, n = torque.shape
    coupled = loop.coupled(lead, kept)
    most = (len(coupled) // n - 1) // 2
    values, vectors = np.linalg.eig(np.eye(len(coupled)) - coupled)
    worst = int(np.abs(values).argmax())
    growth = float(np.abs(values[worst])) - 1
    if growth <= GROWTH_LOW:
        return None
    h = np.arange(-most, most + 1)
    needed = (np.fft.fft(torque, axis=0)[h] / steps).ravel()
    share = np.linalg.solve(vectors, needed)[worst] * vectors[:, worst]
    # The growing harmonics are those of a pair of conjugate vectors, unless they are real.
    begun = float((np.abs(share) ** 2).sum()) * (2 if values[worst].imag else 1)
    fastest = int(np.abs(h[np.abs(share).argmax() // n]))
    cycle = 1 + np.ceil(np.log(max(limit / max(begun, 1e-300), 1)) / (2 * np.log1p(growth)))
    return Onset(loop.most_harmonics(lead) + 1, fastest, growth, float(cycle))


def elsewhere(loop: LearningLoop, *, lead: int) -> Onset | None:
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
