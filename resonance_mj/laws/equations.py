"""Equations (4)-(8) of the paper, one function each.

Each function is plain Python on scalars and 1-D or 2-D float arrays, and compiles under Numba when
compiled code calls it: one source, two ways to run. Results go to the array `out` that is passed
in, because a control callback must not allocate.

Shapes: n joints, m coordinates of the task. J is the (m, n) Jacobian of the task coordinates.
"""

import math

import numpy as np

from ..step_functions import step_function


@step_function
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


@step_function
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


@step_function
def spring_rates(
    gamma_k: float, gamma_qe: float, q: float, q_c: float, y: float
) -> tuple[float, float]:
    """Adaptation of a joint's spring: k̇ = γ_k (q - q_c) y, (6), and d(q̄_e)/dt = -γ_qe y, (7).

    Args:
        gamma_k: adaptation gain of the stiffness [N m/rad^3].
        gamma_qe: of the offset torque [N m/rad].
        q: joint angle [rad].
        q_c: centre of the regressor [rad].
        y: error signal (8) [rad/s].

    Returns:
        k̇ [N m/rad/s] and d(q̄_e)/dt [N m/s].
    """
    return gamma_k * (q - q_c) * y, -gamma_qe * y


@step_function
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


@step_function
def error_transpose(
    J: np.ndarray, rate: np.ndarray, alpha: float, s: np.ndarray, out: np.ndarray
) -> None:
    """Error signal y = Jᵀ (Δẋ + α s(Δx)): (8) with Jᵀ in place of J⁻¹, Sec. VI-C.

    Arguments as in `error_inverse`, for a J of any shape (m, n); y in [m^2/s].
    """
    for j in range(out.size):
        out[j] = 0.0
        for i in range(s.size):
            out[j] += J[i, j] * (rate[i] + alpha * s[i])


@step_function
def error_damped(
    J: np.ndarray,
    rate: np.ndarray,
    alpha: float,
    s: np.ndarray,
    drift: np.ndarray,
    usual: float,
    work: np.ndarray,
    out: np.ndarray,
) -> None:
    """Error signal y = J⁺ (Δẋ + α s(Δx)) + (I - J⁺J) p for m <= n: (8) for any robot.

    J⁺ = Jᵀ (J Jᵀ + λ² I)⁻¹, where λ is negligible at usual poses and grows to a tenth of J's size
    as its manipulability sqrt(det J Jᵀ) falls to 0. p is the drift of the posture, which
    motion of the joints that does not move the tool takes back.

    Args as in `error_inverse`, for a J (m, n), and:
        drift: p = q̇ + α₀ (q - q_home) (n,) [rad/s].
        usual: manipulability below which the damping grows.
        work: scratch (m + 1, m).
    """
    m, n = s.size, out.size
    for i in range(m):
        work[m, i] = rate[i] + alpha * s[i]
        for j in range(n):
            work[m, i] -= J[i, j] * drift[j]
    scale = _square(J, work) / m
    manipulability = _factorise(work, m, 1e-10 * scale)
    if manipulability < usual:
        _square(J, work)
        lack = 1.0 - manipulability / usual
        _factorise(work, m, (1e-10 + 1e-2 * lack * lack) * scale)
    for i in range(m):
        for k in range(i):
            work[m, i] -= work[i, k] * work[m, k]
        work[m, i] /= work[i, i]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            work[m, i] -= work[k, i] * work[m, k]
        work[m, i] /= work[i, i]
    for j in range(n):
        out[j] = drift[j]
        for i in range(m):
            out[j] += J[i, j] * work[m, i]


@step_function
def _square(J: np.ndarray, out: np.ndarray) -> float:
    """J Jᵀ, its lower half (m, m) to `out`; returns its trace."""
    trace = 0.0
    for i in range(J.shape[0]):
        for k in range(i + 1):
            out[i, k] = 0.0
            for j in range(J.shape[1]):
                out[i, k] += J[i, j] * J[k, j]
        trace += out[i, i]
    return trace


@step_function
def _factorise(A: np.ndarray, m: int, damping: float) -> float:
    """Cholesky factor of A + damping I in A's lower half (m, m); the root of its determinant."""
    root = 1.0
    for i in range(m):
        A[i, i] += damping
        for k in range(i + 1):
            for h in range(k):
                A[i, k] -= A[i, h] * A[k, h]
            if k < i:
                A[i, k] /= A[k, k]
        A[i, i] = math.sqrt(max(A[i, i], damping))
        root *= A[i, i]
    return root


@step_function
def inertial_feedback(G: np.ndarray, y: np.ndarray, out: np.ndarray) -> None:
    """Add the feedback -G y to a torque; G = ω M̂ makes it -ω M̂ y, the same for any robot.

    Args:
        G: joint-space gain (n, n) [N m s/rad].
        y: error signal (8) (n,) [rad/s].
        out: torque, changed in place (n,) [N m].
    """
    for i in range(out.size):
        for j in range(out.size):
            out[i] -= G[i, j] * y[j]
