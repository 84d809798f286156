"""What a run really came to: in plain MuJoCo, NumPy and SciPy, from q, tau and x_desired alone.

None of the figures that the program reports are read: the tool's path is MuJoCo's kinematics of the
recorded joint angles, the torque that a motion needs is MuJoCo's inverse dynamics without contacts
and joint limits, and the best springs are a bounded least squares of SciPy's.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.optimize import nnls

import resonance_mj as rmj

REACH = np.pi
"""Default bound of the equilibrium angle about the mean joint angle, |q_e - q_c| [rad]."""

NEAR_OPTIMUM, OF_TORQUE = 0.02, 1e-3
"""How far torque² may be from the optimum: of the optimum, or of torque² without springs."""

CLAIMED = 0.05
"""The same of the optimum, where the program says "at the optimum"."""

MOST_RMS, OF_PATH = 1.5e-3, 0.02
"""How far the tool may be from its path, RMS: in metres, and of the path's size."""

NEAR_SINGULAR = 0.05
"""Share of the Jacobian's largest singular value below which the smallest is nearly none."""


@dataclass(frozen=True)
class Judgement:
    """The last cycle of a run, as somebody else would measure it.

    Attributes:
        rms: distance of the tool from its path [m].
        size: largest extent of the path along an axis [m].
        torque_squared: mean of tau^T tau [N² m²].
        optimum: its least value with constant springs within the bounds.
        without: its value without springs.
        singular: whether the arm came near a singular pose.
        at_range: whether a joint was at or beyond the end of its range.
        at_motor: whether a motor was at its limit.
    """

    rms: float
    size: float
    torque_squared: float
    optimum: float
    without: float
    singular: bool
    at_range: bool
    at_motor: bool

    @property
    def good(self) -> bool:
        """Whether the arm follows its path with the least torque."""
        return self.tracks and self.optimal

    @property
    def tracks(self) -> bool:
        return self.rms <= MOST_RMS and self.follows

    @property
    def follows(self) -> bool:
        """Whether the tool tracks as far as the program's status says it."""
        return self.rms <= OF_PATH * self.size

    @property
    def optimal(self) -> bool:
        return self.within(NEAR_OPTIMUM)

    def within(self, share: float) -> bool:
        """Whether torque² is so near to the optimum."""
        far = abs(self.torque_squared - self.optimum)
        return far <= max(share * self.optimum, OF_TORQUE * self.without)

    @property
    def ratio(self) -> float:
        return self.torque_squared / self.optimum if self.optimum > 0 else np.inf


def judge(run: rmj.Run) -> Judgement:
    """Measure the last cycle of a run again.

    The optimum is that of the desired joint motion where the task determines it, which is found by
    Newton's method from the one made, and of the one made where the task leaves joints free.
    """
    data, robot = run.data, run.plan.robot
    last = (data["cycle_of_sample"] == data.sizes["cycle"]).values
    time, wanted = data["time"].values[last], data["x_desired"].values[last]
    tau, made = data["tau"].values[last], data["q"].values[last]
    lead_in = data["q"].values[np.flatnonzero(last)[0] - 1 :]
    dt = time[1] - time[0]
    low, high = robot.model.jnt_range[robot.joint_id].T
    weakest, strongest = robot.torque_limit.T
    arm = _Arm(robot)
    positions = [axis for axis in robot.axes if axis in "xyz"]
    rows = ["xyz".index(axis) for axis in positions]
    x = np.array([arm.tool(q)[0][rows] for q in made])
    miss = x - wanted[:, : len(rows)]
    if robot.m == robot.n and not robot.rotates:
        desired = np.array([arm.solved(q, x, rows) for q, x in zip(made, wanted, strict=True)])
        q, dq, ddq = _derivatives(np.concatenate([desired[-1:], desired, desired[:1]]), dt)
    else:
        q, dq, ddq = _derivatives(lead_in, dt)
    needed = np.array([arm.torque(*state) for state in zip(q, dq, ddq, strict=True)])
    return Judgement(
        rms=float(np.sqrt((miss**2).sum(axis=1).mean())),
        size=float(np.ptp(wanted[:, : len(rows)], axis=0).max()),
        torque_squared=float((tau**2).sum(axis=1).mean()),
        optimum=float(sum(_left_over(q[:, j], needed[:, j]) for j in range(robot.n))),
        without=float((needed**2).sum(axis=1).mean()),
        singular=any(arm.nearness(q) < NEAR_SINGULAR for q in made[::10]),
        at_range=bool((robot.limited & ((made <= low) | (made >= high))).any()),
        at_motor=bool(((tau <= weakest) | (tau >= strongest)).any()),
    )


class _Arm:
    """The arm's model without the springs of the run, contacts and joint limits."""

    def __init__(self, robot) -> None:
        self.model, self.robot = copy(robot.model), robot
        off = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
        self.model.opt.disableflags |= off
        self.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_INVDISCRETE
        self.model.jnt_stiffness[robot.joint_id] = 0.0
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = robot.qpos

    def tool(self, q):
        """Position (3,) and its Jacobian (3, n)."""
        self.data.qpos[self.robot.qpos_address] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        jacobian = np.zeros((3, self.model.nv))
        mujoco.mj_jacSite(self.model, self.data, jacobian, None, self.robot.site)
        return self.data.site_xpos[self.robot.site].copy(), jacobian[:, self.robot.dof_address]

    def nearness(self, q):
        """Smallest singular value of the task's Jacobian, as a share of its largest."""
        self.tool(q)
        jacobian = np.zeros((6, self.model.nv))
        mujoco.mj_jacSite(self.model, self.data, jacobian[:3], jacobian[3:], self.robot.site)
        rows = np.ix_(self.robot.coordinate, self.robot.dof_address)
        values = np.linalg.svd(jacobian[rows], compute_uv=False)
        return values[-1] / values[0]

    def solved(self, q, wanted, rows):
        """Joint angles near q that put the tool where it is wanted."""
        for _ in range(20):
            x, jacobian = self.tool(q)
            step = np.linalg.lstsq(jacobian[rows], wanted - x[rows], rcond=None)[0]
            q = q + step
            if np.abs(step).max() < 1e-13:
                break
        return q

    def torque(self, q, dq, ddq):
        """What motors and springs must exert together."""
        data = self.data
        data.qvel[:] = data.qacc[:] = 0.0
        data.qpos[self.robot.qpos_address] = q
        data.qvel[self.robot.dof_address] = dq
        data.qacc[self.robot.dof_address] = ddq
        mujoco.mj_inverse(self.model, data)
        return data.qfrc_inverse[self.robot.dof_address].copy()


def _derivatives(q, dt):
    """Angles, velocities and accelerations of all samples but the first and the last.

    As MuJoCo's time step has them: q advances by the velocity at the end of the step.
    """
    velocity = np.diff(q, axis=0) / dt
    return q[1:-1], velocity[:-1], np.diff(velocity, axis=0) / dt


def _left_over(q, torque) -> float:
    """Least mean square of torque + k (q - q_c) - b with k >= 0 and |b| <= REACH k.

    Such (k, b) are the sums of (1, REACH) and (1, -REACH) with weights of at least 0.
    """
    z = q - q.mean()
    columns = np.stack([REACH - z, -REACH - z], axis=1)
    return nnls(columns, torque)[1] ** 2 / len(q)
