"""The gains of a law, as one robot has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Gains:
    """The law's gains as one robot has them.

    Attributes:
        jacobian: inverse, transpose or damped, in (8).
        velocity: of the tool, jacobian or difference.
        k_v: velocity feedback (m,) [N s/m].
        k_p: position feedback (m,) [N/m].
        feedback: G of the feedback -G y, or -G Δq̇ in joint space (n, n) [N m s/rad].
        feedback_p: G_p of the feedback -G_p s(Δq) in joint space (n, n) [N m/rad].
        omega: bandwidth ω of the inertial feedback [1/s].
        learning: what is learned from y (n, n) [N m s/rad].
        lead: control periods that learning reads y ahead.
        harmonics: harmonics that the learned torque keeps; None for all.
    """

    jacobian: str
    velocity: str
    k_v: np.ndarray
    k_p: np.ndarray
    feedback: np.ndarray
    feedback_p: np.ndarray
    omega: float
    learning: np.ndarray
    lead: int
    harmonics: int | None
