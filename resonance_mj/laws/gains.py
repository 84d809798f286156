"""The gains of a law on a robot: given by hand, or found from its inertia and the time step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..experiments.experiment import Experiment
from ..experiments.law_section import Law
from ..motions.kinematics import JointMotion, Kinematics
from ..robots.robot import Robot
from ..springs.bounds import JointBounds, per_joint
from ..springs.material import material_of

BANDWIDTH, FASTEST = 100.0, 0.3
"""Feedback bandwidth ω [1/s], and the most that it is of 1/dt."""

PRINTED = 60.0, 0.1
"""Likewise of the laws as printed, which diverge the sooner the more they learn."""

HELD = 0.1
"""Most that ω is of 1 over a control period of several time steps, in which torque is held: the
loop of a real arm is later still."""

GEARED = 0.04
"""The same where gears give way: rotors swing against the arm at a few hundred rad/s, undamped."""

POSITION = 10.0
"""Least weight α of the position error [1/s]."""

HARMONICS = 20
"""Harmonics of 1/T that the learned torque keeps, where the cycle has as many."""


LIGHT = 7.0
"""Strength of the feedback, of what ω says, in the pose along the motions where it is greatest,
from which on they decide M̂ and not their middles."""

STIFFNESS_RATE, OFFSET_RATE = 200.0, 500.0
"""Γ_k and Γ_qe per inertia [1/(rad² s²), 1/s²], where none are given: the paper's on its arm."""


@dataclass(frozen=True)
class Gains:
    """The law's gains as one robot has them.

    Attributes:
        jacobian: inverse, transpose or damped, in (8).
        velocity: of the tool, jacobian or difference.
        k_v: velocity feedback (m,) [N s/m].
        k_p: position feedback (m,) [N/m].
        feedback: G of the feedback -G y, or -G Δq̇ in joint space (n, n) [N m s/rad].
        feedback_p: G_p of the feedback -G_p s(Δq) in joint space (n, n) [N m/rad].
        omega: bandwidth ω of the inertial feedback [1/s].
        inertia: M̂ of it, at home, in the middle of the motions or along them (n, n) [kg m^2].
        alpha: weight of the position error in (8) [1/s].
        alpha_0: weight of the posture's error in its null space [1/s].
        learning: what is learned from y (n, n) [N m s/rad].
        lead: control periods that learning reads y ahead.
        harmonics: harmonics that the learned torque keeps; None for all.
        torque_limit: least and greatest torque of each motor (n, 2) [N m].
        bounds: what each joint's spring may be.
    """

    jacobian: str
    velocity: str
    k_v: np.ndarray
    k_p: np.ndarray
    feedback: np.ndarray
    feedback_p: np.ndarray
    omega: float
    inertia: np.ndarray
    alpha: float
    alpha_0: float
    learning: np.ndarray
    lead: int
    harmonics: int | None
    torque_limit: np.ndarray
    bounds: JointBounds


def gains(
    experiment: Experiment,
    kinematics: Kinematics,
    middles: Sequence[np.ndarray] = (),
    along: Sequence[np.ndarray] = (),
) -> Gains:
    """The gains of an experiment on its robot, with what it leaves open filled in.

    Without K_v and K_p the feedback is -(ω M̂ + D) y with M̂ as in Args and D the joints' own
    damping, so that one number serves every robot: a motor that drives a damped joint needs D q̇
    beside M q̈. Without β the law learns η times the feedback torque itself.

    Args:
        experiment: gives law, time step and motions.
        kinematics: of the robot.
        middles: joint angles (n,) in the middle of the motions, where those are not about home.
        along: joint angles (n,) along the motions. Without either M̂ is M(q_home).
    """
    law, robot = experiment.law, kinematics.robot
    n, m = robot.n, robot.m
    M = _mean_inertia(experiment, kinematics, middles or [robot.home], along)
    dt = experiment.simulation.timestep
    by_hand = not robot.joint_space and (law.k_v is not None or law.k_p is not None)
    # A sampled first-order loop of bandwidth ω is well damped while ω dt stays far below 2.
    own = kinematics.once("gravity_rate", lambda: gravity_rate(kinematics))
    usual, fastest = PRINTED if law.printed else (BANDWIDTH, FASTEST)
    held = experiment.reality.control_period
    most = HELD if experiment.reality.joint_stiffness is None else GEARED
    slower = max(most / held, 5 * own) if held > dt else np.inf
    omega = min(max(usual, 3 * own), fastest / dt, slower) if law.omega is None else law.omega
    rate = min(max(POSITION, own), 0.1 / dt)
    alpha = rate if law.alpha is None else law.alpha
    given = (law.k_v, law.k_p) if by_hand else (None, None)
    k_v, k_p = (np.broadcast_to(np.asarray(k or 0.0, float), m) for k in given)
    inertial = omega * M + np.diag(_damping(robot, M, dt) + _dry_friction(robot, M, dt))
    feedback = np.zeros((n, n)) if by_hand else inertial
    feedback_p = np.zeros((n, n))
    if law.follows_joints:
        feedback, feedback_p = _in_joint_space(law, robot, k_v, k_p, inertial, alpha)
        k_v = k_p = np.zeros(m)
    learning = law.learned_share * inertial if law.beta is None else law.beta * np.eye(n)
    steps = min(motion.steps(dt) for motion in experiment.motion)
    harmonics = law.harmonics
    if harmonics is None and not law.printed:
        harmonics = min(HARMONICS, steps // 4)
    square = "inverse" if law.printed and m == n else "damped"
    semi_implicit = experiment.simulation.integrator != "RK4"
    return Gains(
        jacobian=law.jacobian or square,
        velocity=law.velocity
        or ("difference" if semi_implicit and not law.printed else "jacobian"),
        k_v=k_v,
        k_p=k_p,
        feedback=feedback,
        feedback_p=feedback_p,
        omega=omega,
        inertia=M,
        alpha=alpha,
        alpha_0=rate if law.alpha_0 is None else law.alpha_0,
        learning=learning,
        lead=law.lead if law.lead is not None else (0 if law.printed else 1),
        harmonics=harmonics,
        torque_limit=robot.torque_limit,
        bounds=per_joint(
            experiment.springs, robot.joints, robot.elements, f"experiment {experiment.name!r}"
        )._replace(
            material=material_of(experiment.reality, n),
            resolution=experiment.reality.stiffness_resolution or 0.0,
        ),
    )


def _mean_inertia(
    experiment: Experiment,
    kinematics: Kinematics,
    middles: Sequence[np.ndarray],
    along: Sequence[np.ndarray],
) -> np.ndarray:
    """M̂ (n, n) [kg m^2]: the mean of M in the middles, or the inverse of that of M⁻¹ along motions.

    By the latter the feedback is as strong on average as ω says, and nowhere many times stronger: a
    pose where some way to move is light has an M⁻¹ that counts. It is taken where by the former the
    feedback would be `LIGHT` times as strong as ω says, and where the loop is late or noisy.
    """
    M = np.array([kinematics.inertia(q) for q in middles]).mean(axis=0)
    if not len(along):
        return np.asarray(M)
    inverse = np.array([np.linalg.inv(kinematics.inertia(q)) for q in along])
    strong = np.abs(np.linalg.eigvals(inverse @ M)).max(initial=0.0)
    if experiment.reality.sensed or strong > LIGHT:
        M = np.linalg.inv(inverse.mean(axis=0))
    return np.asarray(M)


def adaptation(robot: Robot) -> dict[str, np.ndarray]:
    """Γ_k [N m/rad^3] and Γ_qe [N m/rad] of (6), (7), (n,) each, where a user gives none."""
    inertia = np.diag(robot.inertia)
    return {"gamma_k": STIFFNESS_RATE * inertia, "gamma_qe": OFFSET_RATE * inertia}


def _damping(robot: Robot, M: np.ndarray, dt: float) -> np.ndarray:
    """Gain (n,) [N m s/rad] that damped joints have beside the inertial one: their damping D.

    Half of it where D is far above M/dt. There a joint keeps no speed from a step to the next, and
    a gain of D would take back in each step what the one before has done.
    """
    D, kept = robot.damping, np.diag(M)
    return D * (kept + 0.5 * dt * D) / (kept + dt * D)


def _dry_friction(robot: Robot, M: np.ndarray, dt: float) -> np.ndarray:
    """Gain (n,) [N m s/rad] that joints with dry friction have besides: it over 1 rad/s.

    At most what a joint that has broken loose bears when sampled: a quarter of the inertia that it
    feels alone, over dt.
    """
    return np.minimum(robot.friction, 0.25 / dt / np.diag(np.linalg.inv(M)))


def gravity_rate(kinematics: Kinematics) -> float:
    """How fast the arm falls from its home, or swings about it, by gravity alone: λ [1/s].

    λ² is the largest eigenvalue, of either sign, of M⁻¹ dτ/dq, with τ the torque of gravity. A
    small arm is fast: λ² is about gravity over length. Feedback must be faster to bear on it.
    """
    robot, step = kinematics.robot, 1e-5
    aside = step * np.concatenate([np.eye(robot.n), -np.eye(robot.n)])
    still = np.zeros_like(aside)
    torque = kinematics.torque(JointMotion(robot.home + aside, still, still))
    slope = (torque[: robot.n] - torque[robot.n :]).T / (2 * step)
    return float(np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(robot.inertia, slope))).max()))


def _in_joint_space(
    law: Law,
    robot: Robot,
    k_v: np.ndarray,
    k_p: np.ndarray,
    inertial: np.ndarray,
    alpha: float,
) -> tuple[np.ndarray, np.ndarray]:
    """G and G_p of the joint angles' errors that are at home what K_v and K_p are of the tool's.

    Where the task leaves joints free, K_v and K_p would leave them without feedback.
    """
    if (law.k_v is None and law.k_p is None) or robot.m < robot.n:
        return inertial, alpha * inertial
    J = robot.jacobian
    return J.T @ (k_v[:, None] * J), J.T @ (k_p[:, None] * J)
