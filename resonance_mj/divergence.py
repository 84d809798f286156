"""Whether learning a motion will diverge: what grows, how fast, until when; what would not."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import onset, sampled_loop
from .experiment import Experiment
from .gains import Gains
from .kinematics import JointMotion
from .onset import Onset
from .optimal_springs import Optimum
from .robot import Robot
from .stability import examined, learning_loop

POSES = 20
"""Poses along a cycle at which the loop of learning is looked at."""

LEADS = (1, 2, 3, 0)
"""Leads to try in place of one that diverges [control periods]."""


class Divergence(NamedTuple):
    """How the learned torque of a motion will grow, and what would keep it from it.

    Attributes:
        onset: what grows, and the cycle of such a motion in which torque² passes that of the motion
            without springs, if it were repeated for so long.
        lead: a `law.lead` that would not diverge, None if none of `LEADS`.
        harmonics: the largest `law.harmonics` found that would not; 0 if there is none.
        margin: the multiple of β, or of η, that would not; next to 0 where every one diverges.
    """

    onset: Onset
    lead: int | None
    harmonics: int
    margin: float


def divergence(
    experiment: Experiment,
    robot: Robot,
    gains: Gains,
    joints: JointMotion,
    best: Optimum,
    *,
    q_c: np.ndarray,
    blend: int,
    start: tuple[np.ndarray, np.ndarray],
) -> Divergence | None:
    """Whether learning one motion of an experiment diverges, and how.

    Args:
        experiment: what would be run.
        robot: its arm.
        gains: as the arm has them.
        joints: the joint motion.
        best: its optimum; the springs are taken to be there.
        q_c: centre of the regressor of (6) (n,) [rad].
        blend: cycles of the passage into the motion, which teach nothing.
        start: joint angles and velocities before a motion without a passage (n,) [rad, rad/s].

    Returns:
        None if it does not diverge.
    """
    steps, lead, kept = len(joints.q), gains.lead, gains.harmonics

    def along(q: np.ndarray) -> sampled_loop.SampledLoop:
        return sampled_loop.along(experiment, robot, gains, q, stiffness=best.stiffness, q_c=q_c)

    poses = joints.q[np.arange(POSES) * steps // POSES]
    loop = learning_loop(along(poses), gains.learning, steps, examined(steps, kept))
    margin = loop.margin(lead, kept)
    if margin >= 1:
        return None
    limit, torque = best.torque_squared_without_springs, best.torque_without_springs
    jump = np.concatenate([start[0] - joints.q[0], start[1] - joints.dq[0]])
    begun = onset.at_the_beginning(
        limit,
        along(joints.q[:1]),
        gains.learning,
        torque,
        lead=lead,
        kept=kept,
        jump=None if blend else jump,
    )
    found = [begun, onset.elsewhere(loop, lead=lead)]
    # At most what it would be if the poses were held: the eigenvalues take time.
    most = float(loop.multiplier(lead)[:, loop.low].max()) - 1
    if most > (begun.growth if begun else 0):
        found.append(onset.of_low_harmonics(limit, loop, torque, lead=lead, kept=kept))
    earliest = min((one for one in found if one), key=lambda one: one.cycle)
    return Divergence(
        onset=earliest._replace(cycle=earliest.cycle + blend),
        lead=next((one for one in LEADS if loop.margin(one, kept) >= 1), None),
        harmonics=loop.most_harmonics(lead),
        margin=margin,
    )
