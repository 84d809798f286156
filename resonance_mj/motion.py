"""Periodic motions of the tool in the task space, sampled over a cycle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import experiment


class Samples(NamedTuple):
    """A motion over one cycle, at the start of each of its N time steps."""

    x: np.ndarray
    """Desired position x_d (N, m) [m]."""
    dx: np.ndarray
    """Desired velocity (N, m) [m/s]."""
    ddx: np.ndarray
    """Desired acceleration (N, m) [m/s^2]."""


def sample(motion: experiment.Motion, steps: int) -> Samples:
    """Sample a motion at `steps` equal time steps of its cycle.

    Args:
        motion: offset + Σ_h sin_h sin(2π h t/T) + cos_h cos(2π h t/T), per coordinate.
        steps: number N of samples.
    """
    m = len(motion.offset)
    a, b = _columns(motion.sin, m), _columns(motion.cos, m)
    harmonics = max(a.shape[1], b.shape[1])
    a, b = (np.pad(rows, ((0, 0), (0, harmonics - rows.shape[1]))) for rows in (a, b))
    h = np.arange(1, harmonics + 1)
    phase = 2 * np.pi * np.outer(np.arange(steps) / steps, h)
    sin, cos = np.sin(phase), np.cos(phase)
    omega = 2 * np.pi * h / motion.period
    return Samples(
        x=np.asarray(motion.offset) + sin @ a.T + cos @ b.T,
        dx=cos @ (a * omega).T - sin @ (b * omega).T,
        ddx=-sin @ (a * omega**2).T - cos @ (b * omega**2).T,
    )


def _columns(rows: tuple[tuple[float, ...], ...], m: int) -> np.ndarray:
    """Rows of amplitudes, filled up with zeros to the longest (m, harmonics)."""
    width = max((len(row) for row in rows), default=0)
    return np.array([(*row, *(0.0,) * (width - len(row))) for row in rows or ((),) * m]).reshape(
        m, width
    )
