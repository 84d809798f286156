"""Periodic motions of the tool, or of the joints, sampled over a cycle."""

from __future__ import annotations

from itertools import zip_longest
from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from ..errors import ExperimentError
from ..experiments.motion_section import Motion
from ..robots.robot import Robot
from ..text import listed, shown
from . import rotations, waypoints
from .minimum_jerk import minimum_jerk
from .stops import point_to_point

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

MOST_HARMONICS = 1000
"""Harmonics of 1/T that a motion may have."""


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


def sample(motion: Motion, steps: int, robot: Robot) -> Samples:
    """Sample a resolved motion at `steps` equal time steps of its cycle, in the task's order.

    Of a robot in joint space, the joints' angles in their order.
    """
    parts = _in_its_frame(motion, steps, robot)
    if robot.joint_space:
        return Samples(*parts)
    if motion.frame != "world":
        at, R = _frame(motion, robot)
        count = len(at)
        for part in parts:
            part[:, :count] = part[:, :count] @ R.T
        parts[0][:, :count] += at
    if motion.rotation_sin or motion.rotation_cos:
        rows = motion.rotation_sin, motion.rotation_cos
        turn = _fourier((0.0, 0.0, 0.0), *rows, motion.period, steps)
        for part, more in zip(parts, turn, strict=True):
            part[:, -3:] += more
    return of_rates(*parts, robot.rotates)


def resolve(motion: Motion, robot: Robot, at_home: np.ndarray, name: str = "motion") -> Motion:
    """A motion that fits the robot's task, with all that it left open filled in but its size.

    `at_home` is the tool's position at home (m,) [m], or the joint angles in joint space (n,)
    [rad]; messages call the motion `name`.

    Raises:
        ExperimentError: the plane, the frame, the rotation or the CSV does not fit the task.
    """
    axes = robot.moved
    _check(motion, robot, name)
    found: dict[str, object] = {}
    if motion.shape == "csv":
        _CURVES[_key(motion, robot)] = waypoints.read(*_key(motion, robot), name)
    elif motion.in_a_plane:
        if motion.center is None:
            center = at_home[: len(axes)]
            if not robot.joint_space:
                at, R = _frame(motion, robot)
                center = R.T @ (center - at)
            found["center"] = tuple(float(value) for value in center)
        if motion.plane is None:
            found["plane"] = (axes[0], axes[-1])
        if motion.shape == "polygon":
            found["corners"] = motion.corners or 4
            found["rounding"] = motion.rounding or 0.5
    resolved = motion.model_copy(update=found)
    if robot.rotates and not robot.joint_space:
        longest = float(np.linalg.norm(sample(resolved, 200, robot).x[:, -3:], axis=1).max())
        if longest >= np.pi:
            raise ExperimentError(
                f"{name}: it turns the tool by {longest:.3g} rad from its orientation at home; "
                "less than pi is valid, where the rotation vector is unique"
            )
    return resolved


def in_a_row(parts: list[Samples]) -> Samples:
    """Motions of one task that follow each other, as one."""
    x, dx, ddx = (np.concatenate([part[i] for part in parts]) for i in range(3))
    return Samples(x, dx, ddx, parts[0].rotates)


def of_rates(x: np.ndarray, dx: np.ndarray, ddx: np.ndarray, rotates: bool) -> Samples:
    """Samples of rates that are, of a rotation, those of its rotation vector."""
    if rotates:
        dx[:, -3:], ddx[:, -3:] = rotations.from_rates(x[:, -3:], dx[:, -3:], ddx[:, -3:])
    return Samples(x, dx, ddx, rotates)


Rows = tuple[tuple[float, ...], ...]
Parts = tuple[np.ndarray, np.ndarray, np.ndarray]

_CURVES: dict[tuple[str, tuple[str, ...], float], CubicSpline] = {}
"""What `resolve` read: a CSV that is edited while a run goes on does not change the run."""


def _key(motion: Motion, robot: Robot) -> tuple[str, tuple[str, ...], float]:
    return motion.file or "", robot.joints if robot.joint_space else robot.axes, motion.period


def _check(motion: Motion, robot: Robot, name: str) -> None:
    """Raise where a motion does not fit the task."""
    axes = robot.moved
    what = "the arm's joints" if robot.joint_space else "the task's coordinates"
    for axis in motion.plane or ():
        if axis not in axes:
            raise ExperimentError(
                f"{name}: plane = {shown(motion.plane)}: {axis} is not one of {what}: "
                f"{listed(axes)}"
            )
    if robot.joint_space and motion.frame != "world":
        raise ExperimentError(
            f"{name}: frame = {motion.frame!r}: task.space = 'joint', and joint angles have no "
            "frame: leave it out"
        )
    for key in ("rotation_sin", "rotation_cos"):
        if getattr(motion, key) and robot.joint_space:
            raise ExperimentError(
                f"{name}: {key} is given, and task.space = 'joint': the joints' motion turns the "
                "tool; leave it out"
            )
        if getattr(motion, key) and not robot.rotates:
            raise ExperimentError(
                f"{name}: {key} is given, and the task has no rotation; its coordinates are "
                f"{', '.join(axes)}: take {key} out, or add 'rotation' to task.coordinates"
            )
    if motion.shape == "points" and len(motion.points[0]) != len(axes):
        raise ExperimentError(
            f"{name}: points have {len(motion.points[0])} numbers each; one for each of {what} is "
            f"needed: {listed(axes)}"
        )
    nyquist = motion.steps(robot.model.opt.timestep) // 2
    for key in ("sin", "cos", "rotation_sin", "rotation_cos"):
        most = max(map(len, getattr(motion, key)), default=0)
        if most > min(nyquist, MOST_HARMONICS):
            raise ExperimentError(
                f"{name}: {key} has {most} harmonics of 1/T; valid are at most {MOST_HARMONICS}, "
                f"and the Nyquist limit, period / (2 timestep) = {nyquist}"
            )
    if robot.joint_space:
        return
    _, turn = _pose(motion, robot)
    inside = np.array([axis in axes for axis in "xyz"])
    leaves = float(np.abs(turn[np.ix_(~inside, inside)]).max(initial=0.0))
    if leaves > 1e-6:
        raise ExperimentError(
            f"{name}: frame = {motion.frame!r}: its axes {', '.join(axes)} are turned out of the "
            f"world's {', '.join(axes)}, by {np.degrees(np.arcsin(min(leaves, 1.0))):.3g} degrees, "
            "and the task has no others; give 'world', or a task with all of x, y and z"
        )


def _frame(motion: Motion, robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Origin and axes of a motion's frame, in the task's positions."""
    place, turn = _pose(motion, robot)
    axes = ["xyz".index(axis) for axis in robot.position_axes]
    return place[axes], turn[np.ix_(axes, axes)]


def _pose(motion: Motion, robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Origin (3,) [m] and axes (3, 3) of a motion's frame in the world, at home."""
    if motion.frame == "world":
        return np.zeros(3), np.eye(3)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.qpos
    mujoco.mj_kinematics(robot.model, data)
    if motion.frame == "tool":
        frame = data.site(robot.site)
    else:
        frame = data.body(robot.model.body_parentid[robot.model.jnt_bodyid[robot.joint_id[0]]])
    return frame.xpos.copy(), frame.xmat.reshape(3, 3).copy()


def _in_its_frame(motion: Motion, steps: int, robot: Robot) -> Parts:
    """x, dx/dt and d²x/dt² of a motion (N, m), without what rotation_sin and rotation_cos add."""
    width = robot.n if robot.joint_space else robot.m
    if motion.shape == "fourier":
        rows = motion.sin, motion.cos
        return _fourier(motion.offset or (), *rows, motion.period, steps)
    if motion.shape == "csv":
        key = _key(motion, robot)
        curve = _CURVES.get(key) or waypoints.read(*key, "motion")
        phase, T = np.arange(steps) / steps, motion.period
        return curve(phase), curve(phase, 1) / T, curve(phase, 2) / T**2
    if motion.shape == "points":
        x, dx, ddx = (np.zeros((steps, width)) for _ in range(3))
        for whole, part in zip((x, dx, ddx), point_to_point(motion, steps), strict=True):
            whole[:, : part.shape[1]] = part
        return x, dx, ddx
    parts = _polygon(motion, steps) if motion.shape == "polygon" else _curve(motion, steps)
    x, dx, ddx = (np.zeros((steps, width)) for _ in range(3))
    x[:, : len(robot.moved)] = motion.center
    # A task of one position has one coordinate for both: then the shape's first alone.
    for column, axis in enumerate(dict.fromkeys(motion.plane or ())):
        for whole, part in zip((x, dx, ddx), parts, strict=True):
            whole[:, robot.moved.index(axis)] += part[:, column]
    return x, dx, ddx


def _curve(motion: Motion, steps: int) -> Parts:
    """An ellipse, line or eight about its center, in its plane (N, 2)."""
    a, b = motion.size or (0.0, 0.0)
    sin, cos = {
        "ellipse": (((0.0,), (b,)), ((a,), (0.0,))),
        "line": (((a,), (b,)), ()),
        "eight": (((a, 0.0), (0.0, b)), ()),
    }[motion.shape]
    return _fourier((0.0, 0.0), sin, cos, motion.period, steps)


def _polygon(motion: Motion, steps: int) -> Parts:
    """A regular polygon with rounded corners about its center, in its plane (N, 2).

    Each side takes as long as the others. About each corner, for the share `rounding` of the time
    of a side, the velocity passes over from that of one side to that of the next, as σ of minimum
    jerk, so that acceleration and jerk are continuous too. A corner begins and ends on the sides
    themselves, because σ(r) + σ(1 - r) = 1.
    """
    corners, rounding = motion.corners or 4, motion.rounding or 0.5
    angle = 2 * np.pi * np.arange(corners) / corners
    corner = np.asarray(motion.size or (0.0, 0.0)) * np.stack([np.cos(angle), np.sin(angle)], 1)
    side = np.roll(corner, -1, axis=0) - corner
    u = np.arange(steps) / steps * corners  # Time in sides; corner k is passed at u = k.
    nearest = np.floor(u + 0.5)
    past = (u - nearest)[:, None]
    k = nearest.astype(int) % corners
    before, turn = side[k - 1], side[k] - side[k - 1]
    r = np.clip(past / rounding + 0.5, 0.0, 1.0)
    # The integral of σ is 5/2 r⁴ - 3 r⁵ + r⁶, and beyond the corner it grows with the time.
    gone = rounding * r**4 * (2.5 - 3 * r + r**2) + np.maximum(past - rounding / 2, 0.0)
    rate, (sigma, d_sigma, _) = corners / motion.period, minimum_jerk(r)
    return (
        corner[k] + past * before + gone * turn,
        rate * (before + sigma * turn),
        rate**2 * (d_sigma / rounding) * turn,
    )


def _fourier(
    offset: tuple[float, ...], sin_rows: Rows, cos_rows: Rows, period: float, steps: int
) -> Parts:
    """The sum offset + Σ_h sin_h sin(2π h t/T) + cos_h cos(2π h t/T), per coordinate."""
    m = len(offset)
    none = ((),) * m
    by_harmonic = [*zip_longest(*(sin_rows or none), *(cos_rows or none), fillvalue=0.0)]
    a, b = np.split(np.reshape(by_harmonic, (-1, 2 * m)).T.copy(), 2)
    h = np.arange(1, a.shape[1] + 1)
    phase = 2 * np.pi * np.outer(np.arange(steps) / steps, h)
    sin, cos = np.sin(phase), np.cos(phase)
    omega = 2 * np.pi * h / period
    return (
        np.asarray(offset) + sin @ a.T + cos @ b.T,
        cos @ (a * omega).T - sin @ (b * omega).T,
        -sin @ (a * omega**2).T - cos @ (b * omega**2).T,
    )
