"""The joint motion of an arm that passes over into a motion, from rest or from the one before."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..motions import motion as motions
from ..motions.kinematics import JointMotion

if TYPE_CHECKING:
    from .plan import Plan


def passages(plan: Plan) -> dict[int, JointMotion]:
    """Joint motion of each cycle of a plan in which the arm passes over; see `Plan.passages`."""
    found: dict[int, JointMotion] = {}
    start = plan.robot.home if plan.left is None else plan.left.q
    for segment, motion in enumerate(plan.experiment.motion):
        first = plan.schedule.index(segment)
        cycles = range(first, first + motion.passage)
        if cycles:
            made = plan.kinematics.passage(
                motions.in_a_row([plan.desired(cycle) for cycle in cycles]),
                start,
                motion.passage * motion.period,
                f"experiment {plan.experiment.name!r}: passage to motion.{segment}",
                plan.gains.alpha_0,
            )
            steps = plan.steps(segment)
            for number, cycle in enumerate(cycles):
                part = slice(number * steps, (number + 1) * steps)
                found[cycle] = JointMotion(*(signal[part] for signal in made))
        start = plan.joints[segment].q[-1]
    return found
