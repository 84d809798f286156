"""The terms of the stability proof: what (9), (11), (12) leave over, V of (16), (15), N of (22).

What is left over is a share of a torque per joint, 0 where the equation holds.

V is half of (16), with Δq̄_eᵀ Γ_qe⁻¹ Δq̄_e as its last term: the derivative (17) asks for both. And
α² s(Δx)ᵀ R_J s(Δx) / 2 is added, which completes the first and third terms of (16) to the square
yᵀ R y / 2: V is positive for any gains. docs/certificates.md derives it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...experiments.law_section import Law
from ...laws import learning
from ...plan.plan import Plan
from ...results.cycles import Cycle
from ...springs import spring
from ...springs.bounds import Bounds
from ...springs.cost import Cost, usual_torque, velocity
from ...springs.elements import Elements
from ...springs.fit import LinearSprings, asked_for, feasible
from ...springs.optimum import Optimum

Handover = Callable[[Cycle, Cycle, Plan], tuple[np.ndarray, np.ndarray]]
"""What (9) and (11) leave over (n,), (n,) from a cycle to the next."""


def printed(now: Cycle, then: Cycle, plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """The law as printed. (9): u(t+T) is u - β y but for a multiple of q̄. (11): u(t+T) ⟂ q̄."""
    v, q_bar = _learned(now, plan), now.q - plan.q_s
    dropped = v - then.u
    return share(dropped - _along(dropped, q_bar), v), share(_along(then.u, q_bar), v)


def transferred(now: Cycle, then: Cycle, plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """The transfer law. (9): motor and spring go on as before. (11): the spring takes no more."""
    v = _learned(now, plan)
    begins = LinearSprings(then.stiffness[0], then.offset[0], then.center, elements(then, plan))
    ended = LinearSprings(now.last_stiffness, now.last_offset, now.center, elements(now, plan))
    before = v + ended.torque(now.q)
    after = then.u + begins.torque(now.q)
    period = len(now.q) * plan.experiment.simulation.timestep
    dq = velocity(learning.low_pass(now.q, plan.gains.harmonics), period)
    bounds = plan.gains.bounds
    left = untaken(pull(then.u, dq, before, bounds.objective), now.q, begins, bounds)
    return share(after - before, before), share(left, v)


def elements(cycle: Cycle, plan: Plan) -> Elements:
    """The elastic elements besides the joints' springs, as they are in a cycle."""
    return Elements(plan.robot.elements, cycle.parameters)


def optimal(best: Optimum, bounds: Bounds) -> np.ndarray:
    """(12), and with bounds what takes its place: the best springs take no more of τ_dopt (n,)."""
    whole = best.torque_without_springs
    pulls = pull(best.torque, best.dq, whole, bounds.objective)
    left = untaken(pulls, best.q, best.springs, bounds)
    return share(left, best.torque_without_springs)


def pull(
    torque: np.ndarray, dq: np.ndarray, whole: np.ndarray, objective: Cost | None
) -> np.ndarray:
    """What pulls at the springs in the place of the motors' torque (N, n) [N m].

    That torque itself, or of a cost of power its slope by the torque over its mean curvature.

    Args:
        torque: of the motors (N, n) [N m].
        dq: joint velocities (N, n) [rad/s].
        whole: torque of motors and springs together (N, n) [N m].
        objective: what is to be least; None for torque².
    """
    if objective is None:
        return torque
    _, slope, curvature = objective.smooth(torque, dq, usual_torque(whole))
    return np.asarray(slope / curvature.mean(axis=0))


def untaken(torque: np.ndarray, q: np.ndarray, acting: LinearSprings, bounds: Bounds) -> np.ndarray:
    """Torque that would go from the motors to the springs if these were moved to the best feasible.

    It vanishes where the projected gradient of ∫τ² dt does, and is found from this torque alone, so
    that it does not repeat what the springs were found by. Where no bound is active it is zero if
    ∫τ (q - c) dt = 0 for every constant c; where one is, by the variational inequality.

    Args:
        torque: of the motors over a cycle, or the `pull` of another cost (N, n) [N m].
        q: joint angles over it (N, n) [rad].
        acting: the springs that act meanwhile.
        bounds: of the springs.

    Returns:
        Torque (N, n) [N m].
    """
    step = asked_for(q, torque)
    here = acting.about(step.center)
    wanted = LinearSprings(here.stiffness + step.stiffness, here.offset + step.offset, step.center)
    there = feasible(wanted, q, bounds, acting.center).about(step.center)
    moved = LinearSprings(there.stiffness - here.stiffness, there.offset - here.offset, step.center)
    return moved.torque(q)


def share(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Root mean square of a part over that of the whole (n,); no part of nothing is 0."""
    size, of = (np.sqrt((signal**2).mean(axis=0)) for signal in (part, whole))
    return np.divide(size, of, out=np.where(size > 0, np.inf, 0.0), where=of > 0)


def _learned(cycle: Cycle, plan: Plan) -> np.ndarray:
    """What a cycle teaches, u - β y, with the harmonics that the law keeps."""
    v = cycle.u - learning.corrected(cycle.y, plan.gains.learning, plan.gains.lead)
    return learning.low_pass(v, plan.gains.harmonics)


def _along(torque: np.ndarray, q_bar: np.ndarray) -> np.ndarray:
    """The part w q̄ of a torque (N, n) that (10) finds in it."""
    return learning.spring_like_part(torque, q_bar) * q_bar


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
    """The terms of (15) and (22) for a cycle, and the optimum of the motion that it repeats."""
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
