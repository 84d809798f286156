"""The energies of the stability proof: V of (16), the terms of the passivity (15), N of (22).

V is half of (16), with Δq̄_eᵀ Γ_qe⁻¹ Δq̄_e as its last term: the derivative (17) asks for both. And
α² s(Δx)ᵀ R_J s(Δx) / 2 is added, which completes the first and third terms of (16) to the square
yᵀ R y / 2: V is positive for any gains. docs/certificates.md derives it.
"""

from typing import NamedTuple

import numpy as np

from ...experiments.law_section import Law
from ...plan.plan import Plan
from ...results.cycles import Cycle
from ...springs import spring
from ...springs.optimum import Optimum


class Balance(NamedTuple):
    """A cycle's terms of (15) and (22)."""

    number: int
    """The cycle, counted from 1 in the run."""
    N: float
    """N of (22), as ∫ Δuᵀ L⁻¹ Δu dt + 2 V, V at the start; L = β I is the learning gain [J]."""
    motion: float
    """V's part about the motion, at the start [J]."""
    adapted: float
    """How much V's part about the springs grows within the cycle [J]."""
    supplied: float
    """∫ Δuᵀ y dt, y as learning reads it, ahead by its lead [J]."""
    y_squared: float
    """∫ yᵀ y dt [rad²/s]."""


def balance(cycle: Cycle, best: Optimum, plan: Plan) -> Balance:
    """The terms of (15) and (22) for a cycle.

    Args:
        cycle: of a run.
        best: optimum of the motion that it repeats.
        plan: of the run.
    """
    law, gains, dt = plan.experiment.law, plan.gains, plan.experiment.simulation.timestep
    gamma_k, gamma_qe = (np.broadcast_to(g, len(cycle.center)) for g in (law.gamma_k, law.gamma_qe))
    k, offset = compared_with(cycle, best, law)
    wanted = best.torque_without_springs - spring.torque(k, offset, best.q, cycle.center)
    du = cycle.u - wanted
    y = np.roll(cycle.y, -gains.lead, axis=0)
    begin = spring_energy(cycle.stiffness[0] - k, cycle.offset[0] - offset, gamma_k, gamma_qe)
    end = spring_energy(cycle.last_stiffness - k, cycle.last_offset - offset, gamma_k, gamma_qe)
    inertia, error = plan.kinematics.inertia(cycle.q[0]), cycle.x[0] - cycle.x_desired[0]
    motion = motion_energy(cycle.y[0], inertia, error, gains.k_p + gains.alpha * gains.k_v)
    stored = float((du * np.linalg.solve(gains.learning, du.T).T).sum() * dt)
    return Balance(
        number=cycle.number,
        N=stored + 2 * (motion + begin),
        motion=motion,
        adapted=end - begin,
        supplied=float((du * y).sum() * dt),
        y_squared=float((y * y).sum() * dt),
    )


def compared_with(cycle: Cycle, best: Optimum, law: Law) -> tuple[np.ndarray, np.ndarray]:
    """The constant springs (k, q̄_e) (n,), (n,) that Δu and V are taken from in a cycle.

    The passivity (15) holds from any constant springs. For the law as printed they are the optimum,
    as in the paper, but for what (6), (7) do not adapt, which stays as it is. The transfer law
    keeps the torque of motor and spring together while it changes the springs: there they are those
    that act as the cycle begins.
    """
    k, offset = cycle.stiffness[0], cycle.offset[0]
    if law.kind != "paper":
        return k, offset
    optimal = best.springs.about(cycle.center)
    return (
        np.where(np.asarray(law.gamma_k) > 0, optimal.stiffness, k),
        np.where(np.asarray(law.gamma_qe) > 0, optimal.offset, offset),
    )


def motion_energy(y: np.ndarray, R: np.ndarray, error: np.ndarray, weight: np.ndarray) -> float:
    """V's part about the motion, yᵀ R y / 2 + Σ (k_p + α k_v) p_s(Δx) [J].

    Args:
        y: error signal (8) (n,) [rad/s].
        R: inertia matrix at the same instant (n, n) [kg m^2].
        error: Δx (m,) [m].
        weight: k_p + α k_v (m,) [N/m].
    """
    size = np.abs(error)
    p_s = np.where(size < np.pi / 2, 1.0 - np.cos(error), 1.0 + size - np.pi / 2)
    return float(0.5 * y @ R @ y + weight @ p_s)


def spring_energy(
    dk: np.ndarray, d_offset: np.ndarray, gamma_k: np.ndarray, gamma_qe: np.ndarray
) -> float:
    """V's part about the springs, (Δkᵀ Γ_k⁻¹ Δk + Δq̄_eᵀ Γ_qe⁻¹ Δq̄_e) / 2 [J].

    Args:
        dk: stiffness from that compared with (n,) [N m/rad].
        d_offset: offset torque likewise (n,) [N m].
        gamma_k: gains of (6) (n,) [N m/rad^3]; what is not adapted does not count.
        gamma_qe: gains of (7) (n,) [N m/rad]; likewise.
    """
    away, gamma = np.concatenate([dk, d_offset]), np.concatenate([gamma_k, gamma_qe])
    return float(0.5 * np.divide(away**2, gamma, out=np.zeros_like(away), where=gamma > 0).sum())
