"""What a plan fills in where an experiment leaves it open: adaptation gains, and how it begins."""

from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ..errors import MotionError
from ..experiments.effects import without_effect
from ..experiments.experiment import Experiment
from ..experiments.motion_section import Motion
from ..laws.gains import Gains, adaptation
from ..laws.laws import Law, doubts, listens
from ..robots.robot import Robot
from ..springs.optimum import Optimum
from ..text import Note, joined, shown

GROWTH = 12
"""Cycles over which a motion grows that the motors cannot make before springs help them."""

BY_TORQUE = {"gamma_k": 10.0, "gamma_qe": 1.0}
"""Adaptation gains by motor torque: such a spring learns within seconds."""

WEAK = 0.9
"""Share of a motor's limit above which its torque without springs is more than it can give."""


class Left(NamedTuple):
    """What an arm does before a plan begins, where it is not at rest at home."""

    motion: Motion
    """That it repeats."""
    q: np.ndarray
    """Its joint angles at the end of a cycle (n,) [rad]."""


def found(experiment: Experiment, robot: Robot, chosen: Gains) -> dict[str, object]:
    """The keys that an experiment leaves open, by their names, as they were found.

    Args:
        experiment: with its motions filled in.
        robot: of it.
        chosen: its law's gains on the robot.

    Returns:
        Those that have an effect: with them it is the same run, whatever later defaults are.
    """
    law = experiment.law
    values: dict[str, object] = {
        "robot.tool": robot.tools[0].name,
        "robot.home": robot.home.tolist(),
        "task.coordinates": [*robot.position_axes, *(["rotation"] if robot.rotates else [])],
        "law.jacobian": chosen.jacobian,
        "law.velocity": chosen.velocity,
        "law.omega": chosen.omega,
        "law.alpha": chosen.alpha,
        "law.alpha_0": chosen.alpha_0,
        "law.eta": law.learned_share,
        "law.lead": chosen.lead,
        "law.harmonics": chosen.harmonics,
        "law.listens": listens(law),
        "law.doubts": doubts(experiment),
    }
    given = experiment.model_dump()
    values = {
        key: value
        for key, value in values.items()
        if value is not None and given[key.partition(".")[0]][key.partition(".")[2]] is None
    }
    limited, square = bool(robot.limited.any()), robot.m == robot.n
    lines = without_effect(experiment.replace(values), square=square, limited=limited)
    idle = {line.partition(" = ")[0] for line in lines}
    return {key: value for key, value in values.items() if key not in idle}


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
    if given & set(law.adapts):
        return experiment
    if experiment.law.kind == "motor-torque":
        return experiment.replace({f"law.{name}": rate for name, rate in BY_TORQUE.items()})
    if not experiment.law.printed:
        return experiment
    rates = {name: gamma for name, gamma in adaptation(robot).items() if name in law.adapts}
    known = " and ".join(
        f"law.{name} = {shown([float(f'{value:.3g}') for value in gamma])}"
        for name, gamma in rates.items()
    )
    notes.append(f"{known}, from the joints' inertia at home")
    return experiment.replace({f"law.{name}": gamma.tolist() for name, gamma in rates.items()})


def growing(
    experiment: Experiment,
    robot: Robot,
    optima: Callable[[], list[Optimum]],
    notes: list[str],
    *,
    follows: bool,
) -> Experiment:
    """The experiment with the length of each passage that it leaves open.

    A motion whose motors are too weak to make it without springs grows from rest: while it is small
    they can make it, and what they learn then goes over to the springs, which grow with it. One
    that follows another does so too where the loop is late or noisy: in one cycle the feedback that
    such a loop bears would have to make what has been learned of another motion.

    Args:
        experiment: as it was given.
        robot: of it.
        optima: of its motions, asked for where motors have limits.
        notes: get a line of each motion that grows.
        follows: whether the first motion follows that of a run before.
    """
    filled = list(experiment.motion)
    for index, motion in enumerate(filled):
        if motion.blend is not None:
            continue
        weak: list[str] = []
        transfers = experiment.law.kind == "transfer"
        if transfers and np.isfinite(robot.torque_limit).any():
            with suppress(MotionError):  # which is said where the motion is asked for
                weak = _weak(robot, optima()[index].torque_without_springs)
        update: dict[str, float] = {"blend": min(1, motion.cycles - 1)}
        late = transfers and experiment.reality.sensed and (index > 0 or follows)
        if weak or late:
            # A duration that is given is kept.
            more = 0 if "duration" in motion.model_fields_set else GROWTH
            cycles = min(GROWTH, (motion.cycles + more) // 2)
            update = {"blend": cycles, "duration": motion.duration + more * motion.period}
            why = (
                f"springs take over what {joined(weak)} cannot give without them"
                if weak
                else "the loop is late or noisy"
            )
            head = f"motion.{index} grows over {cycles} cycles (motion.{index}.blend)"
            notes.append(Note(head, f": {why}"))
        filled[index] = motion.model_copy(update=update)
    return experiment.model_copy(update={"motion": tuple(filled)})


def _weak(robot: Robot, torque: np.ndarray) -> list[str]:
    """Joints whose motors hardly can give a torque (N, n) [N m]."""
    low, high = WEAK * robot.torque_limit.T
    beyond = ((torque < low) | (torque > high)).any(axis=0)
    return [joint for joint, is_beyond in zip(robot.joints, beyond, strict=True) if is_beyond]
