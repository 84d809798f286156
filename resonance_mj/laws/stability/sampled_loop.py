"""The arm under its feedback, linearised at rest at poses of a motion and sampled in time.

Δq, Δq̇ are the deviations from the desired joint motion, σ the torque of the springs' adaptation
(6), (7). At a pose, with s(Δx) = Δx and J, M, q - q_c held,

    M Δq̈ + D Δq̇ + k Δq = u + σ - F (Δq, Δq̇)      (1) with the feedback of (4)
    y = C (Δq, Δq̇)                                 (8)
    dσ/dt = -(Γ_k (q - q_c)² + Γ_qe) y             (6), (7)

MuJoCo's integrator makes of it x(t+Δt) = A x(t) + B u(t), with u held over the time step.
"""

from typing import NamedTuple

import numpy as np

from ...experiments.experiment import Experiment
from ...motions.kinematics import Kinematics
from ...robots.robot import Robot
from ..gains import Gains


class SampledLoop(NamedTuple):
    """x(t+Δt) = A x + B u, y = C x, τ = u - F x at P poses, with x = (Δq, Δq̇) or (Δq, Δq̇, σ)."""

    A: np.ndarray
    """(P, states, states)."""
    B: np.ndarray
    """(P, states, n)."""
    C: np.ndarray
    """(P, n, states)."""
    F: np.ndarray
    """(P, n, states)."""

    @property
    def stable(self) -> bool:
        """Whether the arm comes to rest at each pose; else it has no response to learn from."""
        return bool(np.abs(np.linalg.eigvals(self.A)).max() <= 1 + 1e-9)

    def state(self, z: np.ndarray) -> np.ndarray:
        """Response of x to u, (z I - A)⁻¹ B at each z = e^{jωΔt} (P, H, states, n)."""
        identity = np.eye(self.A.shape[-1])
        return np.linalg.solve(z[:, None, None] * identity - self.A[:, None], self.B[:, None] + 0j)


def along(
    experiment: Experiment,
    kinematics: Kinematics,
    gains: Gains,
    q: np.ndarray,
    *,
    stiffness: np.ndarray,
    q_c: np.ndarray,
) -> SampledLoop:
    """The loop at poses of a motion.

    Args:
        experiment: gives α₀, Γ_k, Γ_qe, the time step and the integrator.
        kinematics: of the arm.
        gains: its feedback, α and the form of (8).
        q: joint angles at the poses (P, n) [rad].
        stiffness: of the springs (n,) [N m/rad].
        q_c: centre of the regressor of (6) (n,) [rad].

    Note:
        Gravity, Coriolis torque, friction other than viscous, the motors' limits and the bounds of
        the springs are left out. None of them matters far above the motion's own frequencies.
    """
    law, dt, robot = experiment.law, experiment.simulation.timestep, kinematics.robot
    n = robot.n
    M = np.array([kinematics.inertia(pose) for pose in q])
    J = kinematics.jacobians(q)
    C = error_signal(robot, gains.jacobian, J, gains.alpha, gains.alpha_0)
    Jt = J.swapaxes(-1, -2)
    by_hand = np.block([Jt @ (gains.k_p[:, None] * J), Jt @ (gains.k_v[:, None] * J)])
    F = by_hand + gains.feedback @ C
    D = np.diag(robot.damping)
    integrate = _RK4 if experiment.simulation.integrator == "RK4" else _semi_implicit
    A, B = integrate(M, D, np.diag(stiffness), dt)
    A = A - B @ F
    rate = np.asarray(law.gamma_k) * (q - q_c) ** 2 + np.asarray(law.gamma_qe)
    if rate.any():
        # σ acts as u does, and follows y by explicit Euler.
        none = np.zeros((len(q), n, n))
        A = np.block([[A, B], [-dt * rate[..., None] * C, none + np.eye(n)]])
        B, C, F = np.block([[B], [none]]), np.block([C, none]), np.block([F, none])
    return SampledLoop(A, B, C, F)


def error_signal(
    robot: Robot, jacobian: str, J: np.ndarray, alpha: float, alpha_0: float
) -> np.ndarray:
    """C of y = C (Δq, Δq̇), (8) where Δx = J Δq is small, at each Jacobian (P, n, 2n)."""
    n, m = robot.n, robot.m
    Jt = J.swapaxes(-1, -2)
    if jacobian == "transpose":
        rate = Jt @ J
        return np.block([alpha * rate, rate])
    rate = np.broadcast_to(np.eye(n), (len(J), n, n))
    if jacobian == "inverse":
        return np.block([alpha * rate, rate])
    # As in `equations.error_damped`: J⁺J, damped near singular poses.
    JJt = J @ Jt
    scale = np.trace(JJt, axis1=-2, axis2=-1) / m
    manipulability = np.sqrt(np.maximum(np.linalg.det(JJt), 0.0))
    lack = np.maximum(1 - manipulability / (0.1 * robot.usual), 0.0) if robot.usual else 0 * scale
    damping = (1e-10 + 1e-2 * lack**2) * scale
    task = Jt @ np.linalg.solve(JJt + damping[:, None, None] * np.eye(m), J)
    return np.block([alpha_0 * rate + (alpha - alpha_0) * task, rate])


def _semi_implicit(
    M: np.ndarray, D: np.ndarray, K: np.ndarray, dt: float
) -> tuple[np.ndarray, np.ndarray]:
    """Euler and implicitfast: q̇ with the damping of the end of the step, then q with this q̇."""
    identity = np.broadcast_to(np.eye(M.shape[-1]), M.shape)
    push = dt * np.linalg.inv(M + dt * D)
    A_v = np.block([-push @ K, identity - push @ D])
    A = np.block([[np.block([identity, 0 * M]) + dt * A_v], [A_v]])
    return A, np.block([[dt * push], [push]])


def _RK4(  # noqa: N802
    M: np.ndarray, D: np.ndarray, K: np.ndarray, dt: float
) -> tuple[np.ndarray, np.ndarray]:
    """Runge-Kutta of fourth order: the first terms of e^{AΔt} and of its integral."""
    identity, inverse = np.broadcast_to(np.eye(M.shape[-1]), M.shape), np.linalg.inv(M)
    step = dt * np.block([[0 * M, identity], [-inverse @ K, -inverse @ D]])
    A = term = np.broadcast_to(np.eye(step.shape[-1]), step.shape)
    whole = np.zeros_like(step)
    for order in range(1, 5):
        whole = whole + term / order
        term = term @ step / order
        A = A + term
    return A, whole @ np.block([[0 * M], [dt * inverse]])
