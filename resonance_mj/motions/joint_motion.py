"""A joint motion over one cycle, and its rate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class JointMotion(NamedTuple):
    """A joint motion over one cycle."""

    q: np.ndarray
    """Joint angles q_d (N, n) [rad]."""
    dq: np.ndarray
    """Joint velocities (N, n) [rad/s]."""
    ddq: np.ndarray
    """Joint accelerations (N, n) [rad/s^2]."""


def periodic_rate(values: np.ndarray, period: float) -> np.ndarray:
    """Time derivative of a signal over a cycle (N, n), by central differences of fourth order."""
    dt = period / len(values)

    def ahead(k: int) -> np.ndarray:
        return np.roll(values, -k, axis=0)

    return (8 * (ahead(1) - ahead(-1)) - (ahead(2) - ahead(-2))) / (12 * dt)
