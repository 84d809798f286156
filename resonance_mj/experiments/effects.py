"""Keys that were given and have no effect: a run does not pass over them in silence."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from ..errors import ExperimentError
from ..text import shown
from .experiment import Experiment
from .law_section import KINDS

LOOKED_AT = 16
"""Experiments of many in which it is looked for keys that change nothing."""


def without_effect(
    experiment: Experiment, *, square: bool | None = None, limited: bool | None = None
) -> list[str]:
    """Keys with a value of their own that changes nothing, a line each, with why.

    `square`: whether the task takes all joints of the arm; `limited`: whether one of these has a
    range; each None if that is not known.
    """
    said = []
    for key, reason in _reasons(experiment, square, limited):
        section, name = key.split(".")
        given = getattr(experiment, section)
        value, default = getattr(given, name), type(given).model_fields[name].default
        own = any(one != default for one in (value if isinstance(value, tuple) else (value,)))
        if name in given.model_fields_set and own:
            said.append(f"{key} = {shown(value)} has no effect: {reason}")
    return said


def refuse_idle(experiments: Sequence[Experiment], keys: Iterable[str], source: str) -> None:
    """Raise for a key that varies and changes nothing, with why.

    Args:
        experiments: of which a few are looked at.
        keys: that vary from one to another.
        source: what the error names.

    Raises:
        ExperimentError: in all of these a key has no effect.
    """
    few = experiments[:: max(1, len(experiments) // LOOKED_AT)]
    idle = [dict(_reasons(one, None, None)) for one in few]
    for key in keys:
        if all(key in each for each in idle):
            raise ExperimentError(f"{source}: keys.{key} has no effect: {idle[0][key]}")


def _reasons(
    experiment: Experiment, square: bool | None, limited: bool | None
) -> Iterator[tuple[str, str]]:
    """The keys that have none, whether given or not, and why."""
    law, springs = experiment.law, experiment.springs
    kind, own = f"law.kind = {law.kind!r}", law.kind not in KINDS
    adapts = own or law.kind in ("paper", "motor-torque", "transfer")
    learns = law.kind not in ("feedback", "computed-torque")
    by_hand = law.k_v is not None or law.k_p is not None
    if law.kind != "transfer":
        yield "law.listens", f"{kind} does not listen"
        yield "law.doubts", f"{kind} does not set springs between cycles"
        for name in ("stiffness_rate", "stiffness_lag"):
            yield f"reality.{name}", f"{kind} does not set springs between cycles"
    if not experiment.reality.encoder_noise:
        yield "reality.seed", "reality.encoder_noise is 0"
    if law.follows_joints or (experiment.task.space == "joint" and not own):
        for name in ("tool_offset", "link_error"):
            yield f"reality.{name}", "the law acts on joint angles, not on where it takes the tool"
    if not experiment.reality.sensed:
        yield "reality.velocity", "joint angles are exact, and their velocities too"
    if springs.cost != "torque-squared":
        yield "springs.weights", f"springs.cost = {springs.cost!r} has none"
    elif not any(one.tendon or len(one.joints or ()) > 1 for one in springs.element):
        yield "springs.weights", "springs of single joints are the same for all weights"
    if limited is False:
        yield "robot.limits", "no joint of the arm has a range"
    if not own:
        yield "law.parameters", "it is for a law of your own"
    if not learns:
        for name in ("beta", "eta", "lead", "harmonics"):
            yield f"law.{name}", f"{kind} learns nothing"
    elif law.beta is not None:
        yield "law.eta", "law.beta is given in its place"
    if law.follows_joints:
        for name in ("jacobian", "velocity"):
            yield f"law.{name}", f"{kind} acts on the errors of the joint angles"
        if square is False:
            for name in ("k_v", "k_p"):
                yield f"law.{name}", f"the task leaves joints free, which {kind} feeds back too"
        by_hand = by_hand and bool(square)
    if experiment.task.space == "joint" and not own:
        for name in ("k_v", "k_p", "jacobian", "velocity", "alpha_0"):
            yield f"law.{name}", "task.space = 'joint': the law acts on the joints' own errors"
        by_hand = False
    if by_hand and (not learns or law.beta is not None):
        yield "law.omega", "the feedback is given by law.k_v and law.k_p"
    unused = by_hand and not learns
    if unused:
        for name in ("alpha", "jacobian"):
            yield f"law.{name}", f"{kind} with law.k_v or law.k_p does not use y"
    if square and (unused or law.follows_joints or (law.jacobian or law.kind) in _WITHOUT_POSTURE):
        yield "law.alpha_0", "the task leaves no joint free"
    if not adapts:
        yield "law.gamma_qe", f"{kind} does not adapt the springs' offset"
        if law.kind != "joint-space":
            yield "law.gamma_k", f"{kind} does not adapt the springs' stiffness"
    if law.kind != "computed-torque":
        yield "law.overestimate", f"{kind} has no model"
    if not law.printed:
        yield "law.q_s", f"{kind} learns without (9), (10)"
    rates = {"gamma_k"} if law.kind == "joint-space" else {"gamma_k", "gamma_qe"}
    found = (law.printed or law.kind == "motor-torque") and not rates & law.model_fields_set
    centred = found or np.any(law.gamma_k) or (adapts and np.any(law.gamma_qe))
    if law.kind == "joint-space":
        centred = centred or np.any(springs.initial_stiffness)
    if not own and not (centred and (adapts or law.printed)):
        yield "law.q_c", f"{kind} does not adapt the springs by (6), (7) here"
    if np.isinf(springs.equilibrium).all():
        yield "springs.equilibrium_about", "springs.equilibrium has no bounds"
    if law.kind in ("fixed", "computed-torque"):
        for name in ("initial_stiffness", "initial_equilibrium"):
            yield f"springs.{name}", f"{kind} is given the optimal springs"
    elif (
        not np.any(springs.initial_stiffness) and springs.stiffness[0] <= 0 <= springs.stiffness[1]
    ):
        yield "springs.initial_equilibrium", "springs.initial_stiffness is 0"


_WITHOUT_POSTURE = ("inverse", "transpose", "paper")
"""Forms of (8), and a law with one of them, that do not know the posture."""
