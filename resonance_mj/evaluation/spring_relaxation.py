"""What springs of any stiffness within ranges of a catalogue leave: a bound for each part there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..springs import program
from .spring_catalogue import Bought
from .spring_parts import PartsOfMotion


class Place(NamedTuple):
    """A joint's own spring or a linear element, and the parts that it can be."""

    name: str
    along: np.ndarray
    """1 for its joint, or radii (n,)."""
    parts: tuple[Bought | None, ...]
    """By stiffness, from None for no spring."""
    rates: np.ndarray
    """Of the parts [N m/rad]."""
    rests: np.ndarray
    """Between which angles each may rest (parts, 2)."""


Ranges = tuple[tuple[int, int], ...]
"""First and last part of each spring."""


class Relaxation:
    """What springs leave of some motions, for any stiffness and rest of each spring."""

    def __init__(
        self,
        springs: tuple[Place, ...],
        motions: tuple[PartsOfMotion, ...],
        needed: list[np.ndarray],
        shares_of: np.ndarray | None,
    ) -> None:
        """Of each motion the least squares, reduced to as many rows as parameters.

        Args:
            springs: two parameters each, stiffness and offset about the middle of their angles.
            motions: gives the joint angles.
            needed: torque along each motion (N, n) [N m].
            shares_of: torque² of each motion (m,), of which the largest share that is left shall be
                least; None for the mean over all.
        """
        self.springs, self._worst = springs, shares_of is not None
        q = np.concatenate([motion.q for motion in motions])
        self.centers = np.array([(q @ one.along).mean() for one in springs])
        samples = [len(torque) for torque in needed]
        scale = np.full(len(needed), sum(samples)) if shares_of is None else shares_of * samples
        scale = np.where(scale > 0, scale, 1.0)  # a motion without torque has no shares
        self._reduced = []
        touched = np.any([one.along != 0 for one in springs], axis=0)
        for motion, torque, unit in zip(motions, needed, np.sqrt(scale), strict=True):
            columns = []
            for one, center in zip(springs, self.centers, strict=True):
                x = motion.q @ one.along - center
                columns += [np.outer(-x, one.along), np.outer(np.ones_like(x), one.along)]
            phi = np.stack([column[:, touched].ravel() for column in columns], axis=1)
            seen = torque if self._worst else torque[:, touched]
            Q, R = np.linalg.qr(phi)
            target = Q.T @ torque[:, touched].ravel()
            rest = float((seen**2).sum() - target @ target)
            self._reduced.append((R / unit, target / unit, rest / unit**2))

    def relaxed(self, node: Ranges) -> tuple[float, np.ndarray]:
        """The least that stiffnesses within the ranges of parts leave, and the parameters (d,)."""
        d = 2 * len(self.springs)
        rows, ends, free = [], [], np.ones(d, bool)
        for at, (one, (first, last)) in enumerate(zip(self.springs, node, strict=True)):
            if last == 0:
                free[2 * at : 2 * at + 2] = False
                continue
            low, high = one.rates[[first, last]]
            rests = one.rests[max(first, 1) : last + 1] - self.centers[at]
            least, most = rests[:, 0].min(), rests[:, 1].max()
            mine = np.array([[-1.0, 0.0], [1.0, 0.0], [least, -1.0], [-most, 1.0]])
            rows.append(np.zeros((4, d)))
            rows[-1][:, 2 * at : 2 * at + 2] = mine
            ends += [-low, high, 0.0, 0.0]
        if not rows:
            left = self._left(np.zeros(d))
            return float(left.max() if self._worst else left.sum()), np.zeros(d)
        limits = np.concatenate(rows), np.array(ends), free
        if not self._worst or len(self._reduced) == 1:
            parameters = self._weighed(np.ones(len(self._reduced)), *limits)
            return float(self._left(parameters).sum()), parameters
        return self._least_of_worst(*limits)

    def _left(self, parameters: np.ndarray) -> np.ndarray:
        """What is left of each motion (m,)."""
        return np.array([((R @ parameters - z) ** 2).sum() + rest for R, z, rest in self._reduced])

    def _weighed(
        self, weights: np.ndarray, rows: np.ndarray, ends: np.ndarray, free: np.ndarray
    ) -> np.ndarray:
        """Parameters (d,) that leave the least of all motions with weights (m,)."""
        root = np.sqrt(weights)
        phi = np.concatenate([w * R for w, (R, _, _) in zip(root, self._reduced, strict=True)])
        z = np.concatenate([w * z for w, (_, z, _) in zip(root, self._reduced, strict=True)])
        return program.best(program.Columns(phi, rows, ends, free), z, ())

    def _least_of_worst(
        self, rows: np.ndarray, ends: np.ndarray, free: np.ndarray
    ) -> tuple[float, np.ndarray]:
        """The same where the largest is to be least: with the weights for which it is greatest."""
        from scipy.optimize import minimize  # takes longer to import than a plan without it

        m = len(self._reduced)

        def less(weights: np.ndarray) -> tuple[float, np.ndarray]:
            weights = np.maximum(weights, 0.0)
            left = self._left(self._weighed(weights, rows, ends, free))
            return -float(weights @ left), -left

        sum_of_one = {"type": "eq", "fun": lambda w: w.sum() - 1.0, "jac": np.ones_like}
        found = minimize(
            less,
            np.full(m, 1.0 / m),
            jac=True,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * m,
            constraints=sum_of_one,
            options={"ftol": 1e-10},
        )
        return -float(found.fun), self._weighed(np.maximum(found.x, 0.0), rows, ends, free)
