"""A motion of the tool, sampled over one cycle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Samples(NamedTuple):
    """A motion over one cycle, at the start of each of its N time steps.

    Rotation, where the task has it, is the last three coordinates: in `x` the rotation vector from
    the orientation at home, in the world frame, and in `dx` and `ddx` the angular velocity and
    acceleration in the world frame, as the tool's Jacobian has them. These are not the rotation
    vector's own derivatives, from which they differ while the axis of rotation turns.
    """

    x: np.ndarray
    """Desired position x_d (N, m) [m, rad]."""
    dx: np.ndarray
    """Desired velocity (N, m) [m/s, rad/s]."""
    ddx: np.ndarray
    """Desired acceleration (N, m) [m/s^2, rad/s^2]."""
    rotates: bool = False
    """Whether the last three coordinates are a rotation."""
