"""Whether learning a motion will diverge: what grows, how fast, until when; what would not."""

from typing import NamedTuple

import numpy as np

from ...experiments.experiment import Experiment
from ...motions.kinematics import JointMotion, Kinematics
from ...springs.optimum import Optimum
from ..gains import Gains
from . import onset
from .onset import Onset
from .sampled_loop import SampledLoop, along
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
        lead: the best `law.lead` of `LEADS`.
        lead_margin: the multiple of β, or of η, that would not diverge with it, 1 or more if this β
            would not.
        harmonics: the largest `law.harmonics` found that would not; 0 if there is none.
        margin: the multiple of β, or of η, that would not; next to 0 where every one diverges.
    """

    onset: Onset
    lead: int
    lead_margin: float
    harmonics: int
    margin: float


def divergences(
    experiment: Experiment,
    kinematics: list[Kinematics],
    gains: Gains,
    found: list[JointMotion],
    optima: list[Optimum],
    q_c: np.ndarray,
) -> list[Divergence | None]:
    """Of each motion of an experiment, how learning it alone will diverge; None if it will not.

    Args:
        experiment: what would be run, with a law of this program.
        kinematics: of its arm with the payload of each motion.
        gains: as the arm has them.
        found: the joint motions.
        optima: their optima; the springs are taken to be there.
        q_c: centre of the regressor of (6) (n,) [rad].
    """
    home = kinematics[0].robot.home
    start = np.concatenate([home, np.zeros_like(home)])
    said = []
    for motion, loaded, joints, best in zip(
        experiment.motion, kinematics, found, optima, strict=True
    ):
        begun = np.concatenate([joints.q[0], joints.dq[0]])
        jump = None if motion.passage else start - begun
        poses = joints.q[np.arange(POSES) * len(joints.q) // POSES]
        # Gains beyond all bounds overflow, and are above every limit all the same.
        with np.errstate(over="ignore", invalid="ignore"):
            arm = along(experiment, loaded, gains, poses, stiffness=best.stiffness, q_c=q_c)
            why = _of_motion(arm, gains, best, jump)
        if why:
            # A passage into the motion teaches nothing.
            cycle = why.onset.cycle + motion.passage
            why = why._replace(onset=why.onset._replace(cycle=cycle))
        said.append(why)
        start = begun
    return said


def _of_motion(
    arm: SampledLoop, gains: Gains, best: Optimum, jump: np.ndarray | None
) -> Divergence | None:
    if not arm.stable:
        return None
    steps, lead, kept = len(best.torque), gains.lead, gains.harmonics
    loop = learning_loop(arm, gains.learning, steps, examined(steps, kept))
    margin = loop.margin(lead, kept)
    if margin >= 1:
        return None
    limit = best.torque_squared_without_springs
    begins = onset.Beginning(arm, gains, best.torque_without_springs, jump)
    beginning = onset.at_the_beginning(limit, begins)
    grows = [beginning, onset.elsewhere(loop, lead)]
    harmonics = loop.most_harmonics(lead)
    # At most what it would be if the poses were held: the eigenvalues take time.
    most = float(loop.multiplier(lead)[:, loop.low].max()) - 1
    if most > (beginning.growth if beginning else 0):
        grows.append(onset.of_low_harmonics(limit, loop, begins, first=harmonics + 1))
    margins: dict[int, float] = {}
    for other in LEADS:
        margins[other] = loop.margin(other, kept)
        if margins[other] >= 1:
            break
    with_lead = max(margins, key=margins.__getitem__)
    return Divergence(
        onset=min((one for one in grows if one), key=lambda one: one.cycle),
        lead=with_lead,
        lead_margin=margins[with_lead],
        harmonics=harmonics,
        margin=margin,
    )
