"""Springs that hold the arm at home before anything is learned, where its motors cannot."""

import numpy as np

from ..experiments.experiment import Experiment
from ..motions.kinematics import JointMotion, Kinematics
from ..springs.bounds import Bounds
from ..springs.fit import LinearSprings, reach

WEAK = 0.5
"""Share of a motor's limit that gravity may take at home."""


def holding(
    experiment: Experiment, bounds: Bounds, loaded: Kinematics, q_c: np.ndarray
) -> LinearSprings | None:
    """Springs (n,) that bear the weight of those joints whose motors hardly can; of the others 0.

    They are the softest whose equilibrium is halfway to its bound. None where the motors suffice,
    where the experiment says how the springs start, and with laws that do not set springs.

    Args:
        experiment: gives the law and how springs start.
        bounds: what the springs may be.
        loaded: kinematics of the arm with its first load.
        q_c: centre of the springs (n,) [rad].
    """
    springs, robot = experiment.springs, loaded.robot
    given = np.any(springs.initial_stiffness) or np.any(springs.initial_equilibrium)
    if given or experiment.law.kind != "transfer":
        return None
    home = robot.home
    still = np.zeros((1, robot.n))
    weight = loaded.torque(JointMotion(home[None], still, still))[0]
    low, high = robot.torque_limit.T
    weak = (weight < WEAK * low) | (weight > WEAK * high)
    furthest = np.where(weight > 0, *reach(bounds, q_c)[::-1])
    away = np.where(np.isfinite(furthest), furthest / 2, np.sign(weight)) - (home - q_c)
    holds = weak & (away * weight > 0)
    if not holds.any():
        return None
    k = np.where(holds, weight / np.where(holds, away, 1.0), 0.0)
    k = np.where(holds, np.clip(k, *bounds.stiffness), 0.0)
    least, most = (k * np.where(k > 0, end, 0.0) for end in reach(bounds, q_c))
    return LinearSprings(k, np.clip(weight + k * (home - q_c), least, most), q_c)
