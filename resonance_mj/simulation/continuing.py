"""What a run goes on from: the state, the springs and the learned torque of a run before it."""

from typing import NamedTuple

import numpy as np

from ..errors import ExperimentError
from ..laws import learning
from ..plan.plan import Left, Plan
from ..results.run import Run
from ..springs.elements import Elements, names
from ..springs.fit import SPRINGS, LinearSprings
from ..text import shown


class Start(NamedTuple):
    """Of a robot before its first step."""

    q: np.ndarray
    """Joint angles (n,) [rad]."""
    dq: np.ndarray
    """Their velocity (n,) [rad/s]."""
    x: np.ndarray
    """Where the tool was a time step ago (m,) [m]."""
    springs: LinearSprings
    """That act."""
    u: np.ndarray
    """Learned torque of a cycle (N, n) [N m]."""


def left(run: Run) -> Left:
    """The motion that is left when another run goes on from this one.

    Raises:
        ExperimentError: the run has no end to go on from.
    """
    name = f"run {run.experiment.name!r}"
    if "q_end" not in run.data:
        raise ExperimentError(f"{name}: its last state was not kept by the version that made it")
    if run.data.sizes["cycle"] < sum(motion.cycles for motion in run.experiment.motion):
        raise ExperimentError(
            f"{name} ended as {run.status} in its cycle {run.data.sizes['cycle'] + 1}: only a run "
            "with all of its cycles can go on"
        )
    return Left(run.experiment.motion[-1], run.data["q_end"].values)


def start(run: Run, plan: Plan) -> Start:
    """Where a plan starts that goes on from a run: with what its law learns from its last cycle.

    Args:
        run: that has ended.
        plan: of what comes after it.

    Raises:
        ExperimentError: the arm or the task is another.
    """
    data = run.data
    parameters = data["parameter"].values if "parameter" in data else np.array([], str)
    for what, mine, its in (
        ("joints", plan.robot.joints, data["joint"].values),
        ("coordinates", plan.robot.axes, data["axis"].values),
        ("elastic elements' parameters", names(plan.robot.elements), parameters),
    ):
        if list(mine) != its.tolist():
            raise ExperimentError(
                f"experiment {plan.experiment.name!r} cannot go on from run "
                f"{run.experiment.name!r}: its {what} are {shown(list(mine))}, and those of the "
                f"run {shown(its)}"
            )
    last = data.isel(time=np.flatnonzero(data["cycle_of_sample"].values == data.sizes["cycle"]))
    k, offset, center = (data[f"{name}_per_cycle"].values[-1] for name in SPRINGS)
    others = Elements()
    if elements := plan.robot.elements:
        others = Elements(elements, data["parameters_per_cycle"].values[-1])
    springs = LinearSprings(k, offset, center, others)
    u = last["u"].values
    # What springs are that are not linear is learned anew.
    if not data["passage"].values[-1] and run.material is None:
        before = run.plan
        cycle = learning.Cycle(
            u=u,
            y=last["y"].values,
            q=last["q"].values,
            tau=last["tau"].values,
            q_desired=before.joints[-1].q if "joints" in before.law.told else last["q"].values,
            springs=springs,
            q_s=before.q_s,
        )
        u, springs = before.law.learn(cycle, before.gains, before.experiment)
    return Start(
        q=data["q_end"].values,
        dq=data["dq_end"].values,
        x=last["x"].values[-1],
        springs=springs,
        u=learning.resample(u, plan.steps(0)),
    )
