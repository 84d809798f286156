"""What to know before a run starts: motors too weak, poses nearly singular, what will diverge."""

import math

import numpy as np

from ..experiments.experiment import Experiment
from ..laws.gains import Gains
from ..laws.laws import listens
from ..laws.stability.divergence import Divergence, divergences
from ..motions.kinematics import JointMotion, Kinematics
from ..motions.margins import jerk
from ..robots.robot import Robot
from ..robots.touching import PASSING, touching
from ..springs import program
from ..springs.bounds import Bounds
from ..springs.fit import LinearSprings, columns
from ..springs.optimum import Optimum
from ..text import Caution, Note, joined, percent

ANALYSED = ("learning", "fixed", "paper", "transfer")
"""Laws whose learning is from the task-space y of (8): what `divergence` predicts."""

POSES = 40
"""Poses along a cycle at which gains and contacts are looked at."""

WASTED = 0.3
"""Share of torque² without springs from which it is said what damping and friction take of it."""

LISTENS = "as it grows, for no gain is given"
"""Of a law that tunes itself."""

WORTHWHILE = 0.05
"""Multiple of a learning gain from which it is worth saying that it would not diverge."""


def before(loaded: list[Kinematics], found: list[JointMotion], optima: list[Optimum]) -> list[str]:
    """What may go wrong on an arm with its motions, a line each.

    Args:
        loaded: kinematics of the arm with the payload of each motion.
        found: the joint motions.
        optima: their optima.
    """
    said: list[str] = []
    for index, (kinematics, joints, best) in enumerate(zip(loaded, found, optima, strict=True)):
        name = f"motion.{index}"
        sudden = None if kinematics.robot.joint_space else jerk(kinematics, joints)
        if sudden:
            why = sudden.said(kinematics.robot.joints)
            advice = "give another center, size or home"
            head = f"{name} comes near a singular pose"
            said.append(Note(f"{head}: {advice}", whole=f"{head}: {why}: {advice}"))
        said += _beyond_ranges(name, kinematics.robot, joints)
        said += _touching(name, kinematics.robot, joints)
        said += _weak_motors(name, kinematics.robot, best)
        said += _alike(name, kinematics.robot, joints, best.bounds)
    return list(map(Caution, said))


def lost(loaded: list[Kinematics], found: list[JointMotion], optima: list[Optimum]) -> list[str]:
    """Of motions that springs help little, how much damping and friction take, a line each.

    Arguments as of `before`.
    """
    said: list[str] = []
    for index, (kinematics, joints, best) in enumerate(zip(loaded, found, optima, strict=True)):
        robot = kinematics.robot
        resisted = robot.damping * joints.dq + robot.friction * np.sign(joints.dq)
        without = best.torque_squared_without_springs
        share = float((resisted**2).sum(axis=1).mean()) / without if without else 0.0
        if share > WASTED and best.torque_reduction < 1 - WASTED:
            head = (
                f"along motion.{index} damping and dry friction alone take {percent(share, 0)} of "
                "torque² without springs"
            )
            said.append(Note(head, ", and no spring can carry them"))
    return said


def _alike(name: str, robot: Robot, joints: JointMotion, bounds: Bounds) -> list[str]:
    """Springs and elements that cannot be told apart along a motion, a line if there are any."""
    if not bounds.elements:
        return []
    own = [f"the spring of {joint}" for joint in robot.joints]
    labels = [*own, *own, *(one.name for one in bounds.elements for _ in one.parameters)]
    least, most = (np.broadcast_to(end, robot.n) for end in bounds.stiffness)
    adjusted = np.concatenate([np.tile(least < most, 2), np.ones(len(labels) - 2 * robot.n, bool)])
    torque = columns(joints.q, bounds).torque[:, adjusted]
    some = [label for label, one in zip(labels, adjusted, strict=True) if one]
    which = list(dict.fromkeys(some[at] for at in program.alike(torque, robot.n)))
    return [
        Note(
            f"along {name} {joined(which)} cannot be told apart",
            ": what they exert together is adjusted, with the least of each",
        )
    ] * (len(which) > 1)


def held(robot: Robot, springs: LinearSprings | None) -> list[str]:
    """Which springs hold the arm at home from the first step, a line if any does."""
    if springs is None:
        return []
    names = [joint for joint, k in zip(robot.joints, springs.stiffness, strict=True) if k]
    head = f"springs hold {joined(names)} at home from the first step"
    return [Note(head, ": motors alone hardly could")]


def unstable(
    experiment: Experiment,
    loaded: list[Kinematics],
    gains: Gains,
    found: list[JointMotion],
    optima: list[Optimum],
    q_c: np.ndarray,
) -> list[str]:
    """What will diverge, a line each: feedback or learning that is unstable when sampled.

    Of the laws, those of `ANALYSED` are looked at. Arguments as in `divergences`.
    """
    if experiment.task.space == "joint":
        return []  # the analysis is of (8)
    learns: list[Divergence | None] = [None] * len(found)
    if experiment.law.kind in ANALYSED:
        learns = divergences(experiment, loaded, gains, found, optima, q_c)
    said: list[str] = []
    for index, (joints, why) in enumerate(zip(found, learns, strict=True)):
        name, motion = f"motion.{index}", experiment.motion[index]
        said += _unstable_feedback(name, experiment, loaded[index], gains, joints)
        if why:
            said.append(_diverging(name, experiment, gains, why, motion.cycles, motion.period))
    return list(map(Caution, said))


def rounded(experiment: Experiment) -> list[str]:
    """Times of `[reality]` that are no whole number of time steps, a line each."""
    dt, reality, said = experiment.simulation.timestep, experiment.reality, []
    for key in ("measurement_delay", "torque_delay", "control_period"):
        given, taken = getattr(reality, key), reality.steps(key, dt) * dt
        if given and abs(given - taken) > 1e-9:
            said.append(f"reality.{key} = {given:g} s is simulated as {taken:.6g} s, whole steps")
    return list(map(Caution, said))


def _poses(joints: JointMotion) -> np.ndarray:
    return joints.q[:: max(1, len(joints.q) // POSES)]


def _beyond_ranges(name: str, robot: Robot, joints: JointMotion) -> list[str]:
    """Joints that a motion takes beyond the ends of their ranges."""
    low, high = robot.model.jnt_range[robot.joint_id].T
    least, most = joints.q.min(axis=0), joints.q.max(axis=0)
    return [
        Note(
            f"{name} takes {robot.joints[j]} from {least[j]:.3g} to {most[j]:.3g}, beyond its "
            f"range, {low[j]:.3g} to {high[j]:.3g}",
            ": give another center, size or home",
        )
        for j in np.flatnonzero(((least < low) | (most > high)) & robot.limited)
    ]


def _touching(name: str, robot: Robot, joints: JointMotion) -> list[str]:
    """What touches along a motion."""
    found = touching(robot.model, robot.positions(_poses(joints)))
    return [
        Note(
            f"along {name} {touch}, for {percent(touch.share, 0)} of it",
            f": give another center, size or home, or {PASSING}",
        )
        for touch in found
    ]


def _weak_motors(name: str, robot: Robot, best: Optimum) -> list[str]:
    """Motors that cannot give the torque that a motion needs with the best springs."""
    low, high = robot.torque_limit.T
    # Of each motor the limit on the side to which its torque points.
    peaks = np.stack([best.torque.max(axis=0), -best.torque.min(axis=0)], axis=1)
    limits = np.stack([high, -low], axis=1)
    return [
        Note(
            f"{name} asks {robot.joints[j]} for {peaks[j, side]:.3g} N m even with the best "
            f"springs, and its motor gives {limits[j, side]:g}",
            _times_less(peaks[j, side], limits[j, side])
            + ": slow the motion down or make it smaller",
        )
        for j, side in enumerate((peaks - limits).argmax(axis=1))
        if peaks[j, side] > max(limits[j, side], 0.0)
    ]


def _times_less(needed: float, given: float) -> str:
    return f", {needed / given:.1f} times less" if given > 0 else ""


def _unstable_feedback(
    name: str, experiment: Experiment, kinematics: Kinematics, gains: Gains, joints: JointMotion
) -> list[str]:
    """Feedback that is unstable when sampled: a mode of Jᵀ K_v J + G + D faster than 2/dt.

    MuJoCo's integrators but RK4 take the joints' damping D implicitly, as if M were M + D dt.
    """
    dt, k_v = experiment.simulation.timestep, experiment.law.k_v
    limit, D = 2.0 / dt, np.diag(kinematics.robot.damping)
    implicit = 0.0 if experiment.simulation.integrator == "RK4" else dt
    # Of G what law.omega does not scale.
    constant = 0 * D if k_v is not None else gains.feedback - gains.omega * gains.inertia
    J = kinematics.jacobians(_poses(joints))
    M = np.array([kinematics.inertia(q) for q in _poses(joints)]) + implicit * D
    scaled = J.swapaxes(1, 2) @ (gains.k_v[:, None] * J) + gains.feedback - constant
    highest = _fastest(M, scaled + constant + D)
    if highest <= limit:
        return []
    most = 1.0 / max(_fastest(limit * M - D - constant, scaled), 1e-300)
    key, value = ("law.omega", gains.omega) if k_v is None else ("law.k_v", np.max(k_v))
    what = f"{key} = {value:g} is unstable when sampled along {name}"
    cure = f"the largest stable {key} is {value * most:.3g}"
    return [
        Note(
            f"{what}: {cure}",
            whole=f"{what}: its fastest mode, {highest:.0f} 1/s, exceeds 2/dt = {limit:.0f} 1/s; "
            f"{cure}",
        )
    ]


def _fastest(mass: np.ndarray, damping: np.ndarray) -> float:
    """The largest eigenvalue of mass⁻¹ damping (N, n, n) [1/s]."""
    return float(np.linalg.eigvals(np.linalg.solve(mass, damping)).real.max())


def _diverging(
    name: str, experiment: Experiment, gains: Gains, why: Divergence, cycles: int, period: float
) -> str:
    """That learning a motion will diverge, how and when, and what would not."""
    law, grows = experiment.law, why.onset
    key, value = ("law.eta", law.learned_share) if law.beta is None else ("law.beta", law.beta)
    cures = []
    if why.lead_margin >= 1:
        cures.append(f"law.lead = {why.lead}")
    elif why.lead != gains.lead and why.lead_margin > WORTHWHILE:
        smaller = _rounded_down(value * why.lead_margin)
        cures.append(f"law.lead = {why.lead} with {key} = {smaller:g}")
    if why.harmonics:
        cures.append(f"law.harmonics = {why.harmonics}")
    if why.margin > WORTHWHILE:
        cures.append(f"{key} = {_rounded_down(value * why.margin):g}")
    when = (
        f"about cycle {float(f'{grows.cycle:.2g}'):.0f}"
        if math.isfinite(grows.cycle)
        else "after more than ten million cycles"
    )
    percent = float(f"{100 * grows.growth:.2g}")
    ends = f"of {cycles}" if grows.cycle <= cycles else f"and this run ends at cycle {cycles}"
    cure = f"{' or '.join(cures)} would not diverge" if cures else f"{key} must be smaller"
    what = f"learning diverges {when} of such a motion as {name}, {ends}"
    return Note(
        f"{what}: {cure}",
        whole=f"{what}: with {key} = {value:g} and law.lead = {gains.lead} harmonics of 1/T from "
        f"{grows.first} on grow, {grows.fastest} ({grows.fastest / period:g} Hz) fastest, by "
        f"{percent:g} % in a cycle; {cure}"
        + (f"; the law looks for them itself {LISTENS}" if listens(law) else ""),
    )


def _rounded_down(value: float) -> float:
    """A value with two digits that is not above the given one."""
    digits = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / digits) * digits
