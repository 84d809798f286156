"""Joint motion behind a task-space motion: for the evaluation, never for the controller."""

import math
from collections.abc import Callable
from typing import NamedTuple

import mujoco
import numpy as np

from ..errors import MotionError
from ..robots.robot import Robot
from . import rotations
from .motion import Samples

TOLERANCE = 1e-11
"""Position error at which the inverse kinematics has converged [m]."""

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
        self._data.qpos[:] = robot.qpos
        # A motion asks for these thousands of times: looked up, and room for them made, once.
        self._qpos, self._of_q = self._data.qpos, _span(robot.qpos_address)
        self._at = self._data.site_xpos[robot.site]
        self._orientation = self._data.site_xmat[robot.site].reshape(3, 3)
        self._positions = _span(robot.coordinate[: len(robot.position_axes)])
        self._full = np.zeros((6, self._model.nv))
        self._linear, self._angular = self._full[:3], self._full[3:] if robot.rotates else None
        self._square, self._solution = np.empty((robot.m, robot.m)), np.empty(robot.m)
        self._diagonal = self._square.ravel()[:: robot.m + 1]
        self._of_task = np.ix_(robot.coordinate, robot.dof_address)

    def position(self, q: np.ndarray) -> np.ndarray:
        """Tool position x = f(q) (m,) [m, rad] at joint angles q (n,) [rad].

        Rotation is a rotation vector from the orientation at home, in the world frame.
        """
        self._place(q)
        robot, x = self.robot, np.empty(self.robot.m)
        x[: len(robot.position_axes)] = self._at[self._positions]
        if robot.rotates:
            rotations.rotation_vector(self._orientation, robot.orientation, x[-3:])
        return x

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Task Jacobian J(q) (m, n) [m/rad] at joint angles q (n,) [rad]."""
        self._place(q)
        return self._J()

    def inertia(self, q: np.ndarray) -> np.ndarray:
        """Inertia matrix of the joints (n, n) [kg m^2] at joint angles q (n,) [rad]."""
        data, dofs = self._data, self.robot.dof_address
        self._place(q)
        mujoco.mj_crb(self._model, data)
        full = np.zeros((self._model.nv, self._model.nv))
        mujoco.mj_fullM(self._model, data, full)
        full = self._followers.borne(self._followers.borne(full).T)
        return full[np.ix_(dofs, dofs)]

    def solve(self, x: np.ndarray, q: np.ndarray, iterations: int = 200) -> np.ndarray:
        """Joint angles near `q` whose tool position is nearest to `x`, by damped Newton steps.

        The damping grows while a step does not come closer, so that the branch of `q` is kept.

        Args:
            x: position (m,) [m, rad].
            q: joint angles to start from (n,) [rad].
            iterations: most steps; without convergence the nearest angles found are returned.
        """
        return self._solved(x, q, iterations)[0]

    def _solved(
        self, x: np.ndarray, q: np.ndarray, iterations: int = 200
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Joint angles of `solve`, the error that is left (m,) and the Jacobian (m, n) there."""
        error, J = self._error(q, x)
        away, damping = math.sqrt(error @ error), 1e-12
        for _ in range(iterations):
            if away < TOLERANCE:
                break
            step = self._inverse(J, error, damping)
            longest = max(map(abs, step.tolist()))
            limited = q + (step if longest <= 0.2 else step * (0.2 / longest))
            new_error, new_J = self._error(limited, x)
            new_away = math.sqrt(new_error @ new_error)
            if new_away < away:
                q, error, J, away = limited, new_error, new_J, new_away
                damping = max(damping / 10, 1e-12)
            else:
                damping = max(10 * damping, 1e-7)
                if damping > 1e3:
                    break
        return q, error, J

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
        drift = np.array([self.jacobian_rate(a, v) @ v for a, v in zip(q, dq, strict=True)])
        ddq = np.linalg.solve(J, (samples.ddx - drift)[..., None])[..., 0]
        return JointMotion(q, dq, ddq)

    def _cycle(
        self, samples: Samples, start: np.ndarray, period: float, name: str, alpha_0: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Joint angles (N, n) and Jacobians (N, m, n) along one cycle, and the angles after it."""
        steps, (m, n) = len(samples.x), (self.robot.m, self.robot.n)
        q, J = np.empty((steps, n)), np.empty((steps, m, n))

        def where(i: int) -> str:
            position = zip(self.robot.position_axes, samples.x[i], strict=False)
            at = ", ".join(f"{axis} = {value:.3f}" for axis, value in position)
            return f"{i / steps * period:.3f} s into the cycle, at ({at}) m"

        guess = self._unfolded(samples.x[0], start)
        ahead = np.diff(samples.x, axis=0, append=samples.x[:1])
        to_home = alpha_0 * period / steps
        for i in range(steps):
            q[i], error, J[i] = self._solved(samples.x[i], guess)
            away = math.sqrt(error @ error)
            if away > 1e3 * TOLERANCE:
                raise MotionError(
                    f"{name}: out of the arm's reach {where(i)}: the tool comes no nearer than "
                    f"{away * 1e3:.1f} mm; move or shrink the motion"
                )
            if m < n:
                home = to_home * (self.robot.home - q[i])
                guess = q[i] + home + self._inverse(J[i], ahead[i] - J[i] @ home, 1e-12)
            else:
                guess = 3 * q[i] - 3 * q[i - 1] + q[i - 2] if i > 1 else q[i]
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
        return q, J, self._solved(samples.x[0], guess)[0]

    def _unfolded(self, x: np.ndarray, start: np.ndarray) -> np.ndarray:
        """Joint angles that reach `x`, from `start` or from beside it where it is singular.

        From an exactly stretched arm no small step brings the tool nearer to its base.
        """
        bent = 0.3 * (-1.0) ** np.arange(len(start))
        for guess in (start, start + bent, start - bent):
            q, error, _ = self._solved(x, guess)
            if np.linalg.norm(error) < 1e3 * TOLERANCE:
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

    def _place(self, q: np.ndarray) -> None:
        self._qpos[self._of_q] = q
        self._followers.place(self._qpos)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)

    def _J(self) -> np.ndarray:  # noqa: N802
        mujoco.mj_jacSite(self._model, self._data, self._linear, self._angular, self.robot.site)
        return self._followers.borne(self._full)[self._of_task]

    def jacobian_rate(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """Time derivative of J (m, n) at joint angles and velocities (n,), (n,)."""
        model, data = self._model, self._data
        self._place(q)
        data.qvel[self.robot.dof_address] = dq
        self._followers.move(data.qvel)
        mujoco.mj_comVel(model, data)
        at = self._at, model.site_bodyid[self.robot.site]
        mujoco.mj_jacDot(model, data, self._linear, self._angular, *at)
        return self._followers.borne(self._full)[self._of_task]

    def _error(self, q: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far it is from the tool at `q` to `x` (m,), and the Jacobian there."""
        self._place(q)
        if not self.robot.rotates:
            return x - self._at[self._positions], self._J()
        error, desired = np.empty_like(x), np.empty((3, 3))
        error[:-3] = x[:-3] - self._at[self._positions]
        rotations.rotation(x[-3:], self.robot.orientation, desired)
        rotations.rotation_vector(desired, self._orientation, error[-3:])
        return error, self._J()

    def _inverse(self, J: np.ndarray, error: np.ndarray, damping: float) -> np.ndarray:
        """J⁺ times a vector, Jᵀ (J Jᵀ + damping I)⁻¹ e, by MuJoCo's own: m is small."""
        step, square, solution = np.empty(self.robot.n), self._square, self._solution
        mujoco.mju_mulMatMatT(square, J, J)
        self._diagonal += damping
        mujoco.mju_cholFactor(square, 1e-15)
        mujoco.mju_cholSolve(solution, square, error)
        mujoco.mju_mulMatTVec(step, J, solution)
        return step


def _periodic_rate(values: np.ndarray, period: float) -> np.ndarray:
    """Time derivative of a signal over a cycle (N, n), by central differences of fourth order."""
    before, last, following, second = (np.roll(values, k, axis=0) for k in (2, 1, -1, -2))
    return (8 * (following - last) - (second - before)) / (12 * (period / len(values)))


def _span(numbers: np.ndarray) -> slice | np.ndarray:
    """Numbers in a row as a slice, which is faster to index with; others as they are."""
    first, last = int(numbers[0]), int(numbers[-1]) + 1
    return slice(first, last) if np.array_equal(numbers, np.arange(first, last)) else numbers
