"""Learning between two cycles: (9), (10), on whole arrays with a leading axis for the robots."""

from __future__ import annotations

import numpy as np


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


def learn(
    u: np.ndarray,
    y: np.ndarray,
    q: np.ndarray,
    *,
    beta: np.ndarray,
    q_s: np.ndarray,
    lead: int = 0,
) -> np.ndarray:
    """Torque of the next cycle, u(t) = u(t-T) - β y(t-T+δ) - W q̄(t-T), (9).

    W is (10) with the torque u - β y that it is taken from, so that what remains is orthogonal to
    q̄ = q - q_s, (11).

    Args:
        u: learned torque of the cycle before (..., N, n) [N m].
        y: error signal of the cycle before (..., N, n) [rad/s].
        q: joint angles of the cycle before (..., N, n) [rad].
        beta: learning gain (...) [N m s/rad].
        q_s: centre of the regressor (..., n) [rad].
        lead: δ in control periods; the cycle is read as periodic. 0 as printed.

    Returns:
        u of the next cycle (..., N, n) [N m].

    Note:
        With lead = 0 the loop is unstable when sampled: the hold's delay breaks the passivity (15)
        at high frequency, and the torque diverges after tens to hundreds of cycles.
    """
    v = u - np.asarray(beta)[..., None, None] * np.roll(y, -lead, axis=-2)
    q_bar = q - np.asarray(q_s)[..., None, :]
    return v - spring_like_part(v, q_bar)[..., None, :] * q_bar


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
