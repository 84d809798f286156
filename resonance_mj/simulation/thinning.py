"""Of which cycles of a long run the samples are kept."""

import numpy as np

from ..plan.plan import Plan


def kept_cycles(plan: Plan) -> set[int]:
    """Cycles whose samples are kept: all, or pairs in a row over each motion with both ends.

    What is learned from a cycle shows in the next.
    """
    motions, budget = plan.experiment.motion, plan.experiment.simulation.samples
    total = sum(motion.cycles * plan.steps(i) for i, motion in enumerate(motions))
    share = min(1.0, budget / total)
    kept: set[int] = set()
    first = 0
    for motion in motions:
        pairs = max(4, int(share * motion.cycles)) // 2
        if share == 1.0 or 2 * pairs >= motion.cycles:
            kept.update(range(first, first + motion.cycles))
        else:
            begins = first + np.linspace(0, motion.cycles - 2, pairs).round().astype(int)
            kept.update(begins, begins + 1)
        first += motion.cycles
    return {int(cycle) for cycle in kept}
