"""What the motors of a run take in the end, beside the optimum's and those without springs."""

from collections.abc import Mapping

import numpy as np

from ..plan.plan import Plan
from ..results import schema
from ..springs.optimum import Optimum
from .hindrances import LastCycle


def of_motors(
    plan: Plan, optima: list[Optimum], last: Mapping[int, LastCycle]
) -> dict[str, np.ndarray]:
    """Power and peak torque of each motion, by `schema.MOTORS`, and the cost that was asked for.

    Args:
        plan: of the run.
        optima: of each motion.
        last: whole cycle of a motion, by its number from 0; NaN where there is none.
    """
    drives, none = plan.drives, (np.full((1, plan.robot.n), np.nan),) * 2
    objective = plan.gains.bounds.objective
    names = schema.MOTORS if objective is None else (*schema.MOTORS, *schema.COST[1:])
    found = {name: np.empty(len(optima)) for name in names}
    for segment, best in enumerate(optima):
        cycle = last.get(segment)
        each = {
            "": (cycle.tau, cycle.dq) if cycle else none,
            "_optimal": (best.torque, best.dq),
            "_without_springs": (best.torque_without_springs, best.dq),
        }
        for of, (tau, dq) in each.items():
            power = drives.electrical_power(tau, dq).sum(axis=1).mean()
            found[f"electrical_power{of}"][segment] = power
            found[f"peak_torque{of}"][segment] = drives.peak(tau)
            if objective is not None and of:
                found[f"cost{of}"][segment] = objective.of(tau, dq)
    return found
