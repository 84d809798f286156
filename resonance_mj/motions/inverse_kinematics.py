"""Joint angles that bring the tool to given positions: one, or one after another along a motion."""

import math
from typing import NamedTuple

import mujoco
import numpy as np

from ..robots.robot import Robot
from . import rotations
from .forward_kinematics import Chain

TOLERANCE = 1e-11
"""Position error at which the inverse kinematics has converged [m]."""

REACHED = 1e3 * TOLERANCE
"""Position error from which on a position is out of reach [m]."""

STRIDE = 8
"""Every so many positions of a motion are solved one by one, and those between all at once."""

TURN = 0.1
"""Most that a joint turns between what is guessed there and what is found [rad]."""


class Along(NamedTuple):
    """Joint angles along positions, as far as these were within reach."""

    q: np.ndarray
    """Joint angles (N, n) [rad]."""
    J: np.ndarray
    """Task Jacobians there (N, m, n) [m/rad]."""
    away: float
    """How far the tool stays from the last position [m]."""
    ahead: np.ndarray
    """A guess at the angles that would come next (n,) [rad]."""

    @property
    def reached(self) -> bool:
        """Whether the tool comes to all of the positions."""
        return self.away <= REACHED


class InverseKinematics:
    """Joint angles of a robot for positions of its tool.

    Args:
        robot: that is looked at.
        data: of its model, at its home pose; written.
        chain: its joints.
    """

    def __init__(self, robot: Robot, data: mujoco.MjData, chain: Chain) -> None:
        self._robot, self._followers, self._chain = robot, robot.followers, chain
        self._model, self._data = robot.model, data
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

    def solved(
        self, x: np.ndarray, q: np.ndarray, iterations: int = 200
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Joint angles near `q` whose tool position is nearest to `x`, by damped Newton steps.

        The damping grows while a step does not come closer, so that the branch of `q` is kept.

        Args:
            x: position (m,) [m, rad].
            q: joint angles to start from (n,) [rad].
            iterations: most steps; without convergence the nearest angles found are returned.

        Returns:
            The angles (n,), the error that is left (m,) and the Jacobian (m, n) there.
        """
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

    def along(self, x: np.ndarray, guess: np.ndarray, to_home: float) -> Along:
        """Joint angles along positions (N, m) of the task, on the branch of a guess.

        Args:
            x: positions [m, rad].
            guess: joint angles near the first (n,) [rad].
            to_home: share of the way to the home pose that joints which the task leaves free go
                between two positions.
        """
        determined = self._robot.m == self._robot.n
        found = self._at_once(x, guess) if determined and len(x) >= 32 * STRIDE else None
        return found or self._one_by_one(x, guess, to_home)

    def _one_by_one(self, x: np.ndarray, guess: np.ndarray, to_home: float) -> Along:
        """Each from a guess that those before it make."""
        q, J = np.empty((len(x), self._robot.n)), np.empty((len(x), self._robot.m, self._robot.n))
        step, free, away = np.diff(x, axis=0, append=x[:1]), self._robot.m < self._robot.n, 0.0
        for i in range(len(x)):
            q[i], error, J[i] = self.solved(x[i], guess)
            away = math.sqrt(error @ error)
            if away > REACHED:
                return Along(q[: i + 1], J[: i + 1], away, guess)
            if free:
                home = to_home * (self._robot.home - q[i])
                guess = q[i] + home + self._inverse(J[i], step[i] - J[i] @ home, 1e-12)
            else:
                guess = 3 * q[i] - 3 * q[i - 1] + q[i - 2] if i > 1 else q[i]
        return Along(q, J, away, guess)

    def _at_once(self, x: np.ndarray, guess: np.ndarray) -> Along | None:
        """Newton's method for all from what lies between some of them.

        None where it does not come to each of the positions, or comes there from afar, which may be
        on another branch.
        """
        at = np.append(np.arange(0, len(x) - 1, STRIDE), len(x) - 1)
        some = self._one_by_one(x[at], guess, 0.0)
        if not some.reached:
            return None
        first = np.stack([np.interp(np.arange(len(x)), at, angles) for angles in some.q.T], axis=1)
        q = first
        for _ in range(8):
            poses = self._chain.poses(q)
            J, error = self._chain.jacobians(poses), self._chain.errors(poses, x)
            away = float(np.linalg.norm(error, axis=1).max())
            if away < TOLERANCE:
                return Along(q, J, away, 3 * q[-1] - 3 * q[-2] + q[-3])
            try:
                q = q + np.linalg.solve(J, error[..., None])[..., 0]
            except np.linalg.LinAlgError:
                return None
            if not np.abs(q - first).max() < TURN:
                return None
        return None

    def _place(self, q: np.ndarray) -> None:
        self._qpos[self._of_q] = q
        self._followers.place(self._qpos)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)

    def _J(self) -> np.ndarray:  # noqa: N802
        mujoco.mj_jacSite(self._model, self._data, self._linear, self._angular, self._robot.site)
        return self._followers.borne(self._full)[self._of_task]

    def _error(self, q: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far it is from the tool at `q` to `x` (m,), and the Jacobian there."""
        self._place(q)
        if not self._robot.rotates:
            return x - self._at[self._positions], self._J()
        error, desired = np.empty_like(x), np.empty((3, 3))
        error[:-3] = x[:-3] - self._at[self._positions]
        rotations.rotation(x[-3:], self._robot.orientation, desired)
        rotations.rotation_vector(desired, self._orientation, error[-3:])
        return error, self._J()

    def _inverse(self, J: np.ndarray, error: np.ndarray, damping: float) -> np.ndarray:
        """J⁺ times a vector, Jᵀ (J Jᵀ + damping I)⁻¹ e, by MuJoCo's own: m is small."""
        step, square, solution = np.empty(self._robot.n), self._square, self._solution
        mujoco.mju_mulMatMatT(square, J, J)
        self._diagonal += damping
        mujoco.mju_cholFactor(square, 1e-15)
        mujoco.mju_cholSolve(solution, square, error)
        mujoco.mju_mulMatTVec(step, J, solution)
        return step


def _span(numbers: np.ndarray) -> slice | np.ndarray:
    """Numbers in a row as a slice, which is faster to index with; others as they are."""
    first, last = int(numbers[0]), int(numbers[-1]) + 1
    return slice(first, last) if np.array_equal(numbers, np.arange(first, last)) else numbers
