"""The tool's pose and Jacobian at many joint angles at once, as a product of exponentials.

Each joint turns or shifts all that hangs on it about the axis that it has at home, so that the
tool's pose is exp(S_1 θ_1) ... exp(S_c θ_c) times the one at home (R. W. Brockett, Robotic
manipulators and the product of exponentials formula, 1984). MuJoCo gives the axes S, once.
"""

from typing import NamedTuple

import mujoco
import numpy as np

from ..robots import chain
from ..robots.robot import Robot
from . import rotations


class Poses(NamedTuple):
    """An arm at N joint angles; its chain has c joints, those that follow others included."""

    position: np.ndarray
    """Of the tool (N, 3) [m]."""
    orientation: np.ndarray
    """Of the tool (N, 3, 3)."""
    axis: np.ndarray
    """Of each joint of the chain, in the world (N, c, 3)."""
    anchor: np.ndarray
    """A point on it (N, c, 3) [m]."""


def path_to_tool(robot: Robot) -> list[tuple[int, int, float]]:
    """The joints that move a robot's tool, from its base on.

    Returns:
        Of each its id, the number of the arm's joint that moves it, and how fast.
    """
    moved = {
        joint: (j, speed)
        for j, leader in enumerate(robot.joint_id)
        for joint, speed in robot.followers.moved_by(leader)
    }
    path = chain.joints_to(robot.model, int(robot.model.site_bodyid[robot.site]))
    return [(joint, *moved[joint]) for joint in path if joint in moved]


class Chain:
    """The joints between the world and a robot's tool.

    Args:
        robot: whose joints move; all others stay as they are at its home pose.
        data: of its model, written; one of its own if not given.
    """

    def __init__(self, robot: Robot, data: mujoco.MjData | None = None) -> None:
        model = robot.model
        data = data or mujoco.MjData(model)
        data.qpos[:] = robot.qpos
        mujoco.mj_kinematics(model, data)
        found = path_to_tool(robot)
        self._home, path = robot.qpos[robot.qpos_address], [joint for joint, _, _ in found]
        # θ = q @ ratio, and columns of the arm's Jacobian are those of the chain's @ ratio.T.
        self._ratio, self._leader = np.zeros((robot.n, len(path))), [j for _, j, _ in found]
        for at, (_, j, speed) in enumerate(found):
            self._ratio[j, at] = speed
        self._axis, self._anchor = data.xaxis[path], data.xanchor[path]
        slide = int(mujoco.mjtJoint.mjJNT_SLIDE)
        at = model.jnt_qposadr[path]
        self._travel = robot.qpos[at] - model.qpos0[at]
        self._slides = model.jnt_type[path] == slide
        self._robot = robot
        self._positions = robot.coordinate[: len(robot.position_axes)]
        self._tool = data.site_xpos[robot.site].copy()
        self._orientation = data.site_xmat[robot.site].reshape(3, 3).copy()

    def poses(self, q: np.ndarray) -> Poses:
        """The arm at joint angles (N, n) [rad]."""
        theta = (q - self._home) @ self._ratio
        shape = (len(q), theta.shape[1], 3)
        axes, anchors = np.empty(shape), np.empty(shape)
        R, p = np.broadcast_to(np.eye(3), (len(q), 3, 3)), np.zeros((len(q), 3))
        for i, (axis, anchor) in enumerate(zip(self._axis, self._anchor, strict=True)):
            axes[:, i] = R @ axis
            anchors[:, i] = R @ anchor + p
            if self._slides[i]:
                p = p + theta[:, i, None] * axes[:, i]
                continue
            across, angle = np.cross(np.eye(3), axis), theta[:, i, None, None]  # across v: axis × v
            turn = np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * (across @ across)
            R = R @ turn
            p = anchors[:, i] - R @ anchor
        return Poses(R @ self._tool + p, R @ self._orientation, axes, anchors)

    def positions(self, poses: Poses) -> np.ndarray:
        """Positions of the task (N, m) [m, rad].

        Rotation is a rotation vector from the orientation at home, in the world frame.
        """
        x = poses.position[:, self._positions]
        if not self._robot.rotates:
            return x
        return np.hstack([x, rotations.between(poses.orientation, self._orientation)])

    def errors(self, poses: Poses, x: np.ndarray) -> np.ndarray:
        """How far it is from the tool to positions of the task (N, m) [m, rad]."""
        places = len(self._positions)
        error = x[:, :places] - poses.position[:, self._positions]
        if not self._robot.rotates:
            return np.asarray(error)
        desired = rotations.turned(x[:, places:], self._orientation)
        return np.hstack([error, rotations.between(desired, poses.orientation)])

    def jacobians(self, poses: Poses) -> np.ndarray:
        """Task Jacobians (N, m, n) [m/rad]."""
        turns = ~self._slides[:, None]
        away = poses.position[:, None] - poses.anchor
        linear = np.where(turns, np.cross(poses.axis, away), poses.axis)
        return self._of_task(linear, turns * poses.axis)

    def drifts(self, poses: Poses, dq: np.ndarray) -> np.ndarray:
        """The tool's acceleration that comes of velocity alone, (dJ/dt) q̇ (N, m).

        Args:
            poses: at N joint angles.
            dq: joint velocities there (N, n) [rad/s].
        """
        turns = ~self._slides[:, None]
        rate = (dq @ self._ratio)[..., None]
        turning = turns * poses.axis
        # The velocity field ω × r + v of the bodies: what the joints before each add up to.
        shifting = np.where(turns, np.cross(poses.anchor, poses.axis), poses.axis)
        omega, v = np.cumsum(turning * rate, axis=1), np.cumsum(shifting * rate, axis=1)
        velocity = np.cross(omega[:, -1], poses.position) + v[:, -1]
        before, v_before = omega - turning * rate, v - shifting * rate
        axis_rate = np.cross(before, poses.axis)
        anchor_rate = np.cross(before, poses.anchor) + v_before
        linear = np.cross(axis_rate, poses.position[:, None] - poses.anchor)
        linear += np.cross(poses.axis, velocity[:, None] - anchor_rate)
        columns = self._of_task(np.where(turns, linear, axis_rate), turns * axis_rate)
        return np.asarray((columns @ dq[..., None])[..., 0])

    def misjudged(
        self, q: np.ndarray, tool_offset: np.ndarray, link_error: np.ndarray
    ) -> np.ndarray:
        """From the tool to where a controller of other dimensions takes it to be (N, 3) [m].

        Args:
            q: joint angles (N, n) [rad].
            tool_offset: as of `reality.tool_offset` (3,) [m].
            link_error: as of `reality.link_error` (n,).
        """
        poses = self.poses(q)
        ends = np.concatenate([poses.anchor[:, 1:], poses.position[:, None]], axis=1)
        travel = self._slides * ((q - self._home) @ self._ratio + self._travel)
        begins = poses.anchor + travel[..., None] * poses.axis
        longer = link_error[self._leader, None] * (ends - begins)
        return np.asarray(longer.sum(axis=1) + poses.orientation @ tool_offset)

    def _of_task(self, linear: np.ndarray, angular: np.ndarray) -> np.ndarray:
        """Columns (N, c, 3) of the chain's joints as the arm's for the task (N, m, n)."""
        both = np.concatenate([linear, angular], axis=2)
        return np.asarray((self._ratio @ both).swapaxes(1, 2)[:, self._robot.coordinate])
