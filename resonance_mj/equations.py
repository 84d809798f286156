"""Equations (4)-(8) of the paper, one function each.

Each function is plain Python on scalars and 1-D or 2-D float arrays, and compiles under Numba when
compiled code calls it: one source, two ways to run. Results go to the array `out` that is passed
in, because a control callback must not allocate.

Shapes: n joints, m coordinates of the task. J is the (m, n) Jacobian of the task coordinates.
"""

import math

import numpy as np
from numba.extending import register_jitable


@register_jitable
def saturation(error: np.ndarray, out: np.ndarray) -> None:
    """Saturated position error s(Δx), (5).

    Args:
        error: Δx = x - x_d (m,) [m].
        out: receives s(Δx) (m,) [m].
    """
    for i in range(error.size):
        if error[i] > math.pi / 2:
            out[i] = 1.0
        elif error[i] < -math.pi / 2:
            out[i] = -1.0
        else:
            out[i] = math.sin(error[i])


@register_jitable
def motor_torque(
    J: np.ndarray,
    k_v: np.ndarray,
    k_p: np.ndarray,
    rate: np.ndarray,
    s: np.ndarray,
    u: np.ndarray,
    out: np.ndarray,
) -> None:
    """Motor torque τ = -Jᵀ (K_v Δẋ + K_p s(Δx)) + u, (4).

    Args:
        J: task Jacobian (m, n).
        k_v: velocity gains (m,) [N s/m].
        k_p: position gains (m,) [N/m].
        rate: Δẋ (m,) [m/s].
        s: s(Δx) (m,) [m].
        u: learned torque (n,) [N m].
        out: receives τ (n,) [N m].
    """
    for j in range(out.size):
        force = 0.0
        for i in range(s.size):
            force += J[i, j] * (k_v[i] * rate[i] + k_p[i] * s[i])
        out[j] = u[j] - force


@register_jitable
def stiffness_rate(gamma_k: float, q: float, q_c: float, y: float) -> float:
    """Adaptation of a joint's stiffness k̇ = γ_k (q - q_c) y, (6).

    Args:
        gamma_k: adaptation gain [N m/rad^3].
        q: joint angle [rad].
        q_c: centre of the regressor [rad].
        y: error signal (8) [rad/s].

    Returns:
        k̇ [N m/rad/s].
    """
    return gamma_k * (q - q_c) * y


@register_jitable
def offset_rate(gamma_qe: float, y: float) -> float:
    """Adaptation of a joint's offset torque d(q̄_e)/dt = -γ_qe y, (7).

    Args:
        gamma_qe: adaptation gain [N m/rad].
        y: error signal (8) [rad/s].

    Returns:
        d(q̄_e)/dt [N m/s].
    """
    return -gamma_qe * y


@register_jitable
def error_inverse(
    J: np.ndarray, rate: np.ndarray, alpha: float, s: np.ndarray, work: np.ndarray, out: np.ndarray
) -> None:
    """Error signal y = J⁻¹ (Δẋ + α s(Δx)), (8), by Gaussian elimination with partial pivoting.

    Args:
        J: task Jacobian (n, n), not singular.
        rate: Δẋ (n,) [m/s].
        alpha: weight of the position error [1/s].
        s: s(Δx) (n,) [m].
        work: scratch (n, n).
        out: receives y (n,) [rad/s]; not finite where J is singular.
    """
    n = out.size
    for i in range(n):
        out[i] = rate[i] + alpha * s[i]
        for j in range(n):
            work[i, j] = J[i, j]
    for column in range(n):
        pivot = column
        for i in range(column + 1, n):
            if abs(work[i, column]) > abs(work[pivot, column]):
                pivot = i
        if work[pivot, column] == 0.0:
            for i in range(n):
                out[i] = math.nan
            return
        if pivot != column:
            for j in range(column, n):
                work[column, j], work[pivot, j] = work[pivot, j], work[column, j]
            out[column], out[pivot] = out[pivot], out[column]
        for i in range(column + 1, n):
            factor = work[i, column] / work[column, column]
            for j in range(column + 1, n):
                work[i, j] -= factor * work[column, j]
            out[i] -= factor * out[column]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            out[i] -= work[i, j] * out[j]
        out[i] /= work[i, i]


@register_jitable
def error_transpose(
    J: np.ndarray, rate: np.ndarray, alpha: float, s: np.ndarray, out: np.ndarray
) -> None:
    """Error signal y = Jᵀ (Δẋ + α s(Δx)): (8) with Jᵀ in place of J⁻¹, Sec. VI-C.

    Args:
        J: task Jacobian (m, n).
        rate: Δẋ (m,) [m/s].
        alpha: weight of the position error [1/s].
        s: s(Δx) (m,) [m].
        out: receives y (n,) [m^2/s].
    """
    for j in range(out.size):
        out[j] = 0.0
        for i in range(s.size):
            out[j] += J[i, j] * (rate[i] + alpha * s[i])
