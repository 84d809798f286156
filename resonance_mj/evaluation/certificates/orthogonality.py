"""What is left over of (9), (11) and (12), as a share of a torque per joint: 0 where they hold."""

from collections.abc import Callable

import numpy as np

from ...laws import learning
from ...plan.plan import Plan
from ...results.cycles import Cycle
from ...springs.bounds import Bounds
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
    begins = LinearSprings(then.stiffness[0], then.offset[0], then.center)
    before = v + LinearSprings(now.last_stiffness, now.last_offset, now.center).torque(now.q)
    after = then.u + begins.torque(now.q)
    left = untaken(then.u, now.q, begins, plan.gains.bounds)
    return share(after - before, before), share(left, v)


def optimal(best: Optimum, bounds: Bounds) -> np.ndarray:
    """(12), and with bounds what takes its place: the best springs take no more of τ_dopt (n,)."""
    left = untaken(best.torque, best.q, best.springs, bounds)
    return share(left, best.torque_without_springs)


def untaken(torque: np.ndarray, q: np.ndarray, acting: LinearSprings, bounds: Bounds) -> np.ndarray:
    """Torque that would go from the motors to the springs if these were moved to the best feasible.

    It vanishes where the projected gradient of ∫τ² dt does, and is found from this torque alone, so
    that it does not repeat what the springs were found by. Where no bound is active it is zero if
    ∫τ (q - c) dt = 0 for every constant c; where one is, by the variational inequality.

    Args:
        torque: of the motors over a cycle (N, n) [N m].
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
