"""What a run asks of springs that one builds or buys, and what adjusting them is worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..errors import OutputError
from ..results.cycles import Cycle, kept
from ..results.run import Run
from ..springs.bounds import JointBounds
from ..springs.cost import Kind, mean_cost
from ..springs.elements import Element, Elements
from ..springs.fit import LinearSprings, fit
from ..springs.optimum import Optimum, best_springs
from ..springs.spring import equilibrium_angles

RISES = (0.01, 0.05)
"""Of the cost without springs, how much more a stiffness may leave."""


class PairUse(NamedTuple):
    """What the actuators of an antagonistic pair of tendons do."""

    ends: tuple[float, float]
    """Rest lengths of the tendons, measured along the pair's length [m]."""
    tension: tuple[float, float]
    """Least and greatest of both along the motion [N]."""
    holding: float
    """Mean power that they take to hold the tensions [W]."""


class Part(NamedTuple):
    """What one spring must be and take along a motion, with the best springs there.

    Units are those of the joint, or for an element of its length.
    """

    name: str
    stiffness: float
    """The best [N m/rad]; of a cubic element where its length is `center`."""
    ranges: tuple[tuple[float, float], ...] | None
    """Stiffnesses that leave at most `RISES` more, each; None for a cubic element."""
    rest: float
    """Rest angle or length [rad]; inf or -inf for one without stiffness that pushes."""
    peak: float
    """Largest torque, or force along the length [N m]."""
    travel: tuple[float, float]
    """Least and greatest angle or length from where it rests [rad]."""
    energy: float
    """Most that it stores [J]; inf for one without stiffness that pushes."""
    pair: PairUse | None = None
    """Of an antagonistic pair, what its two actuators do."""


@dataclass(frozen=True)
class PartsOfMotion:
    """Of one motion, the springs, and what the motors do without and with them.

    Attributes:
        motion: its number, from 1.
        parts: the joints' springs, then the elements.
        rms: torque of each motor without and with them (2, n) [N m].
        peak: the same of its largest torque (2, n) [N m].
        power: mean of |τ q̇| over time, summed over joints, without and with them (2,) [W].
        q: the joint motion made (N, n) [rad].
        total: torque along it of motors and springs together (N, n) [N m].
        springs: the best ones.
        joints: their names (n).
    """

    motion: int
    parts: tuple[Part, ...]
    rms: np.ndarray
    peak: np.ndarray
    power: np.ndarray
    q: np.ndarray
    total: np.ndarray
    springs: LinearSprings
    joints: tuple[str, ...]


@dataclass(frozen=True)
class SpringParts:
    """What a run asks of its springs.

    Attributes:
        name: of the run.
        joints: names of its joints (n).
        home: joint angles (n,) [rad].
        bounds: of its springs.
        motions: one by one.
        cost: what the springs leave the least of.
        worth: that over all motions without springs, with the best springs that are the
            same in all of them, and with the best for each (3,).
        common: the springs that are the same in all motions.
        changing: energy that it takes to change all springs from those of each motion to those of
            the next, and of the last to those of the first, at the angles where the next begins
            (motions,) [J]. What a spring gives on the way is not taken back. NaN where a spring
            without stiffness pushes.
    """

    name: str
    joints: tuple[str, ...]
    home: np.ndarray
    bounds: JointBounds
    motions: tuple[PartsOfMotion, ...]
    cost: Kind
    worth: np.ndarray
    common: LinearSprings
    changing: np.ndarray


def spring_parts(run: Run) -> SpringParts:
    """What the springs of a run must be and take, along the joint motions that it made last.

    Args:
        run: of which each motion has a whole cycle that was kept and tracks.

    Raises:
        OutputError: a motion has none: its springs would be those of another motion.
    """
    run.refuse_material("parts are chosen for linear ones")
    plan, last = run.plan, {cycle.motion: cycle for cycle in kept(run)}
    for motion in run.motions:
        if motion.number - 1 not in last or not motion.tracks[-1]:
            raise OutputError(
                f"run {run.experiment.name!r}: motion {motion.number} has no last cycle that "
                "follows its path, of which the springs could be judged"
            )
    cycles = [last[index] for index in sorted(last)]
    totals = [_total(cycle, plan.robot.elements) for cycle in cycles]
    bounds = plan.gains.bounds
    best = [
        best_springs(
            cycle.q, total, center=cycle.q.mean(axis=0), period=motion.period, bounds=bounds
        )
        for cycle, total, motion in zip(cycles, totals, run.motions, strict=True)
    ]
    # All motions in a row, each with the weight of its time steps in a cycle.
    q, total = np.concatenate([cycle.q for cycle in cycles]), np.concatenate(totals)
    dq = np.concatenate([cycle.dq for cycle in cycles])
    common = fit(q, total, bounds, q.mean(axis=0), dq)
    left = [total, total - common.torque(q), np.concatenate([one.torque for one in best])]
    motions = [
        _of_motion(cycle, one, plan.robot.joints) for cycle, one in zip(cycles, best, strict=True)
    ]
    return SpringParts(
        name=run.experiment.name,
        joints=plan.robot.joints,
        home=plan.robot.home,
        bounds=bounds,
        motions=tuple(motions),
        cost=run.cost,
        worth=np.array([mean_cost(bounds.objective, torque, dq) for torque in left]),
        common=common,
        changing=np.array(
            [
                _changing(best[index - 1].springs, one.springs, cycle.q[:1])
                for index, (one, cycle) in enumerate(zip(best, cycles, strict=True))
            ]
            if len(best) > 1
            else []
        ),
    )


def _total(cycle: Cycle, elements: tuple[Element, ...]) -> np.ndarray:
    """Torque of motors and springs together in a cycle (N, n) [N m]."""
    others = Elements(elements, cycle.parameters)
    acting = LinearSprings(cycle.stiffness, cycle.offset, cycle.center, others)
    return cycle.tau + acting.torque(cycle.q)


def _of_motion(cycle: Cycle, best: Optimum, joints: tuple[str, ...]) -> PartsOfMotion:
    ranges = [best.stiffness_range(rise) for rise in RISES]
    own = LinearSprings(best.stiffness, best.offset, best.center)
    exerted, parts = own.torque(cycle.q), []
    for j, joint in enumerate(joints):
        k, rest = float(best.stiffness[j]), float(best.equilibrium[j])
        peak = float(np.abs(exerted[:, j]).max())
        if not k and not peak:
            continue
        ends = [(float(each[j, 0]), float(each[j, 1])) for each in ranges]
        away = cycle.q[:, j] - rest
        stored = peak**2 / (2 * abs(k)) if k else np.inf
        travel = float(away.min()), float(away.max())
        parts.append(Part(joint, k, tuple(ends), rest, peak, travel, stored))
    of_elements = zip(*(best.element_ranges(rise) for rise in RISES), strict=True)
    for (element, p), within in zip(best.springs.others.each(), of_elements, strict=True):
        known = tuple(each for each in within if each is not None) or None
        parts.append(_of_element(element, p, known, cycle.q))
    pairs = best.torque_without_springs, best.torque
    return PartsOfMotion(
        motion=cycle.motion + 1,
        parts=tuple(parts),
        rms=np.array([np.sqrt((torque**2).mean(axis=0)) for torque in pairs]),
        peak=np.array([np.abs(torque).max(axis=0) for torque in pairs]),
        power=np.array([np.abs(torque * cycle.dq).sum(axis=1).mean() for torque in pairs]),
        q=cycle.q,
        total=best.torque_without_springs,
        springs=best.springs,
        joints=joints,
    )


def _of_element(
    element: Element, p: np.ndarray, ranges: tuple[tuple[float, float], ...] | None, q: np.ndarray
) -> Part:
    length, (_, rest) = q @ element.radii, element.rests(p)
    force = element.exerted(q, p)
    away, use = length - rest, None
    if (pair := element.pair) is not None:
        ends = pair.ends(float(p[0]), rest)
        tension = pair.tension(length, ends)
        holding = pair.holding * float((tension**2).sum(axis=1).mean())
        use = PairUse(ends, (float(tension.min()), float(tension.max())), holding)
    return Part(
        element.name,
        float(p[0]),
        ranges,
        rest,
        float(np.abs(force).max()),
        (float(away.min()), float(away.max())),
        float(np.nan_to_num(_stored(element, p, length).sum(axis=1).max(), nan=np.inf)),
        use,
    )


def _stored(element: Element, p: np.ndarray, length: np.ndarray) -> np.ndarray:
    """What an element stores at lengths (N,) above its least there or at rest (N, 1) [J].

    Of an antagonistic pair what each tendon does (N, 2); NaN for one that pushes without stiffness.
    """
    if element.pair is not None:
        return element.pair.stored(length, element.pair.ends(*element.rests(p)))
    x = length - element.center
    if len(p) == 1:
        beyond = np.maximum(x if element.kind == "above" else -x, 0.0)
        return (p[0] * beyond**2 / 2)[:, None]
    if p[-1] and not p[:-1].any():  # one without stiffness that pushes: unknown
        return np.full((len(x), 1), np.nan)
    force = np.polynomial.Polynomial([p[-1], *-p[:-1]])
    stored = -force.integ()
    rests = [root.real for root in force.roots() if abs(root.imag) < 1e-9]
    lowest = min(stored(x).min(), *(stored(root) for root in rests), np.inf)
    return (stored(x) - lowest)[:, None]


def _changing(before: LinearSprings, after: LinearSprings, q: np.ndarray) -> float:
    """Energy that springs take up where they are changed at joint angles (1, n) [J]."""
    stored = [
        [
            _stored_in_joints(one, q),
            *(_stored(*each, q @ each[0].radii) for each in one.others.each()),
        ]
        for one in (before, after)
    ]
    more = [np.subtract(later, earlier) for earlier, later in zip(*stored, strict=True)]
    return float(sum(np.maximum(one, 0.0).sum() for one in more))


def _stored_in_joints(springs: LinearSprings, q: np.ndarray) -> np.ndarray:
    """What the joints' own springs store at joint angles (1, n): (1, n) [J]."""
    k, offset, center = springs
    rest = equilibrium_angles(k, offset, center, limp=0.0)
    with np.errstate(invalid="ignore"):  # one without stiffness that pushes: 0 times inf, unknown
        return k * (q - rest) ** 2 / 2
