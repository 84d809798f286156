"""Whether an arm makes a joint motion with margin, and what is in the way if it does not."""

from typing import NamedTuple

import numpy as np

from ..robots.reach import reach
from ..robots.robot import Robot
from ..robots.touching import UNFELT, touching
from ..springs.bounds import UNBOUNDED, Bounds
from ..springs.optimum import best_springs
from .kinematics import JointMotion, Kinematics

GLANCE = 4
"""Every so many of them are looked at first, which most sizes that are too large do not pass."""

CONDITIONING = 0.5
"""Least ratio of J's smallest to largest singular value, as a share of that at the center."""

LIMITS = 0.05
"""Least distance to a joint's limits, as a share of its range."""

CLEARANCE = 0.01
"""Least distance between bodies that are not near each other anyway, as a share of the reach."""

MOTORS = 0.7
"""Most that the motors need with the best springs, as a share of their limits."""

NEAR_SINGULAR = 0.05
"""Ratio of J's smallest to largest singular value below which a pose is nearly singular."""

SUDDEN = 10.0
"""Ratio of a joint's peak to RMS acceleration from which a nearly singular pose is a hindrance."""

POSES = 500
"""Poses along a cycle at which singular values are looked at: an arm may pass one in no time."""


def touches(q: np.ndarray, middle: np.ndarray, robot: Robot) -> str:
    """What touches or comes near at joint angles (N, n) and does not at `middle`; empty if nothing.

    What is near in the middle may stay so, but not touch.
    """
    poses = robot.positions(q)
    clearance = CLEARANCE * reach(robot)
    near = {touch[:2] for touch in touching(robot.model, robot.positions(middle[None]), clearance)}
    found = touching(robot.model, poses, clearance)
    # A distance that is found within a clearance is 0 only to rounding: a few exact looks tell.
    exact = touching(robot.model, poses[::GLANCE]) if near else []
    for touch in (*exact, *(t for t in found if t.depth > UNFELT or t[:2] not in near)):
        how = "" if touch.depth or touch in exact else ", or nearly so"
        return f"{touch}{how} (robot.contacts = false lets bodies pass through each other)"
    return ""


def too_heavy(
    joints: JointMotion,
    kinematics: Kinematics,
    period: float,
    bounds: Bounds | None,
    share: float = MOTORS,
) -> str:
    """Which motor is too weak for a joint motion even with the best springs; empty if none is.

    A motor shall need no more than a `share` of its limits.
    """
    robot = kinematics.robot
    best = best_springs(
        joints.q,
        kinematics.torque(joints),
        center=joints.q.mean(axis=0),
        period=period,
        bounds=bounds or UNBOUNDED,
    )
    low, high = share * robot.torque_limit.T
    least, most = best.torque.min(axis=0), best.torque.max(axis=0)
    for j in np.flatnonzero((least < low) | (most > high)):
        unit = "N" if robot.slides[j] else "N m"
        return (
            f"the motor of {robot.joints[j]} gives {low[j] / share:.3g} to "
            f"{high[j] / share:.3g} {unit} and needs {least[j]:.3g} to {most[j]:.3g} {unit} even "
            "with the best springs"
        )
    return ""


def lacks_margin(q: np.ndarray, middle: np.ndarray, kinematics: Kinematics) -> str:
    """Why joint angles (N, n) come too near to a singular pose or a joint limit; empty if not."""
    robot = kinematics.robot
    J = kinematics.jacobians(np.vstack([middle, q]))
    values = np.linalg.svd(J, compute_uv=False)
    usual, *ratios = values[:, -1] / values[:, 0]
    worst = min(ratios)
    if worst < CONDITIONING * usual:
        return (
            f"it comes near a singular pose, where the singular values of J have the ratio "
            f"{worst:.2g}, and at the center {usual:.2g}"
        )
    low, high = robot.model.jnt_range[robot.joint_id].T
    # Where the center itself is nearer to a limit, half of its distance is kept.
    margin = np.clip(to_limit(middle, robot) / 2, 0.0, LIMITS * (high - low))
    near = (to_limit(q, robot) < margin) & robot.limited
    if near.any():
        j = int(np.argmax(near.any(axis=0)))
        return (
            f"joint {robot.joints[j]!r} moves from {q[:, j].min():.3g} to {q[:, j].max():.3g}, "
            f"too near to the ends of its range, {low[j]:.3g} to {high[j]:.3g}"
        )
    return ""


def beyond_range(q: np.ndarray, robot: Robot) -> str:
    """Which joint leaves its range at joint angles (N, n); empty if none does."""
    beyond = (to_limit(q, robot) < 0) & robot.limited
    if not beyond.any():
        return ""
    j = int(np.argmax(beyond.any(axis=0)))
    low, high = robot.model.jnt_range[robot.joint_id[j]]
    return (
        f"joint {robot.joints[j]!r} moves from {q[:, j].min():.3g} to {q[:, j].max():.3g}, beyond "
        f"its range, {low:.3g} to {high:.3g}"
    )


def to_limit(q: np.ndarray, robot: Robot) -> np.ndarray:
    """Distance of joint angles (..., n) to the nearer end of the range, negative beyond it."""
    low, high = robot.model.jnt_range[robot.joint_id].T
    return np.minimum(q - low, high - q)


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
    J = kinematics.jacobians(q[:: max(1, len(q) // POSES)])
    values = np.linalg.svd(J, compute_uv=False)
    return float((values[:, -1] / values[:, 0]).min())


def jerk(kinematics: Kinematics, joints: JointMotion) -> Jerk | None:
    """The joint whose acceleration stands out most near a singular pose; None if none does."""
    peak, usual = np.abs(joints.ddq).max(axis=0), np.sqrt((joints.ddq**2).mean(axis=0))
    j = int(np.argmax(peak - SUDDEN * usual))
    if peak[j] <= SUDDEN * usual[j] or (ratio := nearness(kinematics, joints.q)) >= NEAR_SINGULAR:
        return None
    return Jerk(ratio, j, float(peak[j] / usual[j]))
