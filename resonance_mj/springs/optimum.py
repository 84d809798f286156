"""The optimum: the best constant springs for a joint motion, (2), (3), and what they leave over."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..text import percent, shown
from .bounds import Bounds
from .cost import KINDS, mean_cost, velocity
from .fit import LinearSprings, fit
from .ranges import ranges_of_elements, stiffness_range
from .spring import equilibrium_angles


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
        if self.bounds.objective is None:
            return _integral(torque, self.period)
        return self.rate(torque) * (1.0 if self.kind == "peak" else self.period)

    def rate(self, torque: np.ndarray) -> float:
        """Mean cost of motors' torque along the motion (N, n): torque² [N² m²], power, or peak."""
        return mean_cost(self.bounds.objective, torque, self.dq)

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
            rise: how much more they cost at most, as a share of what none cost.

        Returns:
            Least and greatest [N m/rad]; the bounds of one that makes no difference.
        """
        return stiffness_range(self, rise)

    def element_ranges(self, rise: float = 0.01) -> list[tuple[float, float] | None]:
        """The same of each elastic element besides; None for a cubic one, which has no one k."""
        return ranges_of_elements(self, rise)


def _integral(torque: np.ndarray, period: float) -> float:
    """∫τᵀτ dt over a cycle of torques (N, n) [N² m² s]."""
    return float((torque**2).sum() * (period / len(torque)))


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
    dq = velocity(q, period) if bounds.objective or bounds.material else None
    best = fit(q, torque, bounds, center, dq)
    return Optimum(best, period, q, torque - best.torque(q, dq), torque, bounds)
