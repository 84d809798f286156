"""Rotations: the orientation of a rotation vector and back, its rates and its angular velocity.

The orientation is exp(r) R_home with r in the world frame. Its angular velocity is not dr/dt but
ω = J_l(r) dr/dt, with the left Jacobian of SO(3): J_l(r) v = v + A r × v + B r × (r × v), where
A = (1 - cos θ)/θ² and B = (θ - sin θ)/θ³ at the angle θ = |r|.
"""

import math

import numpy as np
from numpy.polynomial import polynomial

from ..step_functions import step_function

# In powers of θ², where A and B have no singularity; 16 terms are exact to rounding below 2π.
_A = np.array([(-1) ** k / math.factorial(2 * k + 2) for k in range(16)])
_B = np.array([(-1) ** k / math.factorial(2 * k + 3) for k in range(16)])
_DA, _DB = polynomial.polyder(_A), polynomial.polyder(_B)


@step_function
def rotation(r: np.ndarray, home: np.ndarray, out: np.ndarray) -> None:
    """Orientation exp(r) R_home of a rotation vector.

    Args:
        r: rotation vector in the world frame (3,) [rad].
        home: R_home (3, 3).
        out: receives the orientation (3, 3).
    """
    x, y, z = r[0], r[1], r[2]
    squared = x * x + y * y + z * z
    angle = math.sqrt(squared)
    sinc, cosc = 1.0 - squared / 6.0, 0.5 - squared / 24.0
    if angle > 1e-4:
        sinc, cosc = math.sin(angle) / angle, (1.0 - math.cos(angle)) / squared
    for j in range(3):
        a, b, c = home[0, j], home[1, j], home[2, j]
        dot = x * a + y * b + z * c
        cos = 1.0 - cosc * squared
        out[0, j] = cos * a + sinc * (y * c - z * b) + cosc * dot * x
        out[1, j] = cos * b + sinc * (z * a - x * c) + cosc * dot * y
        out[2, j] = cos * c + sinc * (x * b - y * a) + cosc * dot * z


@step_function
def rotation_vector(R: np.ndarray, S: np.ndarray, out: np.ndarray) -> None:
    """Rotation vector in the world frame that takes the orientation S to R: log(R Sᵀ).

    Args:
        R: orientation (3, 3).
        S: orientation (3, 3).
        out: receives the rotation vector (3,) [rad], its angle at most π.
    """
    x = y = z = trace = 0.0
    for j in range(3):
        x += R[2, j] * S[1, j] - R[1, j] * S[2, j]
        y += R[0, j] * S[2, j] - R[2, j] * S[0, j]
        z += R[1, j] * S[0, j] - R[0, j] * S[1, j]
        trace += R[0, j] * S[0, j] + R[1, j] * S[1, j] + R[2, j] * S[2, j]
    sin = 0.5 * math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sin, 0.5 * (trace - 1.0))
    factor = 0.5 if sin < 1e-9 else 0.5 * angle / sin
    out[0], out[1], out[2] = factor * x, factor * y, factor * z


def turned(r: np.ndarray, home: np.ndarray) -> np.ndarray:
    """Orientations exp(r) R_home (N, 3, 3) of rotation vectors (N, 3) [rad]; see `rotation`."""
    squared = (r**2).sum(axis=1)[:, None, None]
    angle = np.sqrt(squared)
    columns = home.T[None]  # each turns as a vector does
    once = np.cross(r[:, None], columns)
    cosc = 2.0 * (0.5 * np.sinc(angle / (2.0 * np.pi))) ** 2
    result = columns + np.sinc(angle / np.pi) * once + cosc * np.cross(r[:, None], once)
    return np.asarray(result.swapaxes(1, 2))


def between(R: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Rotation vectors log(R Sᵀ) (N, 3) [rad] of orientations R (N, 3, 3); see `rotation_vector`.

    Args:
        R: orientations (N, 3, 3).
        S: an orientation (3, 3), or one of each (N, 3, 3).
    """
    D = R @ S.swapaxes(-1, -2)
    axis = D[:, [2, 0, 1], [1, 2, 0]] - D[:, [1, 2, 0], [2, 0, 1]]
    sin = 0.5 * np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sin, 0.5 * (np.trace(D, axis1=1, axis2=2) - 1.0))
    factor = 0.5 * np.where(sin < 1e-9, 1.0, angle / np.maximum(sin, 1e-9))
    return np.asarray(factor[:, None] * axis)


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
