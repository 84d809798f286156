"""What to know before a run starts: motors too weak, gains too high, poses nearly singular."""

from __future__ import annotations

import numpy as np

from .experiment import Experiment
from .gains import Gains
from .kinematics import JointMotion, Kinematics
from .optimal_springs import Optimum
from .robot import Robot

NEAR_SINGULAR = 0.02
"""Ratio of J's smallest to largest singular value below which a pose is nearly singular."""

POSES = 40
"""Poses along a cycle at which gains and singular values are looked at."""


def before(
    experiment: Experiment,
    robot: Robot,
    gains: Gains,
    found: list[JointMotion],
    optima: list[Optimum],
) -> list[str]:
    """Warnings about an experiment that can be given before it runs, a line each."""
    said = []
    for index, (joints, best) in enumerate(zip(found, optima, strict=True)):
        name = f"motion.{index}"
        kinematics = Kinematics(robot.carrying(experiment.motion[index].payload))
        poses = joints.q[:: max(1, len(joints.q) // POSES)]
        J = np.array([kinematics.jacobian(q) for q in poses])
        values = np.linalg.svd(J, compute_uv=False)
        nearest = float((values[:, -1] / values[:, 0]).min())
        if nearest < NEAR_SINGULAR:
            said.append(
                f"{name} comes near a singular pose: the smallest singular value of J falls to "
                f"{nearest:.1e} of its largest"
            )
        said += _weak_motors(name, robot, best)
        said += _unstable_feedback(name, experiment, kinematics, gains, poses, J)
    return said


def _weak_motors(name: str, robot: Robot, best: Optimum) -> list[str]:
    """Motors that cannot give the torque that a motion needs with the best springs."""
    low, high = robot.torque_limit.T
    # Of each motor the limit on the side to which its torque points.
    peaks = np.stack([best.torque.max(axis=0), -best.torque.min(axis=0)])
    limits = np.stack([high, -low])
    said = []
    for j, joint in enumerate(robot.joints):
        for peak, limit in zip(peaks[:, j], limits[:, j], strict=True):
            if peak > max(limit, 0.0):
                said.append(
                    f"{name} asks {joint} for {peak:.3g} N m even with the best springs, and its "
                    f"motor gives {limit:g}"
                    + (f", {peak / limit:.1f} times less" if limit > 0 else "")
                    + ": slow the motion down or make it smaller"
                )
    return said


def _unstable_feedback(
    name: str,
    experiment: Experiment,
    kinematics: Kinematics,
    gains: Gains,
    poses: np.ndarray,
    J: np.ndarray,
) -> list[str]:
    """Feedback that is unstable when sampled: an eigenvalue of M⁻¹ (Jᵀ K_v J + G) above 2/dt."""
    limit = 2.0 / experiment.simulation.timestep
    highest = max(
        float(
            np.linalg.eigvals(
                np.linalg.solve(
                    kinematics.inertia(q),
                    jacobian.T @ (gains.k_v[:, None] * jacobian) + gains.feedback,
                )
            ).real.max()
        )
        for q, jacobian in zip(poses, J, strict=True)
    )
    if highest <= limit:
        return []
    k_v = experiment.law.k_v
    key, value = ("law.omega", gains.omega) if k_v is None else ("law.k_v", np.max(k_v))
    return [
        f"{key} = {value:g} is unstable when sampled along {name}: its fastest mode, "
        f"{highest:.0f} 1/s, exceeds 2/dt = {limit:.0f} 1/s; the largest stable {key} is "
        f"{value * limit / highest:.3g}"
    ]
