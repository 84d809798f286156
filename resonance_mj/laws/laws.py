"""The laws that an experiment can name: what each does at a step, learns from a cycle, is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..experiments.experiment import Experiment
from . import custom_law, learning
from .controller import Command, joint_space, standard
from .gains import Gains
from .learning import Cycle, Transferred

Between = Callable[[Cycle, Gains, Experiment], Transferred]
"""Torque and springs of the next cycle, from the last, the gains and the experiment."""


@dataclass(frozen=True)
class Law:
    """A law, by what it does on three time scales.

    Attributes:
        command: at each step, sets y and the motors' torque τ.
        between: after each cycle that is not a passage, sets the next cycle's torque and springs.
        adapts: gains of (6) and (7) that act at each step; the springs are constant without them.
        told: what it is given as a motion begins and the other laws do not know.
    """

    command: Command
    between: Between
    adapts: tuple[str, ...] = ()
    told: tuple[str, ...] = ()


def load(kind: str) -> Law:
    """The law that `law.kind` names.

    Raises:
        ExperimentError: it is a file that does not hold a law.
    """
    return LAWS[kind] if kind in LAWS else _of_a_file(kind)


def nothing(cycle: Cycle, gains: Gains, experiment: Experiment) -> Transferred:
    """Torque and springs as in the cycle before."""
    return Transferred(cycle.u, cycle.stiffness, cycle.offset, cycle.center)


def all_torque(cycle: Cycle, gains: Gains, experiment: Experiment) -> Transferred:
    """Learning of all torque: (9) without its last term, for springs that stay as they are."""
    v = cycle.u - learning.corrected(cycle.y, gains.learning, gains.lead)
    u = learning.low_pass(v, gains.harmonics)
    return Transferred(u, cycle.stiffness, cycle.offset, cycle.center)


def as_printed(cycle: Cycle, gains: Gains, experiment: Experiment) -> Transferred:
    """(9), (10): what a spring could exert is not learned, and left to (6), (7) to find."""
    return _printed(cycle, cycle.q, gains)


def as_printed_in_joint_space(cycle: Cycle, gains: Gains, experiment: Experiment) -> Transferred:
    """(9), (10) with the desired joint angles q_d in place of q, as in [4] (Sec. IV-C)."""
    return _printed(cycle, cycle.q_desired, gains)


def spring_transfer(cycle: Cycle, gains: Gains, experiment: Experiment) -> Transferred:
    """What a spring can exert of the learned torque is handed to the spring."""
    bounds = experiment.springs
    return learning.transfer(
        cycle.u,
        cycle.y,
        cycle.q,
        cycle.stiffness,
        cycle.offset,
        cycle.center,
        gain=gains.learning,
        lead=gains.lead,
        harmonics=gains.harmonics,
        bounds=(bounds.stiffness, bounds.equilibrium),
    )


def _printed(cycle: Cycle, q: np.ndarray, gains: Gains) -> Transferred:
    u = learning.learn(
        cycle.u,
        cycle.y,
        q,
        gain=gains.learning,
        q_s=cycle.q_s,
        lead=gains.lead,
        harmonics=gains.harmonics,
    )
    return Transferred(u, cycle.stiffness, cycle.offset, cycle.center)


def _of_a_file(file: str) -> Law:
    custom = custom_law.load(file)

    def between(cycle: Cycle, gains: Gains, experiment: Experiment) -> Transferred:
        signals = (cycle.u, cycle.y, cycle.q, cycle.stiffness, cycle.offset, cycle.center)
        parameters = np.array(experiment.law.parameters)
        return Transferred(*custom.learned(tuple(part.copy() for part in signals), parameters))

    adapts = ("gamma_k", "gamma_qe")
    return Law(custom.command, between if custom.learn else spring_transfer, adapts)


LAWS: dict[str, Law] = {
    "feedback": Law(standard, nothing),
    "learning": Law(standard, all_torque),
    "fixed": Law(standard, all_torque, told=("springs",)),
    "joint-space": Law(
        joint_space, as_printed_in_joint_space, adapts=("gamma_k",), told=("joints",)
    ),
    "paper": Law(standard, as_printed, adapts=("gamma_k", "gamma_qe")),
    "transfer": Law(standard, spring_transfer, adapts=("gamma_k", "gamma_qe")),
    "computed-torque": Law(joint_space, nothing, told=("joints", "springs", "torque")),
}
"""The laws that come with the program; `law_section.KINDS` has their names."""
