"""A home pose for an arm whose author gives none: well-conditioned, free, and always the same."""

from __future__ import annotations

import mujoco
import numpy as np

from .mjcf import Arm

SAMPLES = 3000


def find(arm: Arm) -> np.ndarray:
    """Joint angles (n,) [rad or m] away from joint limits, singular poses and contacts.

    Of poses drawn with a fixed seed, the one with the best product of the tool Jacobian's smallest
    singular value and the distance to the nearest joint limit, among those without a contact; among
    all where bodies that overlap leave none without.
    """
    model, data, joint_id = arm.model, arm.at_home, arm.joint_id
    rng = np.random.default_rng(20)
    limited = model.jnt_limited[joint_id].astype(bool)
    slide = model.jnt_type[joint_id] == int(mujoco.mjtJoint.mjJNT_SLIDE)
    free = np.where(slide, 0.5, np.pi)
    low = np.where(limited, model.jnt_range[joint_id, 0], -free)
    high = np.where(limited, model.jnt_range[joint_id, 1], free)
    best, pose = -1.0, None
    best_touching, touching = -1.0, (low + high) / 2
    for _ in range(SAMPLES):
        share = rng.uniform(0.15, 0.85, len(joint_id))
        q = low + share * (high - low)
        jacobian = arm.jacobian(q)
        margin = np.where(limited, 2 * np.minimum(share, 1 - share), 1.0).min()
        score = margin * _conditioning(jacobian)
        if score > best:
            mujoco.mj_collision(model, data)
            if data.ncon == 0:
                best, pose = score, q
            elif score > best_touching:
                best_touching, touching = score, q
    return touching if pose is None else pose


def _conditioning(jacobian: np.ndarray) -> float:
    """Smallest singular value of the directions that the arm can move its tool in.

    Rotation counts by the size of the arm, so that both are lengths.
    """
    position = jacobian[:3]
    size = np.linalg.norm(position, axis=0).max()
    n = jacobian.shape[1]
    rows = np.vstack([position, 0.5 * size * jacobian[3:]]) if n >= 6 else position
    values = np.linalg.svd(rows, compute_uv=False)
    possible = min(n, len(values), np.count_nonzero(np.abs(rows).max(axis=1) > 1e-9 * size))
    return float(values[possible - 1])
