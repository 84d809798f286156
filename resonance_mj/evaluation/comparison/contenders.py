"""The laws that users compare: each as the keys of an experiment that make it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...experiments.experiment import Experiment
from ...robots.robot import build

Changes = dict[str, Any]

STIFFNESS_RATE, OFFSET_RATE = 200.0, 500.0
"""Γ_k and Γ_qe per inertia [1/(rad² s²), 1/s²], where none are given: the paper's on its arm."""

BETA = 10.0
"""Learning gain of the transfer for K_v of the paper's size [N m s/rad]."""


class Contender(NamedTuple):
    """A law to compare: that of an experiment, but for some keys."""

    name: str
    """Of its folder."""
    title: str
    changes: Changes


NO_SPRINGS: Changes = {"springs.initial_stiffness": 0.0, "springs.initial_equilibrium": 0.0}
FOUND: Changes = {"law.lead": None, "law.harmonics": None}
PRINTED: Changes = {
    "law.kind": "paper", "law.lead": 0, "law.harmonics": None, "law.jacobian": None
}  # fmt: skip
JOINT_SPACE: Changes = {
    "law.kind": "joint-space",
    "law.q_c": "mean",
    "law.q_s": "mean",
    "springs.initial_equilibrium": 0.0,
}
TRANSFER: Changes = {
    "law.kind": "transfer", "law.lead": 2, "law.gamma_k": 0.0, "law.gamma_qe": 0.0
}  # fmt: skip

CONTENDERS = (
    Contender("feedback", "feedback only", {"law.kind": "feedback", **NO_SPRINGS}),
    Contender("learning", "learning only", {"law.kind": "learning", **NO_SPRINGS, **FOUND}),
    Contender("fixed", "optimal springs", {"law.kind": "fixed", **FOUND}),
    Contender("joint-space", "joint space", PRINTED | JOINT_SPACE),
    Contender("printed", "as printed", PRINTED),
    Contender("printed-transpose", "as printed, Jᵀ", PRINTED | {"law.jacobian": "transpose"}),
    Contender("printed-lead", "as printed, lead 1", PRINTED | {"law.lead": 1}),
    Contender("transfer", "transfer", PRINTED | TRANSFER),
    Contender("computed-torque", "computed torque", {"law.kind": "computed-torque"}),
)
"""What is compared, from the law that knows least to the one that knows all."""


def contending(experiment: Experiment) -> list[tuple[Contender, Experiment]]:
    """The experiment under each law, with gains that fit it where it has none of the law's kind.

    The transfer has the experiment's own settings where that is its law; a law of the user's own is
    compared as well.
    """
    law, found = experiment.law, []
    adapts = np.any(law.gamma_k) or np.any(law.gamma_qe)
    inertia = np.zeros(0) if adapts else np.diag(build(experiment).inertia)
    for one in CONTENDERS:
        changes = dict(one.changes)
        if changes["law.kind"] in ("paper", "joint-space") and not adapts:
            changes["law.gamma_k"] = (STIFFNESS_RATE * inertia).tolist()
            changes["law.gamma_qe"] = (OFFSET_RATE * inertia).tolist()
        if changes["law.kind"] == "transfer":
            changes["law.beta"] = None if law.k_v is None else BETA
            if law.kind == "transfer":
                changes = {}
        found.append((one, experiment.replace(changes)))
    if law.kind.endswith(".py"):
        found.append((Contender("own", Path(law.kind).name, {}), experiment))
    return found
