"""Learning between two cycles: (9), (10) and the spring transfer, on whole arrays in NumPy."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..experiments.experiment import Experiment
from ..springs.bounds import Bounds
from ..springs.fit import LinearSprings, fit, spring_like_part
from .gains import Gains
from .tuning import Tuning


class Cycle(NamedTuple):
    """What there is to learn from: a cycle's signals, and the springs at its end."""

    u: np.ndarray
    """Learned torque (N, n) [N m]."""
    y: np.ndarray
    """Error signal (8) (N, n) [rad/s]."""
    q: np.ndarray
    """Joint angles (N, n) [rad]."""
    tau: np.ndarray
    """Motor torque (N, n) [N m]."""
    q_desired: np.ndarray
    """Desired joint angles q_d (N, n) [rad]; of meaning only to laws that are told them."""
    springs: LinearSprings
    """At the end of the cycle."""
    q_s: np.ndarray
    """Centre of the regressor of (9), (10) (n,) [rad]."""
    timestep: float = 0.0
    """Between two samples [s]."""
    hold: int = 1
    """Time steps of a control period."""
    tuning: Tuning = Tuning()
    """What is known of the loop."""
    acting: LinearSprings | None = None
    """The springs at each step (N, n), where they were on their way to `springs`."""
    farthest: float = np.inf
    """How far a stiffness can change in the next cycle [N m/rad]."""
    passing: bool = False
    """Whether the motion still grew."""
    limited: float = 0.0
    """Share of the cycle, of all motors, in which they gave all they can: by limit, rate, speed."""

    def spring_torque(self, q: np.ndarray) -> np.ndarray:
        """Torque of the springs in the cycle at joint angles (N, n), as the law takes it [N m]."""
        return self.torque_of(self.acting or self.springs, q)

    def torque_of(self, springs: LinearSprings, q: np.ndarray) -> np.ndarray:
        """Torque that the law takes springs to exert at joint angles (N, n) [N m]."""
        belief = self.tuning.springs
        return springs.torque(q) if belief is None else belief.torque(springs, q)


class Learned(NamedTuple):
    """What motors and springs do in the next cycle."""

    u: np.ndarray
    """Learned torque (N, n) [N m]."""
    springs: LinearSprings
    """That it begins with."""


Learn = Callable[[Cycle, Gains, Experiment], Learned]
"""Torque and springs of the next cycle, from the last, the gains and the experiment."""


def learn(
    u: np.ndarray,
    y: np.ndarray,
    q: np.ndarray,
    *,
    gain: np.ndarray,
    q_s: np.ndarray,
    lead: int = 0,
    harmonics: int | None = None,
) -> np.ndarray:
    """Torque of the next cycle, u(t) = u(t-T) - β y(t-T+δ) - W q̄(t-T), (9).

    W is (10) with the torque u - β y that it is taken from, so that what remains is orthogonal to
    q̄ = q - q_s, (11).

    Args:
        u: learned torque of the cycle before (..., N, n) [N m].
        y: error signal of the cycle before (..., N, n) [rad/s].
        q: joint angles of the cycle before (..., N, n) [rad].
        gain: learning gain (..., n, n) [N m s/rad]: β I, or a matrix.
        q_s: centre of the regressor (..., n) [rad].
        lead: δ in control periods; the cycle is read as periodic. 0 as printed.
        harmonics: how many of the cycle's harmonics u - β y keeps; None for all, as printed.

    Returns:
        u of the next cycle (..., N, n) [N m].

    Note:
        With lead = 0 and all harmonics the loop is unstable when sampled: the hold's delay breaks
        the passivity (15) at high frequency, and the torque diverges after tens to hundreds of
        cycles; `divergence` predicts when.
    """
    v = learned_torque(u, y, gain=gain, lead=lead, harmonics=harmonics)
    q_bar = q - np.asarray(q_s)[..., None, :]
    return v - spring_like_part(v, q_bar)[..., None, :] * q_bar


def transfer(
    v: np.ndarray,
    q: np.ndarray,
    springs: LinearSprings,
    bounds: Bounds,
    dq: np.ndarray | None = None,
) -> Learned:
    """Hand the springs what springs can do: the total torque stays as it is.

    Where (9) throws away the part w q̄ of the learned torque that a spring could exert, the spring
    takes it over, as far as its bounds allow; what it takes, the motor gives up.

    Args:
        v: what is learned from a cycle, before anything is handed over (N, n) [N m].
        q: joint angles of that cycle (N, n) [rad].
        springs: at the end of it.
        bounds: what springs may be; their centre is put at the mean joint angle.
        dq: joint velocities of that cycle (N, n) [rad/s], which costs of power depend on.
    """
    total = v + springs.torque(q)
    best = fit(q, total, bounds, center=q.mean(axis=0), dq=dq)
    return Learned(total - best.torque(q), best)


def learned_torque(
    u: np.ndarray, y: np.ndarray, *, gain: np.ndarray, lead: int, harmonics: int | None
) -> np.ndarray:
    """u(t-T) - β y(t-T+δ), with its first harmonics only (..., N, n); arguments as in `learn`."""
    return low_pass(u - corrected(y, gain, lead), harmonics)


def corrected(y: np.ndarray, gain: np.ndarray, lead: int) -> np.ndarray:
    """What learning takes off the torque: gain times y, read `lead` samples ahead (..., N, n)."""
    return np.einsum("...ij,...tj->...ti", gain, np.roll(y, -lead, axis=-2))


def low_pass(v: np.ndarray, harmonics: int | None) -> np.ndarray:
    """A torque over a cycle with its first harmonics only, without a shift in phase.

    Args:
        v: torque over a cycle, read as periodic (..., N, n) [N m].
        harmonics: how many to keep besides the mean; None for all.
    """
    steps = v.shape[-2]
    if harmonics is None or harmonics >= steps // 2:
        return v
    spectrum = np.fft.rfft(v, axis=-2)
    spectrum[..., harmonics + 1 :, :] = 0.0
    return np.fft.irfft(spectrum, n=steps, axis=-2)


def resample(u: np.ndarray, steps: int) -> np.ndarray:
    """A torque over a cycle at another number of samples, at the same phases.

    Args:
        u: torque over a cycle (..., N, n) [N m].
        steps: new number of samples.

    Returns:
        The torque (..., steps, n) [N m], linear between samples and periodic.
    """
    before = u.shape[-2]
    if before == steps:
        return u
    position = np.arange(steps) * (before / steps)
    left = np.floor(position).astype(int)
    fraction = (position - left)[:, None]
    right = (left + 1) % before
    return (1 - fraction) * u[..., left, :] + fraction * u[..., right, :]
