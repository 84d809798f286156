"""What the stability proof of Sec. V claims, checked on a run: (9), (11), (12), (15), (22).

A run is read, never simulated. What the proof knows and the law does not, the desired joint motion
and its best springs, comes from inverse kinematics and inverse dynamics.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...errors import RobotError
from ...plan.plan import Plan
from ...results.cycles import Cycle, kept
from ...results.run import Run, Status
from ...springs.fit import LinearSprings
from ...springs.optimum import Optimum, best_springs
from ...text import shown
from .claims import (
    FALLING,
    OF_A_CYCLE,
    OPTIMAL,
    PASSIVE,
    Certificate,
    Certificates,
    judged,
    left_over,
    unknown,
)
from .lyapunov import Balance, balance
from .orthogonality import Handover, optimal, printed, transferred

FLOOR = 1e-6
"""Changes of N below this share of a motion's first N are the integrator's, not the law's."""

HANDOVERS: dict[str, Handover] = {"paper": printed, "transfer": transferred}
"""What (9) and (11) leave over, for each law with a proof."""


def certify(run: Run) -> Certificates:
    """Check on a run what the proof claims, in the cycles whose samples were kept.

    Args:
        run: from `simulate` or `Run.load`, whole or thinned, however it ended.

    Returns:
        For each motion: what is learned, (9); its orthogonality, (11); that of the optimum, (12);
        the passivity (15); N of (22). One that does not apply says why.

    Raises:
        RobotError: the robot's file is missing, or is not the one that was run.
        MotionError: the arm cannot follow the motion: likewise.
    """
    plan, cycles = run.plan, kept(run)
    square = plan.robot.m == plan.robot.n
    if square:
        _check_robot(run, plan)
    items: list[Certificate] = []
    for index in range(len(plan.joints)):
        mine = [cycle for cycle in cycles if cycle.motion == index and not cycle.passage]
        best = plan.optima[index] if square else _of_motion_made(run, mine)
        items += _handovers(index + 1, _pairs(mine, cycles), plan)
        items += _of_optimum(index + 1, mine, best, plan)
    return Certificates(
        name=plan.experiment.name,
        items=tuple(items),
        joints=plan.robot.joints,
        unit="N s/m" if plan.robot.slides.all() else "N m s/rad",
        enough=float(np.linalg.eigvalsh(plan.gains.learning).max() / 2),
    )


def _check_robot(run: Run, plan: Plan) -> None:
    recorded = run.data["torque_squared_without_springs"].values
    now = np.array([optimum.torque_squared_without_springs for optimum in plan.optima])
    if not np.allclose(now, recorded, rtol=1e-6):
        raise RobotError(
            f"{run.experiment.robot.mjcf}: is not the robot of the run {run.experiment.name}: its "
            f"motions need torque² of {shown(now.round(3))} N² m² without springs, and those of "
            f"the run {shown(recorded.round(3))}; give the file back as it was, or run again"
        )


def _of_motion_made(run: Run, cycles: list[Cycle]) -> Optimum | None:
    """The optimum of the joint motion made last, where the task does not determine one."""
    if run.status is not Status.OK or not cycles:
        return None
    last = cycles[-1]
    acting = LinearSprings(last.stiffness, last.offset, last.center)
    return best_springs(
        last.q,
        last.tau + acting.torque(last.q),
        center=last.center,
        period=run.motions[last.motion].period,
        bounds=run.experiment.springs,
    )


def _pairs(mine: list[Cycle], cycles: list[Cycle]) -> list[tuple[Cycle, Cycle]]:
    """Each cycle with the next, where that was kept and has as many samples."""
    numbered = {cycle.number: cycle for cycle in cycles}
    pairs = ((now, numbered.get(now.number + 1)) for now in mine)
    return [(now, then) for now, then in pairs if then and len(then.q) == len(now.q)]


def _handovers(motion: int, pairs: list[tuple[Cycle, Cycle]], plan: Plan) -> list[Certificate]:
    """(9) and (11), from each cycle to the next."""
    kind = plan.experiment.law.kind
    claims = OF_A_CYCLE.get(kind, OF_A_CYCLE["paper"])
    if kind not in HANDOVERS or not pairs:
        why = NO_PAIRS if kind in HANDOVERS else _no_proof(kind)
        return [unknown(motion, claim, why) for claim in claims]
    cycles = np.array([now.number for now, _ in pairs])
    left = np.array([HANDOVERS[kind](*pair, plan) for pair in pairs])
    return [
        left_over(motion, claim, cycles, left[:, part], plan.robot.joints)
        for part, claim in enumerate(claims)
    ]


def _of_optimum(
    motion: int, mine: list[Cycle], best: Optimum | None, plan: Plan
) -> list[Certificate]:
    """(12), (15) and (22)."""
    kind, chosen = plan.experiment.law.kind, plan.gains
    why = ""
    if kind not in HANDOVERS:
        why = _no_proof(kind)
    elif chosen.jacobian == "transpose":
        why = "there is no proof with Jᵀ in (8)"
    elif np.linalg.matrix_rank(chosen.learning) < plan.robot.n:
        why = "the learning gain is 0"
    elif best is not None and len(mine) < 2:
        why = "no two cycles were kept"
    rest = [unknown(motion, claim, why or NO_MOTION) for claim in (PASSIVE, FALLING)]
    if best is None:
        return [unknown(motion, OPTIMAL, NO_MOTION), *rest]
    left = optimal(best, plan.experiment.springs)[None]
    twelve = left_over(motion, OPTIMAL, np.zeros(0, int), left, plan.robot.joints)
    if why:
        return [twelve, *rest]
    rows = [balance(cycle, best, plan) for cycle in mine]
    return [twelve, _passivity(motion, rows), _decrease(motion, rows)]


def _passivity(motion: int, rows: list[Balance]) -> Certificate:
    """(15): c_7 of each cycle whose state at the end is known, as the beginning of the next."""
    spent = {
        now.number: (now.supplied - (then.motion - now.motion) - now.adapted, now.y_squared)
        for now, then in pairwise(rows)
        if then.number == now.number + 1
    }
    least = FLOOR * rows[0].N
    c_7 = {number: a / b for number, (a, b) in spent.items() if not 2 * abs(a) <= least}
    if not c_7:
        return unknown(motion, PASSIVE, f"{NO_PAIRS}, or N is at its floor")
    cycles, values = np.array(list(c_7)), np.array(list(c_7.values()))
    return judged(motion, PASSIVE, cycles, values, ~(values > 0), -values)


def _decrease(motion: int, rows: list[Balance]) -> Certificate:
    """(22): N of each cycle; a cycle fails if N of the next that was kept is larger."""
    cycles, N = np.array([row.number for row in rows]), np.array([row.N for row in rows])
    change = np.append(np.diff(N), 0.0)
    counts = ~(np.abs(change) <= FLOOR * N[0])
    fails = counts & ~(change <= 0)
    if not counts.any():
        return Certificate(motion, FALLING, cycles, N, fails, note="N is at its floor")
    ratio = np.where(counts, 1 + change / N, -np.inf)
    return replace(judged(motion, FALLING, cycles, N, fails, ratio), worst=float(ratio.max()))


NO_PAIRS = "no two cycles in a row were kept"
NO_MOTION = "the task leaves joints free, and no last motion was made to compare with"


def _no_proof(kind: str) -> str:
    return f"claimed of the laws {' and '.join(HANDOVERS)}, not of {kind}"
