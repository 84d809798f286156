"""Elastic elements on an arm: each is one of MuJoCo's own tendon springs, or two of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ..errors import RobotError
from ..experiments.springs_section import Element as Given
from ..experiments.springs_section import Springs
from ..springs.antagonist import Pair
from ..springs.elements import Element, Elements
from ..text import listed, nearest, shown
from . import names

if TYPE_CHECKING:
    from .mjcf import Arm

FAR = 1e10
"""Length that no element has."""

TURN = np.pi
"""How far a joint without a range turns from home, or slides [rad, m]."""


def elements(springs: Springs, arm: Arm, home: np.ndarray) -> tuple[Element, ...]:
    """The elements of an experiment on an arm.

    Args:
        springs: of the experiment.
        arm: that was found in the robot's file; its notes get a line of tendons that are elements.
        home: joint angles at the start (n,) [rad].

    Raises:
        RobotError: an element names a joint or a tendon that the arm does not have, or a rest
            length that its joints cannot bring it to.
    """
    model, ids = arm.model, arm.joint_id
    limited = model.jnt_limited[ids].astype(bool)[:, None]
    ranges = np.where(limited, model.jnt_range[ids], home[:, None] + [-TURN, TURN])
    found = []
    for index, given in enumerate(springs.element):
        where = f"{arm.path}: springs.element.{index}"
        radii, stiffness, rest = _over(given, model, arm.joints, where)
        ends = np.sort(radii[:, None] * ranges, axis=1).sum(axis=0)
        travel = float(ends[0]), float(ends[1])
        if given.kind in ("above", "below") and rest is None:
            at_home = float(radii @ home)
            rest = at_home, at_home
        center = float(radii @ home)
        if rest is not None and rest[0] == rest[1]:
            center = rest[0]
            if given.kind in ("above", "below") and not travel[0] <= center <= travel[1]:
                raise RobotError(
                    f"{where}.rest = {center:.6g}: the joints bring it to lengths from "
                    f"{travel[0]:.4g} to {travel[1]:.4g}"
                )
        pair = None
        if given.pull is not None:
            pair = Pair(*given.pull, given.pretension, given.holding)
            stiffness = max(2 * pair.rate, stiffness[0]), stiffness[1]
        found.append(
            Element(given.called, given.kind, radii, stiffness, rest, center, travel, pair)
        )
    if named := [given.tendon for given in springs.element if given.tendon]:
        arm.notes.append(f"elements, adjusted instead of as in the file: tendons {listed(named)}")
    return tuple(found)


def add(spec: mujoco.MjSpec, elements: tuple[Element, ...], joints: tuple[str, ...]) -> None:
    """Add the tendons of elements, without stiffness, to a spec that has no others."""
    for element in elements:
        below, above = element.center, element.center
        if element.kind == "above":
            below = -FAR
        elif element.kind == "below":
            above = FAR
        slack = [[below, above]] * (1 + (element.kind == "cubic"))
        if element.pair is not None:
            slack = [[-FAR, above], [below, FAR]]
        for ends in slack:
            tendon = spec.add_tendon(name=names.free(element.name, spec.tendon))
            tendon.springlength = ends
            for joint, radius in zip(joints, element.radii, strict=True):
                if radius:
                    tendon.wrap_joint(joint, radius)


def write(model: mujoco.MjModel, springs: Elements) -> None:
    """Rewrite mjModel's tendon springs, which `add` has made, with the elements' parameters."""
    at = 0
    for (element, p), rest in zip(springs.each(), springs.rest(), strict=True):
        if element.pair is not None:
            # Shorter than its rest length the second is stretched, and there x is negative.
            model.tendon_lengthspring[[at, at + 1], [1, 0]] = element.pair.ends(p[0], rest)
            model.tendon_stiffness[at : at + 2] = element.pair.rate
            model.tendon_stiffnesspoly[at : at + 2, 0] = np.array([1, -1]) * element.pair.hardening
            at += 2
            continue
        model.tendon_stiffness[at] = p[0]
        if len(p) > 1:
            if p[0] == 0.0 != p[-1]:
                model.tendon_stiffness[at] = p[-1] / (rest - element.center)
            model.tendon_lengthspring[at] = rest
        if element.kind == "cubic":
            at += 1
            model.tendon_stiffnesspoly[at, :2] = p[1:3]
        at += 1


def read(model: mujoco.MjModel, elements: tuple[Element, ...]) -> Elements:
    """The elements with the parameters that `write` has put into mjModel."""
    found, at = [], 0
    for element in elements:
        if element.pair is not None:
            first, second = model.tendon_lengthspring[[at, at + 1], [1, 0]].tolist()
            k, rest = element.pair.spring((first, second))
            found += [k, k * (rest - element.center)]
            at += 2
            continue
        k = float(model.tendon_stiffness[at])
        p = [k, k * (float(model.tendon_lengthspring[at, 1]) - element.center)]
        if element.kind == "cubic":
            at += 1
            p[1:1] = model.tendon_stiffnesspoly[at, :2].tolist()
        at += 1
        found += p[: len(element.parameters)]
    return Elements(elements, np.array(found))


def _over(
    given: Given, model: mujoco.MjModel, joints: tuple[str, ...], where: str
) -> tuple[np.ndarray, tuple[float, float], tuple[float, float] | None]:
    """Radii (n,), bounds of the stiffness and of the rest length of an element."""
    stiffness, rest = given.stiffness, given.rest
    bounds = rest if isinstance(rest, tuple) or rest is None else (rest, rest)
    if given.tendon is None:
        named = given.joints or ()
        pairs = list(zip(named, given.radii or (1.0,) * len(named), strict=True))
    else:
        tendons = [model.tendon(i).name for i in range(model.ntendon)]
        if given.tendon not in tendons:
            raise RobotError(
                f"{where}.tendon = {shown(given.tendon)}: no such tendon"
                f"{nearest(given.tendon, tendons)}; its tendons are {listed(tendons)}"
            )
        pairs, of_file, at = _of_tendon(model, tendons.index(given.tendon), where)
        if of_file > 0:
            stiffness = stiffness or (of_file, of_file)
            bounds = bounds or (at, at)
    radii = np.zeros(len(joints))
    for name, radius in pairs:
        if name not in joints:
            raise RobotError(
                f"{where}: the arm has no joint {shown(name)}{nearest(name, joints)}; its joints "
                f"are {listed(joints)}"
            )
        radii[joints.index(name)] = radius
    return radii, stiffness or (0.0, np.inf), bounds


def _of_tendon(
    model: mujoco.MjModel, tendon: int, where: str
) -> tuple[list[tuple[str, float]], float, float]:
    """Joints with their radii, stiffness and rest length of a fixed tendon of the file."""
    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    if any(model.wrap_type[i] != int(mujoco.mjtWrap.mjWRAP_JOINT) for i in wraps):
        raise RobotError(f"{where}.tendon: it is not a fixed tendon, of which joints have radii")
    low, high = model.tendon_lengthspring[tendon].tolist()
    if low != high:
        raise RobotError(
            f"{where}.tendon: it is slack from {low:g} to {high:g}: give joints and radii, and a "
            'kind "above" or "below" for each side'
        )
    pairs = [(model.joint(model.wrap_objid[i]).name, float(model.wrap_prm[i])) for i in wraps]
    return pairs, float(model.tendon_stiffness[tendon]), low
