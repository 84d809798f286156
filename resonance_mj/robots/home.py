"""Where an arm starts: as given, as its author has it, else well-conditioned and free."""

import mujoco
import numpy as np

from ..errors import RobotError
from ..experiments.sections import Robot
from ..text import shown
from .mjcf import Arm
from .touching import FAR, contacts, distance

SAMPLES = 3000


def chosen(given: Robot, arm: Arm) -> np.ndarray:
    """Joint angles at the start (n,) [rad or m].

    A keyframe that nobody named and that is at a joint's limit is not taken.

    Args:
        given: what the experiment says of the robot.
        arm: the arm, whose notes get a line of where it starts.

    Raises:
        RobotError: a home that is given has too few or too many angles, or is at a joint's limit.
    """
    if isinstance(given.home, tuple) and len(given.home) != len(arm.joints):
        raise RobotError(
            f"{arm.path}: robot.home has {len(given.home)} angles and the arm has "
            f"{len(arm.joints)} joints ({', '.join(arm.joints)})"
        )
    home = np.asarray(given.home, float) if isinstance(given.home, tuple) else arm.home
    limit = None if home is None or not given.limits else _at_limit(arm, home)
    if limit and given.home is not None:
        raise RobotError(
            f"{arm.path}: robot.home = {shown(given.home)}: {limit}: give angles inside it, or "
            "robot.limits = false"
        )
    if home is not None and not limit:
        if given.home is None:
            arm.notes.append("home: the keyframe 'home'")
        return home
    found = find(arm)
    instead = f"; not the keyframe 'home': {limit}" if limit else ""
    arm.notes.append(f"home: found, {np.array2string(found, precision=3, separator=', ')}{instead}")
    return found


def _at_limit(arm: Arm, home: np.ndarray) -> str | None:
    """What to say of the first joint that is at a limit, or beyond it; None if none is."""
    for name, j, q in zip(arm.joints, arm.joint_id, home, strict=True):
        low, high = arm.model.jnt_range[j]
        if arm.model.jnt_limited[j] and not low < q < high:
            return f"joint {name} is at {q:g}, and its range is {low:g} to {high:g}"
    return None


def find(arm: Arm) -> np.ndarray:
    """Joint angles (n,) [rad or m] away from joint limits, singular poses and contacts.

    Of poses drawn with a fixed seed, the one with the best product of the tool Jacobian's smallest
    singular value and the distance to the nearest joint limit, among those without a contact; where
    there is none, among those in which only neighbours touch, the nearest possible.
    """
    model, data, joint_id = arm.model, arm.at_home, arm.joint_id
    rng = np.random.default_rng(20)
    limited = model.jnt_limited[joint_id].astype(bool)
    slide = model.jnt_type[joint_id] == int(mujoco.mjtJoint.mjJNT_SLIDE)
    free = np.where(slide, 0.5, np.pi)
    low = np.where(limited, model.jnt_range[joint_id, 0], -free)
    high = np.where(limited, model.jnt_range[joint_id, 1], free)
    best = np.full(FAR + 2, -1.0)
    poses = [(low + high) / 2] * len(best)
    for _ in range(SAMPLES):
        share = rng.uniform(0.15, 0.85, len(joint_id))
        q = low + share * (high - low)
        jacobian = arm.jacobian(q)
        margin = np.where(limited, 2 * np.minimum(share, 1 - share), 1.0).min()
        score = margin * _conditioning(jacobian)
        if score > best[0]:
            touched = [distance(model, one, other) for one, other, _ in contacts(model, data)]
            kind = max(touched, default=0)
            if score > best[kind]:
                best[kind], poses[kind] = score, q
    return poses[int(np.argmax(best > -1.0))]


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
