"""Whether an arm's numbers are ones that a simulation can work with."""

import re
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from ..errors import RobotError
from ..text import shown
from . import source

LARGEST = 1e15
"""Largest size of a number, in SI units, that is taken for meant."""

SINGULAR = 1e-14
"""Ratio of the inertia matrix's smallest to largest eigenvalue, scaled to 1 on the diagonal, below
which joints cannot be told apart."""

NUMBERS = {
    "body": ("body_mass", "body_inertia", "body_pos", "body_quat", "body_ipos", "body_iquat"),
    "joint": ("jnt_pos", "jnt_axis", "jnt_range", "qpos0"),
    "dof": ("dof_damping", "dof_armature", "dof_frictionloss"),
    "geom": ("geom_pos", "geom_size", "geom_margin"),
    "site": ("site_pos", "site_quat"),
    "actuator": ("actuator_gear",),
    "key": ("key_qpos",),
}
"""Of each kind of element, the arrays of mjModel that a simulation depends on."""

NO_NUMBER = re.compile(rb"(?i)(?<![\w.])-?(nan|inf)(?![\w.])")


def check_texts(path: Path) -> None:
    """Raise a RobotError where a robot's files say NaN or infinity, or are not in UTF-8.

    MuJoCo takes both without a word: it simulates with them, or as if they were not there.
    """
    for where, content in source.texts(path):
        try:
            re.sub(rb"<!--.*?-->", b"", content, flags=re.DOTALL).decode()
        except UnicodeDecodeError as error:
            raise RobotError(
                f"{where}: holds {error.object[error.start : error.start + 20]!r}, which is not "
                "UTF-8: save it in UTF-8"
            ) from None
        if NO_NUMBER.search(content):
            _check_attributes(where, content)


def _check_attributes(where: str, content: bytes) -> None:
    try:
        elements = list(ElementTree.fromstring(content).iter())
    except ElementTree.ParseError:  # which MuJoCo rejects as well, and says why
        return
    names = {element.get(key) for element in elements for key in ("name", "class")}
    for element in elements:
        for key, value in element.attrib.items():
            if value not in names and not _finite(value):
                name = f" {shown(element.get('name'))}" if element.get("name") else ""
                raise RobotError(
                    f"{where}: {element.tag}{name}: {key} = {shown(value)}: only finite numbers "
                    "are valid"
                )


def _finite(value: str) -> bool:
    """Whether a text is no list of numbers, or one of finite numbers."""
    try:
        return bool(np.isfinite([float(part) for part in value.split()]).all())
    except ValueError:
        return True


def check_numbers(model: mujoco.MjModel, path: Path) -> None:
    """Raise a RobotError that names an element with a number that is none, or beyond all bounds."""
    for kind, fields in NUMBERS.items():
        for field in fields:
            values = getattr(model, field)
            wrong = ~(np.abs(values) <= LARGEST)
            if not wrong.any():
                continue
            row = int(np.argmax(wrong.reshape(len(values), -1).any(axis=1)))
            raise RobotError(
                f"{path}: {_called(model, kind, field, row)} = "
                f"{float(values[row][wrong[row]].flat[0]) if values.ndim > 1 else values[row]:g}; "
                f"numbers from {-LARGEST:g} to {LARGEST:g} are valid"
            )
    if not (np.abs(model.opt.gravity) <= LARGEST).all():
        raise RobotError(
            f"{path}: option: gravity = {shown(model.opt.gravity)}; numbers from {-LARGEST:g} to "
            f"{LARGEST:g} are valid"
        )


def _called(model: mujoco.MjModel, kind: str, field: str, row: int) -> str:
    """What a row of an array of mjModel is to the author of the file."""
    what = field.partition("_")[2]
    if kind == "dof":
        kind, row = "joint", int(model.dof_jntid[row])
    elif field == "qpos0":
        kind, row, what = "joint", int(np.flatnonzero(model.jnt_qposadr <= row)[-1]), "ref"
    name = getattr(model, kind)(row).name
    return f"{kind} {shown(name) if name else row}: {what}"


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
                f"{path}: joint {shown(name)} moves nothing that has an inertia: give what it "
                "moves a mass, or the joint an armature"
            )
    values, vectors = np.linalg.eigh(inertia / np.outer(size, size))
    if values[0] <= SINGULAR * values[-1]:
        pair = sorted(np.argsort(-np.abs(vectors[:, 0]))[:2])
        raise RobotError(
            f"{path}: joints {' and '.join(shown(joints[j]) for j in pair)} move the same masses "
            "about the same axis, and nothing tells them apart: take one of them out, or give "
            "what is between them a mass"
        )
