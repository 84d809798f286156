"""What a plan fills in where an experiment leaves it open: adaptation gains, and how it begins."""

from typing import NamedTuple

import numpy as np

from ..experiments.experiment import Experiment
from ..experiments.motion_section import Motion
from ..laws.gains import adaptation
from ..laws.laws import Law
from ..robots.robot import Robot
from ..text import shown


class Left(NamedTuple):
    """What an arm does before a plan begins, where it is not at rest at home."""

    motion: Motion
    """That it repeats."""
    q: np.ndarray
    """Its joint angles at the end of a cycle (n,) [rad]."""


def without_passage(experiment: Experiment, left: Motion) -> Experiment:
    """The experiment without a passage into its first motion, if that is the one that is left."""
    first, *others = experiment.motion
    other = {"duration": left.duration, "blend": left.blend, "payload": left.payload}
    if first.model_copy(update=other) != left:
        return experiment
    first = first.model_copy(update={"blend": 0})
    return experiment.model_copy(update={"motion": (first, *others)})


def adapting(experiment: Experiment, law: Law, robot: Robot, notes: list[str]) -> Experiment:
    """The experiment with adaptation gains for a law as printed that is given none.

    Args:
        experiment: as it was given.
        law: of it.
        robot: of it.
        notes: get a line of the gains.
    """
    given = experiment.law.model_fields_set
    if not experiment.law.printed or given & set(law.adapts):
        return experiment
    rates = {name: gamma for name, gamma in adaptation(robot).items() if name in law.adapts}
    known = " and ".join(
        f"law.{name} = {shown([float(f'{value:.3g}') for value in gamma])}"
        for name, gamma in rates.items()
    )
    notes.append(f"{known}, from the joints' inertia at home")
    return experiment.replace({f"law.{name}": gamma.tolist() for name, gamma in rates.items()})
