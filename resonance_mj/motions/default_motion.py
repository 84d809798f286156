"""The size of a motion that gives none: the largest that the arm follows with margin."""

from itertools import product

import numpy as np

from ..errors import MotionError
from ..experiments.experiment import Experiment
from ..experiments.motion_section import Motion
from ..robots.reach import reach
from ..robots.touching import touching
from ..springs.bounds import Bounds, per_joint
from ..text import Note, length
from . import motion as motions
from .kinematics import JointMotion, Kinematics
from .margins import (
    GLANCE,
    LIMITS,
    NEAR_SINGULAR,
    beyond_range,
    jerk,
    lacks_margin,
    nearness,
    to_limit,
    too_heavy,
    touches,
)
from .poses import REACHED

SHARE = 0.15
"""Largest half size, as a share of the arm's reach."""

TURN = 0.5
"""Largest half size of a motion of the joints [rad]."""

SHRINK = 0.8
"""Ratio of one tried size to the one before."""

TRIES = 20
"""Sizes tried, down to about a hundredth of the first."""

POINTS = 48
"""Points of the cycle at which the arm is looked at."""

SEEN = 4
"""How many times more where a motion of a given size is looked at."""

FINE = 20
"""How many times more where a size seems to fit: near a singular pose a joint moves suddenly."""

ASIDE = (0.1, 0.2, 0.3, 0.4)
"""How far from home another center is looked for, as shares of the reach."""

ROOMY = 0.1
"""Least ratio of J's singular values at such a center."""


class NoRoomError(MotionError):
    """The arm follows no size of a motion about its center with margin, for a short `reason`."""

    def __init__(self, message: str, reason: str) -> None:
        super().__init__(message)
        self.reason = reason


def filled_in(
    experiment: Experiment, kinematics: Kinematics, alpha_0: float, notes: list[str]
) -> Experiment:
    """The experiment with what it left open in its motions filled in.

    A motion of no center, for which home leaves no room, gets one beside it, and `notes` a line
    that says so; where there is none beside it either, one of a given size stays at home. The
    posture is taken back at the rate alpha_0 [1/s].

    Raises:
        ExperimentError: a motion does not fit the task.
        MotionError: the arm follows no size of one with margin.
    """
    robot = kinematics.robot
    at_home = robot.home if robot.joint_space else kinematics.position(robot.home)
    source = f"experiment {experiment.name!r}"
    bounds = per_joint(experiment.springs, robot.joints, robot.elements, source)
    filled = []
    for index, given in enumerate(experiment.motion):
        name = f"experiment {experiment.name!r}: motion.{index}"
        motion = motions.resolve(given, robot, at_home, name)
        if robot.joint_space:
            filled.append(_sized_in_joints(motion, kinematics, name, bounds))
            continue
        try:
            fitting = sized(motion, kinematics, name, alpha_0, bounds)
            if given.center is None and given.size is not None and motion.center is not None:
                _try(motion, kinematics, name, alpha_0, bounds)
        except NoRoomError as error:
            if given.center is not None:
                raise
            beside = _beside(motion, kinematics, name, alpha_0, bounds)
            if beside is None and given.size is None:
                raise
            if beside is None:
                filled.append(motion)
                continue
            fitting = beside
            away = np.subtract(fitting.center or (), motion.center or ())
            notes.append(
                Note(
                    f"motion.{index}: its center is {length(float(np.linalg.norm(away)))} from the "
                    "tool at home, where there is no room for it",
                    f": {error.reason}",
                )
            )
        filled.append(fitting)
    return experiment.model_copy(update={"motion": tuple(filled)})


def sized(
    motion: Motion,
    kinematics: Kinematics,
    name: str,
    alpha_0: float = 10.0,
    bounds: Bounds | None = None,
) -> Motion:
    """A motion with its size filled in, twice as long as high.

    The size shrinks from a share of the reach until inverse kinematics follows the motion well away
    from singular poses and joint limits, nothing touches on the way, and the motors' limits suffice
    with the best springs. It is the same for the same robot and motion.

    Raises:
        NoRoomError: the arm follows no size of it with margin.
        MotionError: its center is out of reach.
    """
    if motion.size is not None or not motion.in_a_plane:
        return motion
    robot = kinematics.robot
    size = SHARE * reach(robot)
    middle = _middle(motion, kinematics, name)
    reason = ""
    for _ in range(TRIES):
        candidate = motion.model_copy(update={"size": (size, size / 2)})
        reason = _obstacle(candidate, kinematics, middle, name, alpha_0, bounds)
        if not reason:
            return candidate
        size *= SHRINK
    raise NoRoomError(
        f"{name}: no size is given, and even with size = [{size / SHRINK:.2g}, "
        f"{size / SHRINK / 2:.2g}] m: {reason}. Give center, size and plane, or another home pose"
        f"{robot.hint}",
        reason,
    )


def _sized_in_joints(motion: Motion, kinematics: Kinematics, name: str, bounds: Bounds) -> Motion:
    """A motion of the joints with its size filled in, twice as far in the first as in the last.

    Raises:
        NoRoomError: the arm makes no size of it.
    """
    if motion.size is not None or not motion.in_a_plane:
        return motion
    robot, size, reason = kinematics.robot, TURN, ""
    middle = np.array(motion.center)
    for _ in range(TRIES):
        candidate = motion.model_copy(update={"size": (size, size / 2)})
        moved = JointMotion(*motions.sample(candidate, FINE * POINTS, robot)[:3])
        reason = (
            beyond_range(moved.q, robot)
            or touches(moved.q, middle, robot)
            or too_heavy(moved, kinematics, motion.period, bounds)
        )
        if not reason:
            return candidate
        size *= SHRINK
    raise NoRoomError(
        f"{name}: no size is given, and even with size = [{size / SHRINK:.2g}, "
        f"{size / SHRINK / 2:.2g}] rad: {reason}. Give center, size and plane",
        reason,
    )


def _try(motion: Motion, kinematics: Kinematics, name: str, alpha_0: float, bounds: Bounds) -> None:
    """Raise a NoRoomError if the arm cannot make a motion at all, with margin or without."""
    robot = kinematics.robot
    points = SEEN * POINTS
    samples, rate = motions.sample(motion, points, robot), _rate(alpha_0, motion, points)
    try:
        followed = kinematics.follow(samples, robot.home, motion.period, name, rate)
    except MotionError as error:
        raise NoRoomError(str(error), str(error).removeprefix(f"{name}: ")) from error
    reason = beyond_range(followed.q, robot)
    reason = reason or too_heavy(followed, kinematics, motion.period, bounds, share=1.0)
    if reason:
        raise NoRoomError(f"{name}: {reason}", reason)


def _beside(
    motion: Motion, kinematics: Kinematics, name: str, alpha_0: float, bounds: Bounds
) -> Motion | None:
    """A motion about the nearest center tried beside home that leaves room for it; None if none.

    If it has no size, it gets one.
    """
    robot = kinematics.robot
    center = np.array(motion.center)
    ways = np.array(sorted(product((0, 1, -1), repeat=len(center)), key=np.count_nonzero)[1:])
    ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
    for away in np.concatenate([share * reach(robot) * ways for share in ASIDE]):
        candidate = motion.model_copy(update={"center": tuple((center + away).tolist())})
        try:
            middle = _middle(candidate, kinematics, name)
            values = np.linalg.svd(kinematics.jacobian(middle), compute_uv=False)
            width = np.ptp(robot.model.jnt_range[robot.joint_id], axis=1)
            inside = to_limit(middle, robot) > LIMITS * width
            free = not touching(robot.model, robot.positions(middle[None]))
            roomy = free and values[-1] > ROOMY * values[0]
            if not (roomy and (inside | ~robot.limited).all()):
                continue
            # Where the smallest finds no room, none of the larger ones does.
            smallest = SHARE * reach(robot) * SHRINK ** (TRIES - 1)
            size = candidate.size or (smallest, smallest / 2)
            small = candidate.model_copy(update={"size": size})
            if not _obstacle(small, kinematics, middle, name, alpha_0, bounds):
                return sized(candidate, kinematics, name, alpha_0, bounds)
        except MotionError:
            continue
    return None


def _middle(motion: Motion, kinematics: Kinematics, name: str) -> np.ndarray:
    """Joint angles (n,) with the tool at the motion's center; those at home if it is not given."""
    point = motion.model_copy(update={"size": (0.0, 0.0), "rotation_sin": (), "rotation_cos": ()})
    x = motions.sample(point, 1, kinematics.robot).x[0]
    q = kinematics.solve(x, kinematics.robot.home)
    away = float(np.linalg.norm(kinematics.position(q) - x))
    if away > REACHED:
        raise MotionError(
            f"{name}: center = {list(motion.center or ())}: out of the arm's reach: the tool comes "
            f"no nearer than {away * 1e3:.1f} mm; at home it is where center is if not given"
        )
    return q


def _rate(alpha_0: float, motion: Motion, points: int) -> float:
    """Rate [1/s] of the posture's return: a coarse cycle overshoots if it is within a step."""
    return min(alpha_0, 0.5 * points / motion.period)


def _obstacle(
    motion: Motion,
    kinematics: Kinematics,
    middle: np.ndarray,
    name: str,
    alpha_0: float,
    bounds: Bounds | None,
) -> str:
    """Why the arm cannot follow a motion with margin; empty if it can."""
    robot, home = kinematics.robot, kinematics.robot.home
    samples, q = motions.sample(motion, POINTS, robot), home
    for x in samples.x[::GLANCE]:
        q = kinematics.solve(x, q, iterations=30)
        reason = lacks_margin(q[None], middle, kinematics)
        if reason:
            return reason
    for points in (POINTS, FINE * POINTS):
        samples = motions.sample(motion, points, robot)
        rate = _rate(alpha_0, motion, points)
        try:
            followed = kinematics.follow(samples, home, motion.period, name, rate)
        except MotionError as error:
            return str(error).removeprefix(f"{name}: ")
        sudden = jerk(kinematics, followed)
        reason = (
            lacks_margin(followed.q, middle, kinematics)
            or (f"it comes near a singular pose: {sudden.said(robot.joints)}" if sudden else "")
            or touches(followed.q, middle, robot)
            or too_heavy(followed, kinematics, motion.period, bounds)
        )
        if reason or nearness(kinematics, followed.q) > 2 * NEAR_SINGULAR:
            return reason
    return ""
