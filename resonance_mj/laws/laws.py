"""The laws that an experiment can name: what each does at a step, learns from a cycle, is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np

from ..experiments import law_section
from ..experiments.experiment import Experiment
from ..springs.bounds import JointBounds, near, passive
from ..springs.cost import velocity
from ..springs.fit import LinearSprings
from . import custom_law, doubting, learning
from .controller import Command, joint_space, joint_task, standard
from .doubting import Belief
from .gains import Gains
from .learning import Cycle, Learn, Learned
from .tuning import BY_HAND

LIMITED = 0.25
"""Share of a cycle, of all motors, at whose limits learning rests."""


@dataclass(frozen=True)
class Law:
    """A law is two functions: what it does at each step, and what it learns between cycles.

    Attributes:
        functions: gives the two, `command` and `learn`.
        listens: whether, before it learns, it looks for noise and delay in its loop and tunes what
            is not given to them.
        adapts: gains of (6) and (7) that act at each step; the springs are constant without them.
        told: what it is given as a motion begins and the other laws do not know.
        file: of a user's law, whose code is executed with it.
    """

    functions: Callable[[], tuple[Command, Learn]]
    adapts: tuple[str, ...] = ()
    told: tuple[str, ...] = ()
    listens: bool = False
    file: str = ""

    @property
    def command(self) -> Command:
        """At each step, sets y and the motors' torque τ."""
        return self.functions()[0]

    @property
    def learn(self) -> Learn:
        """After each cycle that is not a passage, sets the next one's torque and springs."""
        return self.functions()[1]

    def in_space(self, space: str) -> Law:
        """The law for a task of the tool, or of the joints: then its error signal is theirs."""
        if space == "tool" or "joints" in self.told:
            return self
        own, told = self.functions, (*self.told, "joints")
        if self.file:
            return replace(self, told=told)
        return replace(self, functions=lambda: (joint_task, own()[1]), told=told)

    @property
    def said(self) -> list[str]:
        """That it is code, in a line."""
        return [f"law.kind: a run of it executes the code of {self.file}"] if self.file else []


def load(kind: str) -> Law:
    """The law that `law.kind` names; a user's file is executed when a function is asked for.

    Raises:
        ExperimentError: it is no file that can be read, or, when it is executed, holds no law.
    """
    if kind in LAWS:
        return LAWS[kind]
    source = custom_law.source_of(kind)

    @cache
    def functions() -> tuple[Command, Learn]:
        command, learn = custom_law.load(kind, source)
        return command, learn or spring_transfer

    return Law(functions, adapts=("gamma_k", "gamma_qe"), file=kind)


def listens(law: law_section.Law) -> bool:
    """Whether a law of these keys looks for noise and delay in its loop."""
    by_hand = any(getattr(law, key) is not None for key in BY_HAND)
    asked = not by_hand if law.listens is None else law.listens
    return law.kind in LAWS and LAWS[law.kind].listens and asked


def doubts(experiment: Experiment) -> bool:
    """Whether the law of an experiment doubts that springs are what they are set to be."""
    law, asked = experiment.law, experiment.law.doubts
    may = law.kind in LAWS and LAWS[law.kind].listens
    return may and (not experiment.reality.hookean if asked is None else asked)


def nothing(cycle: Cycle, gains: Gains, experiment: Experiment) -> Learned:
    """Torque and springs as in the cycle before."""
    return Learned(cycle.u, cycle.springs)


def all_torque(cycle: Cycle, gains: Gains, experiment: Experiment) -> Learned:
    """Learning of all torque: (9) without its last term, for springs that stay as they are."""
    return Learned(_learned_torque(cycle, gains), cycle.springs)


def as_printed(cycle: Cycle, gains: Gains, experiment: Experiment, q: str = "q") -> Learned:
    """(9), (10) along q: what a spring could exert is not learned, and left to (6), (7) to find."""
    law, mean = experiment.law, cycle.q.mean(axis=0)
    u = learning.learn(
        cycle.u,
        cycle.y,
        getattr(cycle, q),
        gain=gains.learning,
        q_s=mean if law.q_s == "running" else cycle.q_s,
        lead=gains.lead,
        harmonics=gains.harmonics,
    )
    return Learned(u, cycle.springs.about(mean) if law.q_c == "running" else cycle.springs)


def spring_transfer(cycle: Cycle, gains: Gains, experiment: Experiment) -> Learned:
    """What a spring can exert of the learned torque is handed to the spring.

    Springs of negative stiffness push the arm away, and motors at their limits cannot hold it.
    """
    v, q, bounds = _to_hand_over(cycle, gains)
    dq = None
    if bounds.objective:  # encoders' noise would be most of the velocity
        smooth = learning.low_pass(q, gains.harmonics)
        dq = velocity(smooth, len(q) * cycle.timestep)
    return learning.transfer(v, q, cycle.acting or cycle.springs, bounds, dq)


def transfer_in_doubt(cycle: Cycle, gains: Gains) -> tuple[np.ndarray, LinearSprings, Belief]:
    """The same where springs may not be linear, with what is believed of them from then on."""
    assert cycle.tuning.springs is not None
    v, q, bounds = _to_hand_over(cycle, gains)
    return doubting.handed_over(cycle.tuning.springs, v, q, cycle, bounds)


def _to_hand_over(cycle: Cycle, gains: Gains) -> tuple[np.ndarray, np.ndarray, JointBounds]:
    """What is learned and the joint angles (N, n) of a cycle, and what the next springs may be."""
    # What was measured was so much before.
    delay = cycle.tuning.delay
    q = np.roll(cycle.q, -delay, axis=0) if delay else cycle.q
    bounds = gains.bounds._replace(material=None)  # which no law is told
    bounds = passive(bounds) if cycle.limited else bounds
    if np.isfinite(cycle.farthest):
        bounds = near(bounds, cycle.springs.stiffness, cycle.farthest)
    return _learned_torque(cycle, gains), q, bounds


def _learned_torque(cycle: Cycle, gains: Gains) -> np.ndarray:
    """What the motors can give of it: more would be learned without end, and never exerted.

    Where motors are at their limits y does not tell what torque is missing: learning is the slower
    the more of the cycle they are, and rests from `LIMITED` of it on.
    """
    low, high = gains.torque_limit.T
    held_back = max(0.0, 1.0 - cycle.limited / LIMITED)
    pace = cycle.tuning.pace * cycle.tuning.share * held_back
    lead = gains.lead if cycle.tuning.lead is None else cycle.tuning.lead
    v = learning.learned_torque(
        cycle.u, cycle.y, gain=pace * gains.learning, lead=lead, harmonics=gains.harmonics
    )
    return np.clip(v, low, high)


# Along the desired joint angles, as in [4] (Sec. IV-C).
_in_joint_space = partial(as_printed, q="q_desired")


def _law(command: Command, learn: Learn, **more: Any) -> Law:
    return Law(lambda: (command, learn), **more)


LAWS: dict[str, Law] = {
    "feedback": _law(standard, nothing),
    "learning": _law(standard, all_torque),
    "fixed": _law(standard, all_torque, told=("springs",)),
    "joint-space": _law(joint_space, _in_joint_space, adapts=("gamma_k",), told=("joints",)),
    "motor-torque": _law(joint_space, all_torque, adapts=("gamma_k", "gamma_qe"), told=("joints",)),
    "paper": _law(standard, as_printed, adapts=("gamma_k", "gamma_qe")),
    "transfer": _law(standard, spring_transfer, adapts=("gamma_k", "gamma_qe"), listens=True),
    "computed-torque": _law(joint_space, nothing, told=("joints", "springs", "torque")),
}
"""The laws that come with the program; `law_section.KINDS` has their names."""
