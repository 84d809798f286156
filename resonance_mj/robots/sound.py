"""Whether an arm's numbers are ones that a simulation can work with."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from ..errors import RobotError

LARGEST = 1e15
"""Largest size of a number, in SI units, that is taken for meant."""

SINGULAR = 1e-14
"""Ratio of the inertia matrix's smallest to largest eigenvalue, scaled to 1 on the diagonal, below
which joints cannot be told apart."""

NUMBERS = {
    "body": ("body_mass", "body_inertia", "body_pos", "body_quat", "body_ipos", "body_iquat"),
    "joint": ("jnt_pos", "jnt_axis", "jnt_range", "jnt_stiffness"),
    "dof": ("dof_damping", "dof_armature", "dof_frictionloss"),
    "geom": ("geom_pos", "geom_size", "geom_margin"),
    "site": ("site_pos", "site_quat"),
    "actuator": ("actuator_gear", "actuator_ctrlrange", "actuator_forcerange"),
}
"""Of each kind of element, the arrays of mjModel that a simulation depends on."""


def check_numbers(model: mujoco.MjModel, path: Path) -> None:
    """Raise a RobotError that names an element with a number that is none, or beyond all bounds."""
    for kind, fields in NUMBERS.items():
        for field in fields:
            values = getattr(model, field)
            wrong = ~(np.abs(values) <= LARGEST)
            if not wrong.any():
                continue
            row = int(np.argmax(wrong.reshape(len(values), -1).any(axis=1)))
            owner = int(model.dof_jntid[row]) if kind == "dof" else row
            of = "joint" if kind == "dof" else kind
            name = getattr(model, of)(owner).name
            raise RobotError(
                f"{path}: {of} {name!r}: {field.partition('_')[2]} = "
                f"{float(values[row][wrong[row]].flat[0]) if values.ndim > 1 else values[row]:g}; "
                f"numbers from {-LARGEST:g} to {LARGEST:g} are valid"
            )
    if not (np.abs(model.opt.gravity) <= LARGEST).all():
        raise RobotError(f"{path}: option gravity = {model.opt.gravity.tolist()}: is not valid")


def check_inertia(inertia: np.ndarray, joints: tuple[str, ...], path: Path) -> None:
    """Raise a RobotError where joints move the same, or nothing that has a mass.

    Args:
        inertia: inertia matrix at home (n, n) [kg m^2].
        joints: their names (n).
        path: of the robot's file.
    """
    size = np.sqrt(np.maximum(np.diag(inertia), 0.0))
    for name, own in zip(joints, size, strict=True):
        if not own > 0.0:
            raise RobotError(
                f"{path}: joint {name!r} moves nothing that has an inertia: give what it moves a "
                "mass, or the joint an armature"
            )
    values, vectors = np.linalg.eigh(inertia / np.outer(size, size))
    if values[0] <= SINGULAR * values[-1]:
        pair = sorted(np.argsort(-np.abs(vectors[:, 0]))[:2])
        raise RobotError(
            f"{path}: joints {' and '.join(repr(joints[j]) for j in pair)} move the same masses "
            "about the same axis, and nothing tells them apart: take one of them out, or give "
            "what is between them a mass"
        )
