"""Springs that do not follow Hooke's law: what real ones exert, and which of them are the best.

At x from its equilibrium, moving with v, such a spring of stiffness k exerts

    -k φ(x, v),  φ = f + h |f| sgn(v) + d v,  f = (1 + ε) x (1 + c x²)

with an error ε of its stiffness, stiffening c, a share h that is lost in hysteresis and a time d of
damping: it is linear in k and not in the equilibrium, which `best` therefore searches.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..experiments.reality_section import Reality
from ..step_functions import step_function
from . import spring

TURNS = 0.01
"""Velocity about 0 within which hysteresis changes its side [rad/s]."""

PLACES, FINER = 61, 4
"""Equilibria that are tried, and how often anew between the neighbours of the best."""

NOTHING = 1e-15
"""Saving, of the torque² of the joint that needs most, for which no spring is better than one."""

FARTHEST = np.pi
"""How far from the mean angle an equilibrium is searched that has no bounds [rad]."""

Shape = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""φ (places, N) at so many x (places, N), moving with v (N,)."""


@step_function
def shape(
    x: np.ndarray,
    v: np.ndarray,
    error: Any,
    stiffening: Any,
    hysteresis: Any,
    damping: Any,
) -> np.ndarray:
    """φ [rad] at x from the equilibrium [rad], moving with v [rad/s]; arguments as `Material`'s."""
    force = (1.0 + error) * x * (1.0 + stiffening * x * x)
    return force + hysteresis * np.abs(force) * np.tanh(v / TURNS) + damping * v


class Material(NamedTuple):
    """What the springs of an arm do besides Hooke's law, (n,) each."""

    error: np.ndarray
    """ε, of the stiffness, as a share of it."""
    stiffening: np.ndarray
    """c [1/rad²]."""
    hysteresis: np.ndarray
    """h, share of the torque that is lost."""
    damping: np.ndarray
    """d [s]."""

    def torque(
        self, k: np.ndarray, offset: np.ndarray, center: np.ndarray, q: np.ndarray, dq: np.ndarray
    ) -> np.ndarray:
        """Torque of springs (k, q̄_e) about a centre, at angles and velocities (N, n) [N m]."""
        x = q - spring.equilibrium_angles(k, offset, center)
        return np.asarray(-k * shape(x, dq, *self))

    def of_joint(self, j: int) -> Shape:
        """φ of one joint."""
        own = [each[j] for each in self]
        return lambda x, v: shape(x, v, *own)


def material_of(reality: Reality, n: int) -> Material | None:
    """What the springs of n joints do besides Hooke's law; None for nothing."""
    if reality.hookean:
        return None
    given = (
        reality.spring_error,
        reality.spring_stiffening,
        reality.spring_hysteresis,
        reality.spring_damping,
    )
    return Material(*(np.broadcast_to(np.asarray(each, float), n) for each in given))


def best(
    q: np.ndarray,
    torque: np.ndarray,
    dq: np.ndarray,
    shapes: list[Shape],
    stiffness: tuple[np.ndarray, np.ndarray],
    reach: tuple[np.ndarray, np.ndarray],
    near: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness (n,) and equilibrium (n,) that leave the least torque², joint by joint.

    Args:
        q: joint angles over a cycle (N, n) [rad].
        torque: of motor and spring together (N, n) [N m].
        dq: joint velocities (N, n) [rad/s].
        shapes: φ of each joint.
        stiffness: least and greatest of each joint (n,) [N m/rad].
        reach: least and greatest equilibrium angle of each joint (n,) [rad].
        near: torque (N, n), and how far in the mean of squares (n,) that of the springs may be from
            it [N m]; a joint for which there is none such gets a stiffness of NaN.
    """
    n, mean = q.shape[1], q.mean(axis=0)
    nothing = NOTHING * (torque**2).mean(axis=0).max(initial=0.0)
    found = np.full((2, n), np.nan)
    within = [np.broadcast_to(end, n) for end in (*stiffness, *reach)]
    for j in range(n):
        least, most, low, high = (float(end[j]) for end in within)
        first = max(low, mean[j] - FARTHEST), min(high, mean[j] + FARTHEST)
        ends, still = first, q[:, j].var() <= spring.STILL
        for _ in range(1 if still else FINER):
            # Where a joint stands still the softest spring is as good as any.
            places = np.linspace(*ends, 2 if still else PLACES)
            phi = shapes[j](q[:, j] - places[:, None], dq[:, j])
            square, along = (phi**2).mean(axis=1), -(phi @ torque[:, j]) / len(q)
            allowed = np.full(len(places), least), np.full(len(places), most)
            if near is not None:
                allowed = _within(phi, square, near[0][:, j], near[1][j], least, most)
            with np.errstate(divide="ignore", invalid="ignore"):
                k = np.clip(np.where(square > 0, along / square, 0.0), *allowed)
                left = np.where(allowed[0] <= allowed[1], square * k**2 - 2 * along * k, np.inf)
            i = int(left.argmin())
            if not np.isfinite(left[i]):
                break
            if least <= 0.0 <= most and near is None and left[i] >= -nothing:
                found[:, j] = 0.0, np.clip(mean[j], low, high)
                break
            found[:, j] = k[i], places[i]
            step = places[1] - places[0]
            ends = max(first[0], places[i] - step), min(first[1], places[i] + step)
    return found[0], found[1]


def _within(
    phi: np.ndarray, square: np.ndarray, other: np.ndarray, away: float, least: float, most: float
) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest k of which |k φ + other|² is at most away² in the mean, at each place."""
    along = -(phi @ other) / len(other)
    under = along**2 - square * ((other**2).mean() - away**2)
    root = np.sqrt(np.maximum(under, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = (along - root) / square, (along + root) / square
    low, high = np.maximum(low, least), np.minimum(high, most)
    return np.where(under >= 0, low, np.inf), np.where(under >= 0, high, -np.inf)
