"""What a plan needs of its own motions before it is whole: friction, stable springs, passages."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ExperimentError, MotionError
from ..experiments.experiment import Experiment
from ..laws.gains import gains
from ..motions import carrying, poses
from ..motions.kinematics import JointMotion, Kinematics
from ..springs.cost import Cost
from ..text import Note, joined, shown
from .driving import drives
from .filling import growing

if TYPE_CHECKING:
    from .plan import Plan

EXPLICIT = 1.0
"""Most that k dt² / m is of a spring k on an inertia m, which integrators take explicitly; alone it
is unstable from 4 on, and joints about nearly one axis share an inertia."""

POSES = 16
"""Of each motion, at which is looked how strong the feedback is."""

LATE = 0.04
"""The same of a control period: a joint that its spring has swing faster than 0.2 over the period
is driven by a feedback that late, where it should be damped."""


def finished(plan: Plan, notes: list[str]) -> Plan:
    """The plan with the friction of `[reality]`, springs that the time step bears, and passages.

    Args:
        plan: with everything but what its joint motions decide.
        notes: get a line of what is changed.
    """
    experiment = plan.experiment
    plan = replace(plan, loaded=rubbing(experiment, lambda: plan.joints, plan.loaded))
    with suppress(MotionError):
        plan = weighed(plan)
    with suppress(MotionError):
        plan = aiming(plan, notes)
    with suppress(MotionError):  # which is said where the motion is asked for
        plan = softened(plan, notes)
    with suppress(MotionError):
        taut(plan)
    follows = plan.left is not None
    grown = growing(experiment, plan.robot, lambda: plan.optima, notes, follows=follows)
    return replace(plan, experiment=grown)


def weighed(plan: Plan) -> Plan:
    """The plan with gains that no pose along the motions makes many times too strong."""
    experiment = plan.experiment
    if experiment.reality.sensed:  # whose gains are those of poses along them already
        return plan
    q = [joints.q[:: max(1, len(joints.q) // POSES)] for joints in plan.joints]
    middles = poses.middles(experiment, plan.kinematics)
    along = list(np.concatenate(q))
    return replace(plan, gains=gains(experiment, plan.kinematics, middles, along))


def taut(plan: Plan) -> None:
    """See that the stiffest antagonistic pairs are taut along the motions.

    Raises:
        ExperimentError: one goes slack however its tendons are pulled.
    """
    for number, element in enumerate(plan.robot.elements):
        if element.pair is None:
            continue
        for index, joints in enumerate(plan.joints):
            low, high = element.ends(joints.q)
            least = element.softest(joints.q)
            if least > element.stiffness[1]:
                raise ExperimentError(
                    f"experiment {plan.experiment.name!r}: springs.element.{number}.stiffness = "
                    f"{shown(list(element.stiffness))}: a tendon of {element.name} goes slack "
                    f"along motion.{index}, where its length is {low:.4g} to {high:.4g}; an upper "
                    f"bound of {least:.4g} or more keeps both taut, or a smaller pull"
                )


def aiming(plan: Plan, notes: list[str]) -> Plan:
    """The plan with springs that leave the least of what `springs.cost` says."""
    kind = plan.experiment.springs.cost
    if kind == "torque-squared":
        return plan
    motors = drives(plan.experiment, plan.robot, plan.needed, notes)
    bounds = plan.gains.bounds._replace(objective=Cost(kind, motors))
    return replace(plan, gains=replace(plan.gains, bounds=bounds))


def softened(plan: Plan, notes: list[str]) -> Plan:
    """The plan with springs below what is unstable at its steps, where the best are above.

    In a loop that is late none may be above: where a joint hardly moves, noise alone says how stiff
    its spring shall be.
    """
    dt, bounds = plan.experiment.simulation.timestep, plan.gains.bounds
    held = plan.experiment.reality.control_period
    late = held > dt
    alone = 1 / np.diag(np.linalg.inv(plan.robot.inertia))
    most = LATE * alone / held**2 if late else EXPLICIT * alone / dt**2
    stiff = np.max([best.stiffness > most for best in plan.optima], axis=0)
    if not (stiff.any() or late):
        return plan
    least, greatest = bounds.stiffness
    softer = np.maximum(np.where(stiff | late, np.minimum(greatest, most), greatest), least)
    if stiff.any():
        joints = plan.robot.joints
        names = [joint for joint, is_stiff in zip(joints, stiff, strict=True) if is_stiff]
        of, key = (
            ("control period", "reality.control_period")
            if late
            else ("time step", "simulation.timestep")
        )
        notes.append(
            Note(
                f"springs of {joined(names)} are at most "
                f"{', '.join(f'{k:.3g}' for k in softer[stiff])} N m/rad at a {of} of "
                f"{held if late else dt:g} s",
                ": stiffer ones are unstable, where these joints alone feel little inertia; a "
                f"shorter {key} allows more",
            )
        )
    gains = replace(plan.gains, bounds=bounds._replace(stiffness=(least, softer)))
    return replace(plan, gains=gains)


def rubbing(
    experiment: Experiment, joints: Callable[[], list[JointMotion]], loaded: list[Kinematics]
) -> list[Kinematics]:
    """The kinematics of the arm with the load of each motion, with friction in its joints.

    Args:
        experiment: says how much, as a share of the largest torque of each joint without it.
        joints: joint motion of each motion, asked for if there is friction.
        loaded: kinematics without it.
    """
    share = experiment.reality.friction
    if not share:
        return loaded
    torques = [one.torque(joint) for one, joint in zip(loaded, joints(), strict=True)]
    friction = share * np.max([np.abs(torque).max(axis=0) for torque in torques], axis=0)
    rubbed = {one: carrying.rubbing(one, friction) for one in dict.fromkeys(loaded)}
    return [rubbed[one] for one in loaded]
