"""The best constant springs for a motion: (2), (3), in the coordinates (k, q̄_e).

There the cost J is a convex quadratic, separate for each joint, and the springs' bounds are a
convex polygon, so that the optimum is unique: linear least squares without bounds, and with bounds
the feasible point nearest to it in the metric of J.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..experiments.experiment import Experiment
from ..experiments.sections import Springs
from ..motions import default_motion
from ..motions import motion as motions
from ..motions.kinematics import JointMotion, Kinematics
from ..robots.robot import Robot, build
from . import spring as springs


@dataclass(frozen=True)
class Optimum:
    """The constant springs that minimise (3) for one motion, and what they leave to the motors.

    Attributes:
        stiffness: K_opt (n,) [N m/rad].
        offset: q̄_e,opt about `center` (n,) [N m].
        equilibrium: q_e,opt (n,) [rad]; inf or -inf where a spring of no stiffness must push.
        center: q_c (n,) [rad].
        cost: J_min, the integral of τᵀτ over a cycle [N² m² s].
        cost_without_springs: the same integral for K = 0 [N² m² s].
        period: cycle time [s].
        q: the joint motion (N, n) [rad].
        torque: τ_dopt, the motors' torque with these springs (N, n) [N m].
        torque_without_springs: τ_d(0, 0, t) (N, n) [N m].
    """

    stiffness: np.ndarray
    offset: np.ndarray
    equilibrium: np.ndarray
    center: np.ndarray
    cost: float
    cost_without_springs: float
    period: float
    q: np.ndarray
    torque: np.ndarray
    torque_without_springs: np.ndarray

    @property
    def torque_squared(self) -> float:
        """Mean of τᵀτ over a cycle [N² m²]."""
        return self.cost / self.period

    @property
    def torque_squared_without_springs(self) -> float:
        """Mean of τᵀτ over a cycle without springs [N² m²]."""
        return self.cost_without_springs / self.period

    @property
    def torque_reduction(self) -> float:
        """1 - J_min / J(0, 0)."""
        return 1.0 - self.cost / self.cost_without_springs


def optimum(experiment: Experiment) -> list[Optimum]:
    """The optimum of each motion of an experiment, within its springs' bounds.

    The joint motion comes from inverse kinematics on the branch of the home pose, its torque from
    MuJoCo's inverse dynamics; the controller uses neither.

    Raises:
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
    """
    robot = build(experiment)
    experiment = resolved(experiment, robot)
    return along(experiment, robot, follow(experiment, robot))


def resolved(experiment: Experiment, robot: Robot) -> Experiment:
    """The experiment with what it left open in its motions filled in."""
    kinematics = Kinematics(robot)
    at_home = kinematics.position(robot.home)
    motion = []
    for index, given in enumerate(experiment.motion):
        name = f"experiment {experiment.name!r}: motion.{index}"
        fitting = motions.resolve(given, robot, at_home, name)
        motion.append(default_motion.sized(fitting, kinematics, name, experiment.law.alpha_0))
    return experiment.model_copy(update={"motion": tuple(motion)})


def along(experiment: Experiment, robot: Robot, found: list[JointMotion]) -> list[Optimum]:
    """The optimum of each of an experiment's joint motions, from `follow`."""
    q_c = center(experiment.law.q_c, found, robot)
    return [
        best_springs(
            joints.q,
            Kinematics(robot.carrying(motion.payload)).torque(joints),
            # Springs of other laws than the printed ones are centred on the motion's own mean.
            center=q_c if experiment.law.printed else joints.q.mean(axis=0),
            period=motion.period,
            bounds=experiment.springs,
        )
        for motion, joints in zip(experiment.motion, found, strict=True)
    ]


def follow(experiment: Experiment, robot: Robot) -> list[JointMotion]:
    """Joint motion of each motion of an experiment, by inverse kinematics."""
    kinematics = Kinematics(robot)
    start, found = robot.home, []
    for index, motion in enumerate(experiment.motion):
        steps = motion.steps(experiment.simulation.timestep)
        samples = motions.sample(motion, steps, robot)
        name = f"experiment {experiment.name!r}: motion.{index}"
        found.append(kinematics.follow(samples, start, motion.period, name, experiment.law.alpha_0))
        start = found[-1].q[-1]
    return found


def center(
    value: str | float | tuple[float, ...], found: list[JointMotion], robot: Robot
) -> np.ndarray:
    """Angles (n,) [rad] that `law.q_c` or `law.q_s` mean; "mean" is that of the first motion."""
    if isinstance(value, str):
        return found[0].q.mean(axis=0)
    return np.broadcast_to(np.asarray(value, float), robot.n).copy()


def best_springs(
    q: np.ndarray,
    torque: np.ndarray,
    *,
    center: np.ndarray,
    period: float,
    bounds: Springs,
) -> Optimum:
    """The constant springs that minimise (3) for a joint motion and the torque that it needs.

    Args:
        q: joint angles over a cycle, equally spaced in time (N, n) [rad].
        torque: torque that the motion needs, of motor and spring together (N, n) [N m].
        center: q_c, about which the offset torque is given (n,) [rad].
        period: cycle time [s].
        bounds: `Springs` with the bounds; (-inf, inf) for none.
    """
    mean = q.mean(axis=0)
    z = q - mean
    variance = (z**2).mean(axis=0)
    level = torque.mean(axis=0)
    moves = variance > springs.STILL
    slope = np.divide((z * torque).mean(axis=0), variance, out=np.zeros_like(mean), where=moves)

    stiffness, offset, equilibrium = np.empty_like(mean), np.empty_like(mean), np.empty_like(mean)
    low, high = bounds.equilibrium
    for j in range(len(mean)):
        shift = mean[j] - center[j]
        # Solved about the mean angle, where stiffness and offset do not interact in the cost.
        k, level_of_spring = springs.nearest(
            -slope[j], level[j], *bounds.stiffness, low - shift, high - shift, variance[j]
        )
        stiffness[j] = k
        offset[j] = level_of_spring + k * shift
        equilibrium[j] = (
            center[j] + offset[j] / k
            if k
            else np.copysign(np.inf, offset[j])
            if offset[j]
            else center[j]
        )
    left = torque - springs.torque(stiffness, offset, q, center)
    step = period / len(q)
    return Optimum(
        stiffness=stiffness,
        offset=offset,
        equilibrium=equilibrium,
        center=center,
        cost=float((left**2).sum() * step),
        cost_without_springs=float((torque**2).sum() * step),
        period=period,
        q=q,
        torque=left,
        torque_without_springs=torque,
    )
