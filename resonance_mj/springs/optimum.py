"""The optimum: the best constant springs for a joint motion, (2), (3), and what they leave over."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..text import percent, shown
from .bounds import Bounds
from .cost import KINDS, velocity
from .fit import LinearSprings, fit, reach
from .spring import STILL, equilibrium_angles


@dataclass(frozen=True, repr=False)
class Optimum:
    """The constant springs that are best for one motion, and what they leave to the motors.

    They minimise (3), or another cost if their bounds have one.

    Attributes:
        springs: the best ones, (n,) each.
        period: cycle time [s].
        q: the joint motion (N, n) [rad].
        torque: τ_dopt, the motors' torque with these springs (N, n) [N m].
        torque_without_springs: τ_d(0, 0, t) (N, n) [N m].
        bounds: of the springs.
    """

    springs: LinearSprings
    period: float
    q: np.ndarray
    torque: np.ndarray
    torque_without_springs: np.ndarray
    bounds: Bounds

    def __repr__(self) -> str:
        k, q_e = (shown(np.round(v, 3)) for v in (self.stiffness, self.equilibrium))
        what, less = KINDS[self.kind].name, percent(self.reduction)
        return f"<Optimum: stiffness {k}, equilibrium {q_e}, {what} less by {less}>"

    @property
    def stiffness(self) -> np.ndarray:
        """K_opt (n,) [N m/rad]."""
        return self.springs.stiffness

    @property
    def offset(self) -> np.ndarray:
        """q̄_e,opt about `center` (n,) [N m]."""
        return self.springs.offset

    @property
    def center(self) -> np.ndarray:
        """q_c (n,) [rad]."""
        return self.springs.center

    @property
    def equilibrium(self) -> np.ndarray:
        """q_e,opt (n,) [rad]; inf or -inf where a spring of no stiffness must push."""
        return equilibrium_angles(self.stiffness, self.offset, self.center, limp=0.0)

    @property
    def cost(self) -> float:
        """J_min, the integral of τᵀτ over a cycle [N² m² s], or of power [J]; or the peak [1]."""
        return self._cost(self.torque)

    @property
    def cost_without_springs(self) -> float:
        """The same for K = 0."""
        return self._cost(self.torque_without_springs)

    @property
    def kind(self) -> str:
        """What is least, by the words of `springs.cost`."""
        return self.bounds.objective.kind if self.bounds.objective else "torque-squared"

    @property
    def reduction(self) -> float:
        """1 - J_min / J(0, 0); NaN for a motion that costs nothing."""
        return 1.0 - self.cost / self.cost_without_springs if self.cost_without_springs else np.nan

    @cached_property
    def dq(self) -> np.ndarray:
        """Joint velocities (N, n) [rad/s]."""
        return velocity(self.q, self.period)

    def _cost(self, torque: np.ndarray) -> float:
        """Of motors' torque (N, n) over a cycle."""
        objective = self.bounds.objective
        if objective is None:
            return _integral(torque, self.period)
        rate = objective.of(torque, self.dq)
        return rate if objective.kind == "peak" else rate * self.period

    @property
    def torque_squared(self) -> float:
        """Mean of τᵀτ over a cycle [N² m²]."""
        return _integral(self.torque, self.period) / self.period

    @property
    def torque_squared_without_springs(self) -> float:
        """Mean of τᵀτ over a cycle without springs [N² m²]."""
        return _integral(self.torque_without_springs, self.period) / self.period

    @property
    def torque_reduction(self) -> float:
        """1 - ∫τᵀτ dt / ∫τ_d(0,0,t)ᵀτ_d(0,0,t) dt; NaN for a motion that needs no torque."""
        without = _integral(self.torque_without_springs, self.period)
        return 1.0 - _integral(self.torque, self.period) / without if without else np.nan

    def stiffness_range(self, rise: float = 0.01) -> np.ndarray:
        """Stiffnesses between which the cost hardly changes, each with the best offset (n, 2).

        Other joints' springs, and elements, are as they are.

        Args:
            rise: how much more torque² they leave at most, as a share of that without springs.

        Returns:
            Least and greatest [N m/rad]; the bounds of one that makes no difference.
        """
        mean = self.q.mean(axis=0)
        low, high = reach(self.bounds, mean)
        others = self.springs.others
        needed = self.torque_without_springs
        needed = needed - others.torque(self.q) if others.elements else needed
        z, level = self.q - mean, needed.mean(axis=0)
        rest = needed - level
        allowed = rise * self.torque_squared_without_springs
        most = (self.torque**2).mean(axis=0) + allowed
        bounds = [np.broadcast_to(end, level.shape) for end in self.bounds.stiffness]
        ends = np.stack(bounds, axis=1)
        squared, both, alone = (z**2).mean(axis=0), (z * rest).mean(axis=0), (rest**2).mean(axis=0)
        for j in np.flatnonzero(squared > STILL):

            def beyond(k: float, j: int = int(j)) -> float:
                """How far torque² is above the most with a stiffness and its best offset."""
                bounded = np.isfinite(low[j]) and np.isfinite(high[j])
                reachable = (k * low[j], k * high[j]) if bounded else (-np.inf, np.inf)
                miss = min(max(level[j], reachable[0]), reachable[1]) - level[j]
                return float(squared[j] * k**2 + 2 * both[j] * k + alone[j] + miss**2 - most[j])

            # It exceeds that of the best k* by var(q) (k - k*)² at least.
            best, furthest = self.stiffness[j], np.sqrt(allowed / squared[j])
            for side, bound in enumerate(ends[j]):
                end = bound
                if abs(bound - best) > furthest:
                    end = best + (2 * side - 1) * 1.001 * furthest
                if beyond(end) > 0:
                    ends[j, side] = _crossing(beyond, best, end)
        return ends


def _integral(torque: np.ndarray, period: float) -> float:
    """∫τᵀτ dt over a cycle of torques (N, n) [N² m² s]."""
    return float((torque**2).sum() * (period / len(torque)))


def _crossing(beyond: Callable[[float], float], inside: float, outside: float) -> float:
    """Where an increasing function passes zero between two points, to rounding."""
    for _ in range(60):
        middle = (inside + outside) / 2
        inside, outside = (inside, middle) if beyond(middle) > 0 else (middle, outside)
    return inside


def best_springs(
    q: np.ndarray, torque: np.ndarray, *, center: np.ndarray, period: float, bounds: Bounds
) -> Optimum:
    """The best constant springs for a joint motion and the torque that it needs.

    Args:
        q: joint angles over a cycle, equally spaced in time (N, n) [rad].
        torque: torque that the motion needs, of motor and spring together (N, n) [N m].
        center: q_c, about which the offset torque is given (n,) [rad].
        period: cycle time [s].
        bounds: of the springs.
    """
    dq = velocity(q, period) if bounds.objective else None
    best = fit(q, torque, bounds, center, dq)
    return Optimum(best, period, q, torque - best.torque(q), torque, bounds)
