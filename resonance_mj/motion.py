"""Periodic motions of the tool in the task space, sampled over a cycle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import experiment
from .errors import ExperimentError
from .robot import Robot


class Samples(NamedTuple):
    """A motion over one cycle, at the start of each of its N time steps."""

    x: np.ndarray
    """Desired position x_d (N, m) [m]."""
    dx: np.ndarray
    """Desired velocity (N, m) [m/s]."""
    ddx: np.ndarray
    """Desired acceleration (N, m) [m/s^2]."""


def sample(motion: experiment.Motion, steps: int, robot: Robot) -> Samples:
    """Sample a motion at `steps` equal time steps of its cycle.

    Args:
        motion: of any shape; center, plane and size must be given, or resolved by `resolve`.
        steps: number N of samples.
        robot: gives the task's coordinates, in whose order the samples are.
    """
    if motion.shape == "fourier":
        offset, sin, cos = motion.offset or (), motion.sin, motion.cos
    else:
        offset, sin, cos = _harmonics(motion, robot)
    return _fourier(offset, sin, cos, motion.period, steps)


def resolve(motion: experiment.Motion, robot: Robot, at_home: np.ndarray) -> experiment.Motion:
    """A motion with its center, plane and size filled in; the size is a sixth of the reach.

    Args:
        motion: as it was given.
        robot: the robot.
        at_home: the tool's position at home (m,) [m].
    """
    if motion.shape == "fourier":
        return motion
    axes = robot.position_axes
    found: dict[str, object] = {}
    if motion.center is None:
        found["center"] = tuple(float(value) for value in at_home[: len(axes)])
    if motion.plane is None:
        found["plane"] = (axes[0], axes[-1])
    if motion.size is None:
        size = 0.08
        found["size"] = (size, size / 2)
    return motion.model_copy(update=found)


Rows = tuple[tuple[float, ...], ...]


def _harmonics(motion: experiment.Motion, robot: Robot) -> tuple[tuple[float, ...], Rows, Rows]:
    """Offset, sines and cosines of an ellipse, line or eight.

    An ellipse is a cos, b sin in its plane; an eight is b sin of twice the angle, a sin; a line is
    sin in both. Rotation stays as it is at home.
    """
    axes = robot.axes
    first, second = motion.plane or (axes[0], axes[0])
    for axis in (first, second):
        if axis not in axes:
            raise ExperimentError(
                f"motion: plane = [{first!r}, {second!r}]: {axis} is not one of the task's "
                f"coordinates: {', '.join(axes)}"
            )
    a, b = motion.size or (0.0, 0.0)
    sin = {axis: [0.0, 0.0] for axis in axes}
    cos = {axis: [0.0, 0.0] for axis in axes}
    if motion.shape == "ellipse":
        cos[first][0] += a
        if second != first:
            sin[second][0] += b
    elif motion.shape == "line":
        sin[first][0] += a
        if second != first:
            sin[second][0] += b
    else:
        sin[first][0] += a
        sin[second][1] += b
    center = [*(motion.center or ()), *(0.0,) * (len(axes) - len(robot.position_axes))]
    return (
        tuple(center),
        tuple(tuple(sin[axis]) for axis in axes),
        tuple(tuple(cos[axis]) for axis in axes),
    )


def blended(before: Samples, after: Samples, cycle: int, cycles: int, period: float) -> Samples:
    """One cycle of the passage from a motion to the next, smooth to the second derivative.

    x = x_before + σ (x_after - x_before), with the minimum-jerk σ = 10 r³ - 15 r⁴ + 6 r⁵ of the
    share r of the passage that has gone by.

    Args:
        before: the motion that is left, over one cycle of the new one (N, m).
        after: the motion that begins.
        cycle: which cycle of the passage, from 0.
        cycles: number of cycles of the passage.
        period: cycle time of the new motion [s].
    """
    steps = len(after.x)
    r = ((cycle + np.arange(steps) / steps) / cycles)[:, None]
    length = cycles * period
    sigma = r**3 * (10 - 15 * r + 6 * r**2)
    d_sigma = 30 * r**2 * (1 - r) ** 2 / length
    dd_sigma = 60 * r * (1 - r) * (1 - 2 * r) / length**2
    x, dx, ddx = after.x - before.x, after.dx - before.dx, after.ddx - before.ddx
    return Samples(
        x=before.x + sigma * x,
        dx=before.dx + sigma * dx + d_sigma * x,
        ddx=before.ddx + sigma * ddx + 2 * d_sigma * dx + dd_sigma * x,
    )


def _fourier(
    offset: tuple[float, ...], sin_rows: Rows, cos_rows: Rows, period: float, steps: int
) -> Samples:
    """offset + Σ_h sin_h sin(2π h t/T) + cos_h cos(2π h t/T), per coordinate."""
    m = len(offset)
    a, b = _columns(sin_rows, m), _columns(cos_rows, m)
    harmonics = max(a.shape[1], b.shape[1])
    a, b = (np.pad(rows, ((0, 0), (0, harmonics - rows.shape[1]))) for rows in (a, b))
    h = np.arange(1, harmonics + 1)
    phase = 2 * np.pi * np.outer(np.arange(steps) / steps, h)
    sin, cos = np.sin(phase), np.cos(phase)
    omega = 2 * np.pi * h / period
    return Samples(
        x=np.asarray(offset) + sin @ a.T + cos @ b.T,
        dx=cos @ (a * omega).T - sin @ (b * omega).T,
        ddx=-sin @ (a * omega**2).T - cos @ (b * omega**2).T,
    )


def _columns(rows: tuple[tuple[float, ...], ...], m: int) -> np.ndarray:
    """Rows of amplitudes, filled up with zeros to the longest (m, harmonics)."""
    width = max((len(row) for row in rows), default=0)
    return np.array([(*row, *(0.0,) * (width - len(row))) for row in rows or ((),) * m]).reshape(
        m, width
    )
