"""Joint motion behind a task-space motion: for the evaluation, never for the controller."""

import copy
from collections.abc import Callable
from typing import NamedTuple, Self, TypeVar, cast

import mujoco
import numpy as np

from ..errors import MotionError
from ..experiments.reality_section import Reality
from ..robots.robot import Robot
from .forward_kinematics import Chain
from .inverse_kinematics import REACHED, InverseKinematics
from .motion import Samples

T = TypeVar("T")

DRIFTING = 5
"""Most cycles that joints which the task leaves free drift before their motion is periodic."""

SINGULAR = 1e-3
"""Ratio of the Jacobian's smallest to largest singular value below which a pose is singular."""

_bits = mujoco.mjtDisableBit
_BEARS = int(_bits.mjDSBL_CONTACT | _bits.mjDSBL_LIMIT | _bits.mjDSBL_EQUALITY)
_SPRINGS = int(_bits.mjDSBL_SPRING)


class JointMotion(NamedTuple):
    """A joint motion over one cycle."""

    q: np.ndarray
    """Joint angles q_d (N, n) [rad]."""
    dq: np.ndarray
    """Joint velocities (N, n) [rad/s]."""
    ddq: np.ndarray
    """Joint accelerations (N, n) [rad/s^2]."""


class Kinematics:
    """Position, Jacobian and torque of a robot at chosen states, without its joint springs."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self._followers = robot, robot.followers
        self._model, self._data = robot.model, mujoco.MjData(robot.model)
        self._chain = Chain(robot, self._data)
        self._inverse = InverseKinematics(robot, self._data, self._chain)
        self._known: dict[object, object] = {}

    def of(self, robot: Robot) -> Self:
        """The same for a copy of the robot, with all that was found."""
        other = copy.copy(self)
        other.robot = robot
        return other

    def once(self, key: object, work: Callable[[], T]) -> T:
        """What some work finds that depends on the robot and a key alone."""
        if key not in self._known:
            self._known[key] = work()
        return cast("T", self._known[key])

    def position(self, q: np.ndarray) -> np.ndarray:
        """Tool position x = f(q) (m,) [m, rad] at joint angles q (n,) [rad]."""
        found = self.once(
            ("position", q.tobytes()), lambda: self._chain.positions(self._chain.poses(q[None]))[0]
        )
        return found.copy()

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Task Jacobian J(q) (m, n) [m/rad] at joint angles q (n,) [rad]."""
        return np.asarray(self.jacobians(q[None])[0])

    def jacobians(self, q: np.ndarray) -> np.ndarray:
        """Task Jacobians (N, m, n) [m/rad] at joint angles (N, n) [rad]."""
        return self._chain.jacobians(self._chain.poses(q))

    def misjudged(self, q: np.ndarray, reality: Reality) -> np.ndarray:
        """From the tool to where the controller takes it to be (N, 3) [m], at angles (N, n)."""
        error = np.broadcast_to(np.asarray(reality.link_error, float), self.robot.n)
        offset = np.array(reality.tool_offset)
        return self._chain.misjudged(q, offset, error)

    def tool_path(self, motion: JointMotion) -> Samples:
        """Position, velocity and acceleration of the tool (N, m) along a joint motion."""
        dq, ddq = motion.dq[..., None], motion.ddq[..., None]
        poses = self._chain.poses(motion.q)
        J, drift = self._chain.jacobians(poses), self._chain.drifts(poses, motion.dq)
        path = self._chain.positions(poses), (J @ dq)[..., 0], (J @ ddq)[..., 0] + drift
        return Samples(*path, self.robot.rotates)

    def inertia(self, q: np.ndarray) -> np.ndarray:
        """Inertia matrix of the joints (n, n) [kg m^2] at joint angles q (n,) [rad]."""
        return self.once(("inertia", q.tobytes()), lambda: self._inertia(q)).copy()

    def _inertia(self, q: np.ndarray) -> np.ndarray:
        data, dofs = self._data, self.robot.dof_address
        data.qpos[self.robot.qpos_address] = q
        self._followers.place(data.qpos)
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_comPos(self._model, data)
        mujoco.mj_crb(self._model, data)
        full = np.zeros((self._model.nv, self._model.nv))
        mujoco.mj_fullM(self._model, data, full)
        full = self._followers.borne(self._followers.borne(full).T)
        return np.asarray(full[np.ix_(dofs, dofs)])

    def solve(self, x: np.ndarray, q: np.ndarray, iterations: int = 200) -> np.ndarray:
        """Joint angles near `q` whose tool position is nearest to `x` (n,) [rad].

        Args:
            x: position (m,) [m, rad].
            q: joint angles to start from (n,) [rad].
            iterations: most steps; without convergence the nearest angles found are returned.
        """
        return self._inverse.solved(x, q, iterations)[0]

    def follow(
        self, samples: Samples, start: np.ndarray, period: float, name: str, alpha_0: float = 10.0
    ) -> JointMotion:
        """Joint motion of a task-space motion, on the branch of `start`.

        Where the task leaves joints free, they drift towards the home pose as the law has them,
        until a cycle ends where it began.

        Args:
            samples: the motion.
            start: joint angles near which the branch is looked for (n,) [rad].
            period: cycle time [s].
            name: how messages call the motion.
            alpha_0: rate at which the posture is taken back [1/s].

        Raises:
            MotionError: the motion leaves the arm's reach or passes through a singular pose.
        """
        m, n = self.robot.m, self.robot.n
        for _ in range(1 if m == n else DRIFTING):
            q, J, start = self._cycle(samples, start, period, name, alpha_0)
            away = np.abs(start - q[0]).max()
            if away < 1e-4:
                break
        if away > (1e-6 if m == n else 0.1):
            raise MotionError(
                f"{name}: the joints do not return to where they began: after one cycle they are "
                f"{away:.3f} rad away; the motion winds around the base or leaves its branch"
            )
        if m < n:  # what is left of the drift, spread over the cycle
            q -= np.linspace(0.0, 1.0, len(q), endpoint=False)[:, None] * (start - q[0])
        return self._with_rates(samples, q, J, lambda signal: _periodic_rate(signal, period))

    def passage(
        self, samples: Samples, start: np.ndarray, length: float, name: str, alpha_0: float = 10.0
    ) -> JointMotion:
        """Joint motion, as `follow`'s, that ends elsewhere than it begins, `length` [s] later."""
        q, J, _ = self._cycle(samples, start, length, name, alpha_0)
        step = length / len(q)
        return self._with_rates(samples, q, J, lambda s: np.gradient(s, step, axis=0, edge_order=2))

    def _with_rates(
        self, samples: Samples, q: np.ndarray, J: np.ndarray, rate: Callable[..., np.ndarray]
    ) -> JointMotion:
        """Joint angles with their rates: those that a task of n coordinates sets, else `rate`'s."""
        if self.robot.m < self.robot.n:
            dq = rate(q)
            return JointMotion(q, dq, rate(dq))
        dq = np.linalg.solve(J, samples.dx[..., None])[..., 0]
        drift = self._chain.drifts(self._chain.poses(q), dq)
        ddq = np.linalg.solve(J, (samples.ddx - drift)[..., None])[..., 0]
        return JointMotion(q, dq, ddq)

    def _cycle(
        self, samples: Samples, start: np.ndarray, period: float, name: str, alpha_0: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Joint angles (N, n) and Jacobians (N, m, n) along one cycle, and the angles after it."""
        steps = len(samples.x)

        def where(i: int) -> str:
            position = zip(self.robot.position_axes, samples.x[i], strict=False)
            at = ", ".join(f"{axis} = {value:.3f}" for axis, value in position)
            return f"{i / steps * period:.3f} s into the cycle, at ({at}) m"

        guess = self._unfolded(samples.x[0], start)
        along = self._inverse.along(samples.x, guess, alpha_0 * period / steps)
        q, J = along.q, along.J
        if not along.reached:
            raise MotionError(
                f"{name}: out of the arm's reach {where(len(q) - 1)}: the tool comes no nearer "
                f"than {along.away * 1e3:.1f} mm; move or shrink the motion"
            )
        # The singular values' squares: three times faster than they themselves.
        squares = np.maximum(np.linalg.eigvalsh(J @ J.swapaxes(1, 2)), 0.0)
        i = int(np.argmin(squares[:, 0] / squares[:, -1]))
        least, largest = np.sqrt(squares[i, [0, -1]])
        if least < SINGULAR * largest:
            raise MotionError(
                f"{name}: passes through a singular pose {where(i)}, with joint angles "
                f"{np.array2string(q[i], precision=3)} rad: the smallest singular value of J is "
                f"{least:.1e} m/rad, at least {SINGULAR * largest:.1e} is needed; "
                "move the motion away from there or choose another home pose"
            )
        return q, J, self.solve(samples.x[0], along.ahead)

    def _unfolded(self, x: np.ndarray, start: np.ndarray) -> np.ndarray:
        """Joint angles that reach `x`, from `start` or from beside it where it is singular.

        From an exactly stretched arm no small step brings the tool nearer to its base.
        """
        bent = 0.3 * (-1.0) ** np.arange(len(start))
        for guess in (start, start + bent, start - bent):
            q, error, _ = self._inverse.solved(x, guess)
            if np.linalg.norm(error) < REACHED:
                return q
        return self.solve(x, start)

    def torque(self, motion: JointMotion) -> np.ndarray:
        """Torque τ_d(0, 0, t) (N, n) [N m] without springs, contacts and joint stops, by (2)."""
        robot, model, data = self.robot, self._model, self._data
        flags = model.opt.disableflags
        model.opt.disableflags |= _BEARS | _SPRINGS
        try:
            torque = np.empty_like(motion.q)
            for i in range(len(torque)):
                data.qpos[robot.qpos_address] = motion.q[i]
                data.qvel[robot.dof_address] = motion.dq[i]
                data.qacc[:] = 0.0
                data.qacc[robot.dof_address] = motion.ddq[i]
                self._followers.place(data.qpos)
                self._followers.move(data.qvel)
                self._followers.move(data.qacc)
                mujoco.mj_inverse(model, data)
                torque[i] = self._followers.borne(data.qfrc_inverse)[robot.dof_address]
        finally:
            model.opt.disableflags = flags
        return torque


def _periodic_rate(values: np.ndarray, period: float) -> np.ndarray:
    """Time derivative of a signal over a cycle (N, n), by central differences of fourth order."""
    before, last, following, second = (np.roll(values, k, axis=0) for k in (2, 1, -1, -2))
    return (8 * (following - last) - (second - before)) / (12 * (period / len(values)))
