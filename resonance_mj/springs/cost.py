"""What springs are to leave the least of: torque², loss in copper, electrical energy, or the peak.

All are convex in the motors' torque, and so in the springs' parameters: a least is the least. In
x = τ sgn(q̇) a motor drives where x > 0 and brakes where x < 0. Its shaft, behind a gear of ratio r
and efficiency ε, gives τ_m = max(x/ε, ε x)/r + τ_f and takes P = r |q̇| τ_m + (τ_m/k_m)² from its
supply, of which a share η comes back where it is negative: max(P, η P).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

SMOOTH = 1e-3
"""Width of what rounds the corners of a cost, as a share of what is usual of its argument, while a
least is looked for."""


class Kind(NamedTuple):
    """A cost as people read it."""

    name: str
    unit: str
    """As figures and tables print it."""
    units: str
    """As datasets have it."""


KINDS = {
    "torque-squared": Kind("torque²", "N² m²", "N^2 m^2"),
    "copper": Kind("copper loss", "W", "W"),
    "energy": Kind("electrical power", "W", "W"),
    "peak": Kind("peak torque", "of rated", "1"),
}
"""By the words of `springs.cost`."""


@dataclass(frozen=True)
class Drives:
    """The motors of an arm, (n,) each.

    Attributes:
        k_m: motor constant at the shaft [N m/√W].
        gear_ratio: r, turns of the shaft per turn of the joint.
        gear_efficiency: ε.
        no_load_friction: τ_f at the shaft [N m].
        regeneration: η of the supply.
        rated_torque: at the joint [N m].
    """

    k_m: np.ndarray
    gear_ratio: np.ndarray
    gear_efficiency: np.ndarray
    no_load_friction: np.ndarray
    regeneration: float
    rated_torque: np.ndarray

    def shaft_torque(self, tau: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """Torque of the shafts in the direction of motion (N, n) [N m], at joints' τ and q̇."""
        x = tau * _sign(dq)
        efficiency = self.gear_efficiency
        geared = np.maximum(x / efficiency, x * efficiency) / self.gear_ratio
        return geared + self.no_load_friction * (dq != 0)

    def copper_loss(self, tau: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """Heat in the windings (N, n) [W]."""
        return np.asarray((self.shaft_torque(tau, dq) / self.k_m) ** 2)

    def electrical_power(self, tau: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """What each motor takes from the supply, or gives back (N, n) [W]."""
        mechanical = self.gear_ratio * np.abs(dq) * self.shaft_torque(tau, dq)
        power = mechanical + self.copper_loss(tau, dq)
        return np.asarray(np.maximum(power, self.regeneration * power))

    def peak(self, tau: np.ndarray) -> float:
        """Largest torque of a cycle, of the rated one [1]."""
        return float((np.abs(tau) / self.rated_torque).max(initial=0.0))


@dataclass(frozen=True)
class Cost:
    """What is to be least, other than torque².

    Attributes:
        kind: copper, energy or peak.
        drives: the motors.
    """

    kind: str
    drives: Drives

    def of(self, tau: np.ndarray, dq: np.ndarray) -> float:
        """The cost of a cycle: mean over time of the sum over motors [W], or the peak [1].

        Args:
            tau: motors' torque (N, n) [N m].
            dq: joint velocities (N, n) [rad/s].
        """
        if self.kind == "peak":
            return self.drives.peak(tau)
        power = getattr(self.drives, "copper_loss" if self.kind == "copper" else "electrical_power")
        return float(power(tau, dq).sum(axis=1).mean())

    def smooth(
        self, tau: np.ndarray, dq: np.ndarray, usual: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The cost of each motor at each time with its corners rounded, and its two derivatives.

        Args:
            tau: motors' torque (N, n) [N m].
            dq: joint velocities (N, n) [rad/s].
            usual: torque that says how far a corner is rounded (n,) [N m].

        Returns:
            Cost [W], and its first and second derivative by τ (N, n).
        """
        own, sign = self.drives, _sign(dq)
        low, high = own.gear_efficiency, 1 / own.gear_efficiency
        x, near = tau * sign, SMOOTH * usual
        over, is_over, bend = _ramp(x, near)
        m = (low * x + (high - low) * over) / own.gear_ratio
        m += own.no_load_friction * (dq != 0)
        m1 = (low + (high - low) * is_over) / own.gear_ratio
        m2 = (high - low) * bend / own.gear_ratio
        speed = own.gear_ratio * np.abs(dq) if self.kind == "energy" else 0.0
        heat = 1 / own.k_m**2
        power, slope = m * (speed + heat * m), speed + 2 * heat * m
        power1, power2 = m1 * slope, m2 * slope + 2 * heat * m1**2
        if self.kind == "energy":
            eta = own.regeneration
            scale = SMOOTH * (
                np.abs(usual * dq).mean(axis=0) + (usual / own.gear_ratio / own.k_m) ** 2
            )
            above, is_above, sharp = _ramp(power, scale)
            share = eta + (1 - eta) * is_above
            power2 = share * power2 + (1 - eta) * sharp * power1**2
            power, power1 = eta * power + (1 - eta) * above, share * power1
        return power, sign * power1, power2


def mean_cost(objective: Cost | None, tau: np.ndarray, dq: np.ndarray) -> float:
    """Cost of motors' torque over a cycle; the mean of τᵀτ [N² m²] if no other is asked for.

    Args:
        objective: what is to be least.
        tau: motors' torque (N, n) [N m].
        dq: joint velocities (N, n) [rad/s].
    """
    return objective.of(tau, dq) if objective else float((tau**2).sum(axis=1).mean())


def velocity(q: np.ndarray, period: float) -> np.ndarray:
    """Joint velocities over a cycle of joint angles (N, n) [rad/s], by their Fourier series."""
    steps = len(q)
    harmonic = np.arange(steps // 2 + 1)
    spectrum = np.fft.rfft(q, axis=0) * (2j * np.pi / period * harmonic)[:, None]
    if steps % 2 == 0:
        spectrum[-1] = 0.0
    return np.fft.irfft(spectrum, n=steps, axis=0)


def usual_torque(torque: np.ndarray) -> np.ndarray:
    """What is usual of each joint's torque (N, n): (n,) [N m], not 0 for one that needs none."""
    rms = np.sqrt((torque**2).mean(axis=0))
    return np.asarray(np.maximum(rms, 1e-6 * rms.max(initial=0.0)) if rms.any() else rms + 1e-3)


def _sign(dq: np.ndarray) -> np.ndarray:
    return np.where(dq < 0, -1.0, 1.0)


def _ramp(x: np.ndarray, width: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """max(x, 0) with its corner rounded, and its derivatives."""
    z = x / width
    half = 0.5 * (1.0 + np.tanh(0.5 * z))
    return width * np.logaddexp(0.0, z), half, half * (1 - half) / width
