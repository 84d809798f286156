"""What acts on the joints besides the law is taken out of the model."""

from __future__ import annotations

import mujoco
import numpy as np

from ..text import listed


def take_out(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Delete what acts on joints besides motors and the law, or refers to what is deleted."""
    for kind, elements in (
        ("tendons", spec.tendons),
        ("equality constraints", spec.equalities),
        ("sensors", spec.sensors),
        ("keyframes", spec.keys),
    ):
        names = [element.name or "unnamed" for element in elements]
        for element in list(elements):
            spec.delete(element)
        if names and kind not in ("sensors", "keyframes"):
            notes.append(f"taken out: {kind} {listed(names)}")


def take_springs_off(
    spec: mujoco.MjSpec, model: mujoco.MjModel, joints: tuple[str, ...], notes: list[str]
) -> None:
    """Take the file's own springs off the arm's joints: the law puts its own there.

    The damping that MuJoCo derives from `springdamper` in the file's `model` stays.
    """
    taken = []
    for name in joints:
        joint = spec.joint(name)
        if np.any(joint.springdamper):
            joint.damping[0] = model.dof_damping[model.joint(name).dofadr[0]]
        if np.any(joint.stiffness) or joint.springyield > 0 or np.any(joint.springdamper):
            taken.append(name)
        joint.stiffness = [0.0, 0.0, 0.0]
        joint.springyield = 0.0
        joint.springdamper = [0.0, 0.0]
    if taken:
        notes.append(f"taken off, the law puts its own there: springs of {listed(taken)}")


def passive_gravity(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Leave gravity compensation outside the motors, whose torque is the law's alone."""
    for joint in spec.joints:
        joint.actgravcomp = False
    names = [body.name for body in spec.bodies if body.gravcomp]
    if names:
        notes.append(f"the file takes weight off besides the motors (gravcomp): {listed(names)}")


def switch_on(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Switch on what the law needs and the file switches off."""
    bits = mujoco.mjtDisableBit
    needed = {
        "springs": bits.mjDSBL_SPRING,
        "actuation": bits.mjDSBL_ACTUATION,
        "control limits": bits.mjDSBL_CLAMPCTRL,
    }
    names = [name for name, bit in needed.items() if spec.option.disableflags & int(bit)]
    for bit in needed.values():
        spec.option.disableflags &= ~int(bit)
    spec.option.disableactuator = 0
    if names:
        notes.append(f"switched on, the law needs them: {listed(names)}")
