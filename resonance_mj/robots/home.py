"""Where an arm starts: as given, as its author has it, else well-conditioned and free."""

import mujoco
import numpy as np

from ..errors import RobotError
from ..experiments.sections import Robot
from ..text import shown
from .mjcf import Arm
from .touching import contacts, distance

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
    shares = rng.uniform(0.15, 0.85, (SAMPLES, len(joint_id)))
    poses = low + shares * (high - low)
    margins = np.where(limited, 2 * np.minimum(shares, 1 - shares), 1.0).min(axis=1)
    scores = margins * _conditioning(np.array([arm.jacobian(q) for q in poses]))
    touched: dict[int, np.ndarray] = {}
    # What touches is looked for in the best first: most arms are free in one of these.
    for i in np.argsort(-scores, kind="stable"):
        arm.pose(poses[i])
        pairs = [distance(model, one, other) for one, other, _ in contacts(model, data)]
        touched.setdefault(max(pairs, default=0), poses[i])
        if 0 in touched:
            break
    return touched[min(touched)]


def _conditioning(jacobians: np.ndarray) -> np.ndarray:
    """Smallest singular value (N,) of the directions that the arm can move its tool in (N, 6, n).

    Rotation counts by the size of the arm, so that both are lengths.
    """
    position = jacobians[:, :3]
    size = np.linalg.norm(position, axis=1).max(axis=1)
    n = jacobians.shape[2]
    rows = position
    if n >= 6:
        turning = 0.5 * size[:, None, None] * jacobians[:, 3:]
        rows = np.concatenate([position, turning], axis=1)
    values = np.linalg.svd(rows, compute_uv=False)
    moved = (np.abs(rows).max(axis=2) > 1e-9 * size[:, None]).sum(axis=1)
    possible = np.minimum(moved, values.shape[1])
    return np.take_along_axis(values, possible[:, None] - 1, axis=1)[:, 0]
