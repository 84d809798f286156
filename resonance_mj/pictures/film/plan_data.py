"""What there is to show of a plan, before a run: the arm along its desired motion."""

import numpy as np

from ...plan.plan import Plan
from .frame_data import FrameData


def planned(one: Plan, cycle: int) -> FrameData:
    """A cycle of the run, counted from 0, as it should be: the desired motion, and no torque."""
    segment = one.schedule[cycle]
    steps, dt = one.steps(segment), one.experiment.simulation.timestep
    best = one.optima[segment]
    axes = tuple("xyz".index(axis) for axis in one.robot.position_axes)
    none = np.zeros((4, steps, one.robot.n))
    x = one.desired(cycle).x[:, : len(axes)]
    return FrameData(
        label=one.experiment.name,
        robot=one.experiment.robot,
        joints=one.robot.joints,
        slides=one.robot.slides,
        axes=axes,
        sample=np.arange(steps),
        time=(sum(map(one.steps, one.schedule[:cycle])) + np.arange(steps)) * dt,
        cycle=np.full(steps, cycle + 1),
        period=np.full(steps, steps),
        q=one.joints[segment].q.copy(),
        x=x.copy(),
        x_desired=x.copy(),
        stiffness=none[0],
        offset=none[1],
        center=none[2],
        tau=none[3],
        reduction=np.full(steps, np.nan),
        best=np.full(steps, best.torque_reduction),
    )
