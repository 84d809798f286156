"""Keys that were given and have no effect on this law: a run does not pass over them in silence."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..text import shown
from .experiment import Experiment
from .law_section import KINDS


def without_effect(experiment: Experiment) -> list[str]:
    """Keys with a value of their own that changes nothing, a line each, with why."""
    said = []
    for key, reason in _reasons(experiment):
        section, name = key.split(".")
        given = getattr(experiment, section)
        value, default = getattr(given, name), type(given).model_fields[name].default
        own = any(one != default for one in (value if isinstance(value, tuple) else (value,)))
        if name in given.model_fields_set and own:
            said.append(f"{key} = {shown(value)} has no effect: {reason}")
    return said


def _reasons(experiment: Experiment) -> Iterator[tuple[str, str]]:
    """The keys that have none, whether given or not, and why."""
    law, springs = experiment.law, experiment.springs
    kind = f"law.kind = {law.kind!r}"
    adapts = law.kind in ("paper", "transfer") or law.kind not in KINDS
    if law.kind in KINDS:
        yield "law.parameters", "it is for a law of your own"
    if law.kind in ("feedback", "computed-torque"):
        for name in ("beta", "eta", "lead", "harmonics"):
            yield f"law.{name}", f"{kind} learns nothing"
    elif law.beta is not None:
        yield "law.eta", "law.beta is given in its place"
        if law.k_v is not None or law.k_p is not None:
            yield "law.omega", "the feedback is given by law.k_v and law.k_p"
    if not adapts:
        yield "law.gamma_qe", f"{kind} does not adapt the springs' offset"
        if law.kind != "joint-space":
            yield "law.gamma_k", f"{kind} does not adapt the springs' stiffness"
    if not law.printed:
        yield "law.q_s", f"{kind} learns without (9), (10)"
    centred = np.any(law.gamma_k) and (adapts or law.printed)
    if not centred and not (law.kind == "joint-space" and np.any(springs.initial_stiffness)):
        yield "law.q_c", f"{kind} does not adapt the stiffness by (6) here"
    if law.follows_joints:
        for name in ("jacobian", "velocity"):
            yield f"law.{name}", f"{kind} acts on the errors of the joint angles"
    if law.kind in ("fixed", "computed-torque"):
        for name in ("initial_stiffness", "initial_equilibrium"):
            yield f"springs.{name}", f"{kind} is given the optimal springs"
    elif not np.any(springs.initial_stiffness):
        yield "springs.initial_equilibrium", "springs.initial_stiffness is 0"
