"""What the stability proof of Sec. V claims, checked on a run: (9), (11), (12), (15), (22).

A run is read, never simulated. What the proof knows and the law does not, the desired joint motion
and its best springs, comes from inverse kinematics and inverse dynamics.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...errors import RobotError
from ...plan.plan import Plan
from ...results.cycles import Cycle, kept
from ...results.run import Run, Status
from ...springs.elements import Elements
from ...springs.fit import LinearSprings
from ...springs.optimum import Optimum, best_springs
from ...text import listed, shown
from .proof import Balance, Handover, balance, optimal, printed, transferred

FLOOR = 1e-6
"""Changes of N below this share of a motion's first N are the integrator's, not the law's."""

HANDOVERS: dict[str, Handover] = {"paper": printed, "transfer": transferred}
"""What (9) and (11) leave over, for each law with a proof."""

ROUNDING = 1e-10
"""Share of a torque that may be left over of an orthogonality."""


class Claim(NamedTuple):
    """What is claimed of a run: the paper's equation, in a few words, what its value must be."""

    equation: str
    text: str
    needed: str


NOTHING_LEFT = f"≤ {ROUNDING:g}"

OF_A_CYCLE: dict[str, tuple[Claim, Claim]] = {
    "paper": (
        Claim("(9)", "u(t+T) = u - βy - w q̄", NOTHING_LEFT),
        Claim("(11)", "u(t+T) ⟂ q̄", NOTHING_LEFT),
    ),
    "transfer": (
        Claim("(9)", "motor+spring unchanged", NOTHING_LEFT),
        Claim("(11)", "u(t+T) ⟂ 1, q", NOTHING_LEFT),
    ),
}
"""Of each law with a proof, from a cycle to the next."""

OPTIMAL = Claim("(12)", "τ_dopt ⟂ q̄_d", NOTHING_LEFT)
PASSIVE = Claim("(15)", "c_7", "> 0")
FALLING = Claim("(22)", "N falls: next N / N", "≤ 1")


@dataclass(frozen=True)
class Certificate:
    """One claim, judged on one motion of a run.

    Attributes:
        motion: number of the motion, from 1.
        claim: what is claimed.
        cycles: numbers in the run of the cycles with a value (C,); empty for (12).
        values: share left over (C, n) for (9) and (11), (1, n) for (12); c_7 (C,) for (15); N [J]
            (C,) for (22).
        fails: which of the values make the claim fail, (C,) or (1,).
        worst: the value that is worst; of (22) the largest ratio of N to that of the cycle before.
            None if nothing was judged.
        where: cycle of the worst and joint, as far as it has them.
        note: why nothing was judged; else empty.
    """

    motion: int
    claim: Claim
    cycles: np.ndarray
    values: np.ndarray
    fails: np.ndarray
    worst: float | None = None
    where: str = ""
    note: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the claim holds wherever it was judged; None if it was not judged."""
        return None if self.worst is None else not self.fails.any()


@dataclass(frozen=True, repr=False)
class Certificates:
    """The certificates of a run.

    Attributes:
        name: of the run.
        items: the certificates, motion by motion.
        joints: names of the joints (n).
        unit: of c_7.
        enough: c_7 from which on N falls, but for the third term of (23): half the largest
            eigenvalue of the learning gain, β/2.
    """

    name: str
    items: tuple[Certificate, ...]
    joints: tuple[str, ...]
    unit: str
    enough: float

    def __repr__(self) -> str:
        judged = [item for item in self.items if item.holds is not None]
        failed = [f"{one.claim.equation} in motion {one.motion}" for one in judged if not one.holds]
        not_all = f", but not {listed(failed)}" if failed else ""
        held = f"{len(judged) - len(failed)} of {len(judged)} hold{not_all}"
        return f"<Certificates of {self.name!r}: {held}>"

    def of(self, equation: str) -> list[Certificate]:
        """The certificates of one equation, such as "(15)", motion by motion."""
        return [item for item in self.items if item.claim.equation == equation]


def certify(run: Run) -> Certificates:
    """Check on a run what the proof claims, in the cycles whose samples were kept.

    Args:
        run: from `simulate` or `Run.load`, whole or thinned, however it ended.

    Returns:
        For each motion: what is learned, (9); its orthogonality, (11); that of the optimum, (12);
        the passivity (15); N of (22). One that does not apply says why.

    Raises:
        OutputError: its springs are not linear.
        RobotError: the robot's file is missing, or is not the one that was run.
        MotionError: the arm cannot follow the motion: likewise.
    """
    run.refuse_material("the proof is of linear ones")
    plan, cycles = run.plan, kept(run)
    square = plan.robot.m == plan.robot.n
    if square:
        _check_robot(run, plan)
    numbered, items = {cycle.number: cycle for cycle in cycles}, list[Certificate]()
    for index in range(len(plan.joints)):
        mine = [cycle for cycle in cycles if cycle.motion == index and not cycle.passage]
        best = plan.optima[index] if square else _of_motion_made(run, mine)
        items += _handovers(index + 1, mine, numbered, plan)
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
    others = Elements(run.plan.robot.elements, last.parameters)
    acting = LinearSprings(last.stiffness, last.offset, last.center, others)
    return best_springs(
        last.q,
        last.tau + acting.torque(last.q),
        center=last.center,
        period=run.motions[last.motion].period,
        bounds=run.plan.gains.bounds,
    )


def _handovers(
    motion: int, mine: list[Cycle], numbered: dict[int, Cycle], plan: Plan
) -> list[Certificate]:
    """(9) and (11), from each cycle to the next, where that was kept and has as many samples."""
    following = ((now, numbered.get(now.number + 1)) for now in mine)
    pairs = [(now, then) for now, then in following if then and len(then.q) == len(now.q)]
    kind = plan.experiment.law.kind
    claims = OF_A_CYCLE.get(kind, OF_A_CYCLE["paper"])
    peak = plan.experiment.springs.cost == "peak"
    if kind not in HANDOVERS or not pairs or peak:
        why = NO_SLOPE if peak else NO_PAIRS if kind in HANDOVERS else _no_proof(kind)
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
    asked = plan.experiment.springs.cost
    if kind not in HANDOVERS:
        why = _no_proof(kind)
    elif asked != "torque-squared":
        why = f"V of (14) is of torque², and springs.cost = {asked!r}"
    elif plan.robot.joint_space:
        why = "V of (14) is of a task of the tool"
    elif chosen.jacobian == "transpose":
        why = "there is no proof with Jᵀ in (8)"
    elif np.linalg.matrix_rank(chosen.learning) < plan.robot.n:
        why = "the learning gain is 0"
    elif plan.robot.elements:
        why = "V of (14) is of the joints' own springs, and there are other elements"
    elif best is not None and len(mine) < 2:
        why = "no two cycles were kept"
    rest = [unknown(motion, claim, why or NO_MOTION) for claim in (PASSIVE, FALLING)]
    if best is None:
        return [unknown(motion, OPTIMAL, NO_MOTION), *rest]
    if asked == "peak":
        return [unknown(motion, OPTIMAL, NO_SLOPE), *rest]
    left = optimal(best, plan.gains.bounds)[None]
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


def judged(
    motion: int,
    claim: Claim,
    cycles: np.ndarray,
    values: np.ndarray,
    fails: np.ndarray,
    bad: np.ndarray,
    joints: tuple[str, ...] = (),
) -> Certificate:
    """A certificate whose worst value is where `bad`, (C,) or (C, n), is largest."""
    row, *joint = at = np.unravel_index(np.argmax(bad), bad.shape)
    where = [str(number) for number in cycles[row : row + 1]] + [joints[j] for j in joint]
    worst = float(values[at])
    return Certificate(motion, claim, cycles, values, fails, worst, ", ".join(where))


def left_over(
    motion: int, claim: Claim, cycles: np.ndarray, left: np.ndarray, joints: tuple[str, ...]
) -> Certificate:
    """A certificate on what is left over of a torque, (C, n), or (1, n) without cycles."""
    return judged(motion, claim, cycles, left, np.any(~(left <= ROUNDING), axis=1), left, joints)


def unknown(motion: int, claim: Claim, why: str) -> Certificate:
    """A certificate that could not be judged."""
    nothing = np.zeros(0)
    return Certificate(motion, claim, nothing.astype(int), nothing, nothing.astype(bool), note=why)


NO_SLOPE = "a peak has no slope that vanishes at its least"
NO_PAIRS = "no two cycles in a row were kept"
NO_MOTION = "the task leaves joints free, and no last motion was made to compare with"


def _no_proof(kind: str) -> str:
    return f"claimed of the laws {' and '.join(HANDOVERS)}, not of {kind}"
