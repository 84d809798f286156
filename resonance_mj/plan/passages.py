"""How an arm passes over into a motion, from rest or from the one before."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..motions import motion as motions
from ..motions import passing
from ..motions.kinematics import JointMotion
from ..robots.reach import reach

if TYPE_CHECKING:
    from .plan import Plan


def passages(plan: Plan) -> dict[int, JointMotion]:
    """Joint motion of each cycle of a plan in which the arm passes over; see `Plan.passages`."""
    found: dict[int, JointMotion] = {}
    start = plan.robot.home if plan.left is None else plan.left.q
    for segment, motion in enumerate(plan.experiment.motion):
        first = plan.schedule.index(segment)
        cycles = range(first, first + motion.passage)
        if plan.robot.joint_space:
            found |= {cycle: JointMotion(*_wanted(plan, cycle)[:3]) for cycle in cycles}
        elif cycles:
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


def desired(plan: Plan, cycle: int) -> motions.Samples:
    """The desired motion in a cycle of a plan; see `Plan.desired`."""
    wanted = _wanted(plan, cycle)
    if plan.robot.joint_space:
        return plan.kinematics.tool_path(JointMotion(*wanted[:3]))
    return wanted


def extents(plan: Plan) -> np.ndarray:
    """Largest extent of the tool's path in each motion [m]; of a point a hundredth of the reach."""
    last = np.cumsum([motion.cycles for motion in plan.experiment.motion]) - 1
    positions = len(plan.robot.position_axes)
    found = [np.ptp(desired(plan, cycle).x[:, :positions], axis=0).max() for cycle in last.tolist()]
    return np.array([extent or 0.01 * reach(plan.robot) for extent in found])


def _wanted(plan: Plan, cycle: int) -> motions.Samples:
    """The motion as it is given, of the tool or of the joints."""
    segment = plan.schedule[cycle]
    motion, steps = plan.experiment.motion[segment], plan.steps(segment)
    samples = motions.sample(motion, steps, plan.robot)
    begun = plan.blending(cycle)
    if begun is None:
        return samples
    left = plan.experiment.motion[segment - 1] if segment else plan.left and plan.left.motion
    if left is None:
        still = np.zeros_like(samples.x)
        home = plan.robot.home
        home = still + (home if plan.robot.joint_space else plan.kinematics.position(home))
        before = motions.Samples(home, still, still)
    else:
        # The motion that is left goes on by the clock while the new one takes over.
        length = left.steps(plan.experiment.simulation.timestep)
        old = motions.sample(left, length, plan.robot)
        at = (begun * steps + np.arange(steps)) % length
        before = motions.Samples(old.x[at], old.dx[at], old.ddx[at])
        if motion.gradual:
            middles = old.x.mean(axis=0), samples.x.mean(axis=0)
            return passing.by_a_small_motion(
                before, samples, middles, begun, motion.passage, motion.period
            )
    return passing.blended(before, samples, begun, motion.passage, motion.period)
