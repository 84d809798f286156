"""Nearly singular poses along a joint motion, and whether they hinder it."""

from typing import NamedTuple

import numpy as np

from .kinematics import JointMotion, Kinematics

NEAR_SINGULAR = 0.05
"""Ratio of J's smallest to largest singular value below which a pose is nearly singular."""

SUDDEN = 10.0
"""Ratio of a joint's peak to RMS acceleration from which a nearly singular pose is a hindrance."""

POSES = 500
"""Poses along a cycle at which singular values are looked at: an arm may pass one in no time."""


class Jerk(NamedTuple):
    """A joint that moves suddenly near a singular pose."""

    ratio: float
    """Of J's singular values, the smallest to the largest, where it is least."""
    joint: int
    peak: float
    """Of its acceleration, as a multiple of its RMS."""

    def said(self, joints: tuple[str, ...]) -> str:
        """In words, given the joints' names."""
        return (
            f"the smallest singular value of J falls to {self.ratio:.1e} of its largest, and the "
            f"acceleration of {joints[self.joint]} peaks at {self.peak:.2g} times its RMS"
        )


def nearness(kinematics: Kinematics, q: np.ndarray) -> float:
    """Least ratio of J's singular values, the smallest to the largest, along angles (N, n)."""
    J = [kinematics.jacobian(some) for some in q[:: max(1, len(q) // POSES)]]
    values = np.linalg.svd(J, compute_uv=False)
    return float((values[:, -1] / values[:, 0]).min())


def jerk(kinematics: Kinematics, joints: JointMotion) -> Jerk | None:
    """The joint whose acceleration stands out most near a singular pose; None if none does."""
    ratio = nearness(kinematics, joints.q)
    peak, usual = np.abs(joints.ddq).max(axis=0), np.sqrt((joints.ddq**2).mean(axis=0))
    j = int(np.argmax(peak - SUDDEN * usual))
    if ratio >= NEAR_SINGULAR or peak[j] <= SUDDEN * usual[j]:
        return None
    return Jerk(ratio, j, float(peak[j] / usual[j]))
