"""Which springs of a catalogue leave the motors least: exactly, also where elements couple joints.

Joints that no element couples are chosen for one by one, others together, by branch and bound (Land
and Doig, Econometrica 28, 1960). A node is a range of the catalogue, by stiffness, for each spring.
Springs of any stiffness within the ranges leave at most as much as any of their parts, and are
found by a convex program; a node of one part each is an answer, and the first answer among the
nodes in the order of what they leave is the best of all.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import count
from typing import NamedTuple

import numpy as np

from ..errors import OutputError
from ..springs.bounds import adjusted
from ..springs.fit import LinearSprings, fit
from .spring_catalogue import Bought
from .spring_parts import PartsOfMotion, SpringParts
from .spring_relaxation import Place, Ranges, Relaxation

NODES = 20_000
"""Ranges of parts that are looked at, at most."""

DIGITS = 9
"""To which what two choices leave is the same, and the cheaper is taken."""


class Mounted(NamedTuple):
    """A part on a joint or an element."""

    on: str
    part: Bought | None
    """None for no spring."""
    rest: float
    """Angle or length at which it rests [rad]; NaN for none."""


@dataclass(frozen=True)
class Selection:
    """The best parts for some motions together.

    Attributes:
        motions: their numbers (m,), from 1.
        mounted: on each joint and element the same part, in all of them.
        left: mean torque² of each motion with them (m,) [N² m²].
        without: without any spring that could be bought (m,).
        best: with the best springs of any stiffness for each (m,).
    """

    motions: tuple[int, ...]
    mounted: tuple[Mounted, ...]
    left: np.ndarray
    without: np.ndarray
    best: np.ndarray


def selections(
    found: SpringParts, catalogue: tuple[Bought, ...], together: str | None = None
) -> tuple[Selection, ...]:
    """The parts that are best for each motion, or one set for all of them.

    Args:
        found: what a run asks of its springs.
        catalogue: the parts.
        together: "mean", one set that leaves the least of all motions in a row; "worst", one that
            leaves the least of the largest share of torque² that it leaves of any; None for a set
            per motion.

    Raises:
        OutputError: the catalogue is too large to be sure of the best.
    """
    every = found.motions
    groups = [(motion,) for motion in every] if together is None else [every]
    return tuple(_selection(found, catalogue, group, worst=together == "worst") for group in groups)


def _selection(
    found: SpringParts,
    catalogue: tuple[Bought, ...],
    motions: tuple[PartsOfMotion, ...],
    *,
    worst: bool,
) -> Selection:
    springs = _springs(found, catalogue, np.concatenate([motion.q for motion in motions]))
    needed = [_needed(motion, springs) for motion in motions]
    without = np.array([_mean_square(torque) for torque in needed])
    mounted: dict[str, Mounted] = {}
    left = [torque.copy() for torque in needed]
    for some in [springs] if worst and len(motions) > 1 else _coupled(springs):
        problem = Relaxation(some, motions, needed, without if worst else None)
        for one, part, rest in zip(some, *_best(problem), strict=True):
            mounted[one.name] = Mounted(one.name, part, rest)
            for torque, motion in zip(left, motions, strict=True):
                if part is not None:
                    torque += np.outer(part.rate * (motion.q @ one.along - rest), one.along)
    return Selection(
        tuple(motion.motion for motion in motions),
        tuple(mounted[one.name] for one in springs),
        np.array([_mean_square(torque) for torque in left]),
        without,
        np.array([_least(found, motion) for motion in motions]),
    )


def _springs(found: SpringParts, catalogue: tuple[Bought, ...], q: np.ndarray) -> tuple[Place, ...]:
    """The springs that a part can stand for, with the parts that bear joint angles (N, n)."""
    own = zip(
        found.joints,
        np.eye(len(found.joints)),
        adjusted(found.bounds, len(found.joints)),
        strict=True,
    )
    places = [(name, along) for name, along, adjusted in own if adjusted]
    places += [(one.name, one.radii) for one in found.bounds.elements if one.kind == "linear"]
    springs = []
    for name, along in places:
        lengths = q @ along
        low, high, home = float(lengths.min()), float(lengths.max()), float(found.home @ along)
        borne = [
            (part.rate, part, rests)
            for part in catalogue
            if (not part.fits or name in part.fits) and (rests := part.rests(low, high, home))
        ]
        borne.sort(key=lambda each: each[0])
        parts = (None, *(part for _, part, _ in borne))
        rates = np.array([0.0, *(rate for rate, _, _ in borne)])
        within = np.array([(np.nan, np.nan), *(rests for _, _, rests in borne)])
        springs.append(Place(name, along, parts, rates, within))
    return tuple(springs)


def _needed(motion: PartsOfMotion, springs: tuple[Place, ...]) -> np.ndarray:
    """Torque along a motion (N, n) without the springs that parts stand for [N m]."""
    replaced, best = {one.name for one in springs}, motion.springs
    stays = [joint not in replaced for joint in motion.joints]
    kept = LinearSprings(best.stiffness * stays, best.offset * stays, best.center)
    torque = motion.total - kept.torque(motion.q)
    for element, p in best.others.each():
        if element.name not in replaced:
            torque = torque - np.outer(element.exerted(motion.q, p), element.radii)
    return torque


def _least(found: SpringParts, motion: PartsOfMotion) -> float:
    """Mean torque² with the springs within the bounds that leave the least of it [N² m²]."""
    bounds = found.bounds._replace(objective=None)
    springs = fit(motion.q, motion.total, bounds, motion.q.mean(axis=0))
    return _mean_square(motion.total - springs.torque(motion.q))


def _mean_square(torque: np.ndarray) -> float:
    """Mean of the sum of squares of torques (N, n)."""
    return float((torque**2).sum(axis=1).mean())


def _coupled(springs: tuple[Place, ...]) -> list[tuple[Place, ...]]:
    """The springs in groups that share no joint with each other."""
    groups: list[list[Place]] = []
    for one in springs:
        near = [group for group in groups if any((one.along * each.along).any() for each in group)]
        groups = [group for group in groups if group not in near]
        groups.append([each for group in near for each in group] + [one])
    return [tuple(group) for group in groups]


def _best(problem: Relaxation) -> tuple[list[Bought | None], list[float]]:
    """The best part and its rest, spring by spring; of equal ones the cheapest.

    Raises:
        OutputError: after `NODES` ranges it is not sure.
    """
    springs, number = problem.springs, count()
    prices = [np.array([part.price if part else 0.0 for part in one.parts]) for one in springs]

    def bounded(node: Ranges) -> tuple[float, float, int, Ranges, np.ndarray]:
        left, parameters = problem.relaxed(node)
        cheapest = [of[a : b + 1].min() for of, (a, b) in zip(prices, node, strict=True)]
        return float(f"{left:.{DIGITS}g}"), float(sum(cheapest)), next(number), node, parameters

    nodes = [bounded(tuple((0, len(one.parts) - 1) for one in springs))]
    while next(number) < NODES:
        *_, node, parameters = heapq.heappop(nodes)
        widest = max(range(len(node)), key=lambda at: node[at][1] - node[at][0])
        first, last = node[widest]
        if first == last:
            rests = parameters[1::2] / np.where(parameters[::2], parameters[::2], np.nan)
            chosen = [one.parts[at] for one, (at, _) in zip(springs, node, strict=True)]
            return chosen, (problem.centers + rests).tolist()
        below = np.searchsorted(springs[widest].rates[first:last], parameters[2 * widest], "right")
        middle = first + max(int(below), 1)
        for part in ((first, middle - 1), (middle, last)):
            heapq.heappush(nodes, bounded((*node[:widest], part, *node[widest + 1 :])))
    raise OutputError(
        f"the catalogue: after {NODES} combinations of ranges the best is not sure; leave out "
        "parts or say in the column fits what each fits"
    )
