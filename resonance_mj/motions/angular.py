"""A rotation vector's rates, and the angular velocity and acceleration of what it turns.

The orientation is exp(r) R_home with r in the world frame. Its angular velocity is not dr/dt but
ω = J_l(r) dr/dt, with the left Jacobian of SO(3): J_l(r) v = v + A r × v + B r × (r × v), where
A = (1 - cos θ)/θ² and B = (θ - sin θ)/θ³ at the angle θ = |r|.
"""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.polynomial import polynomial

# In powers of θ², where A and B have no singularity; 16 terms are exact to rounding below 2π.
_A = np.array([(-1) ** k / factorial(2 * k + 2) for k in range(16)])
_B = np.array([(-1) ** k / factorial(2 * k + 3) for k in range(16)])
_DA, _DB = polynomial.polyder(_A), polynomial.polyder(_B)


def from_rates(r: np.ndarray, dr: np.ndarray, ddr: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular velocity [rad/s] and acceleration [rad/s^2] in the world frame, both (N, 3).

    Args:
        r: rotation vectors (N, 3) [rad].
        dr: their time derivatives (N, 3) [rad/s].
        ddr: their second time derivatives (N, 3) [rad/s^2].
    """
    return _left(r, dr), _left(r, ddr) + _drift(r, dr)


def to_rates(r: np.ndarray, omega: np.ndarray, alpha: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rotation vectors' first and second time derivatives: the inverse of `from_rates`.

    Args:
        r: rotation vectors, shorter than 2π (N, 3) [rad].
        omega: angular velocity (N, 3) [rad/s].
        alpha: angular acceleration (N, 3) [rad/s^2].
    """
    J = np.stack([_left(r, np.broadcast_to(unit, r.shape)) for unit in np.eye(3)], axis=-1)
    dr = np.linalg.solve(J, omega[..., None])[..., 0]
    ddr = np.linalg.solve(J, (alpha - _drift(r, dr))[..., None])[..., 0]
    return dr, ddr


def _left(r: np.ndarray, v: np.ndarray) -> np.ndarray:
    """J_l(r) v."""
    squared = (r**2).sum(axis=1, keepdims=True)
    once = np.cross(r, v)
    A, B = polynomial.polyval(squared, _A), polynomial.polyval(squared, _B)
    return v + A * once + B * np.cross(r, once)


def _drift(r: np.ndarray, dr: np.ndarray) -> np.ndarray:
    """(dJ_l/dt) dr/dt."""
    squared = (r**2).sum(axis=1, keepdims=True)
    rate = 2 * (r * dr).sum(axis=1, keepdims=True)
    once = np.cross(r, dr)
    B = polynomial.polyval(squared, _B)
    dA, dB = polynomial.polyval(squared, _DA), polynomial.polyval(squared, _DB)
    return dA * rate * once + B * np.cross(dr, once) + dB * rate * np.cross(r, once)
