"""What acts on the joints besides the law is taken out of the model."""

import mujoco
import numpy as np

from ..text import Note, listed
from .touching import FAR, called, contacts, distance


def take_out(spec: mujoco.MjSpec, notes: list[str], kept: list[int]) -> None:
    """Delete what acts on joints besides motors and the law, or refers to what is deleted.

    Args:
        spec: of the robot, changed.
        notes: get a line of each kind that is taken out.
        kept: numbers of the equality constraints by which joints follow the arm's.
    """
    for kind, elements in (
        ("tendons", spec.tendons),
        ("equality constraints", [e for i, e in enumerate(spec.equalities) if i not in kept]),
        ("sensors", spec.sensors),
        ("keyframes", spec.keys),
    ):
        names = [element.name or "unnamed" for element in elements]
        for element in list(elements):
            spec.delete(element)
        if names and kind not in ("sensors", "keyframes"):
            notes.append(f"taken out: {kind} {listed(names)}")


def take_springs_off(
    spec: mujoco.MjSpec, model: mujoco.MjModel, joints: list[str], notes: list[str]
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


def let_overlaps_pass(
    spec: mujoco.MjSpec, model: mujoco.MjModel, at_home: mujoco.MjData, notes: list[str]
) -> None:
    """Let neighbours that overlap at home pass through each other, and say what else touches.

    The base and the first link never collide, as MuJoCo has it of all other parents and children.

    Args:
        spec: of the robot, changed.
        model: of the file.
        at_home: its state at home.
        notes: get a line of either.
    """
    found: dict[tuple[str, ...], tuple[int, float, str]] = {}
    for first, second, depth in contacts(model, at_home):
        bodies = tuple(model.body(max(0, model.geom_bodyid[geom])).name for geom in (first, second))
        away, deepest, _ = found.get(bodies, (0, 0.0, ""))
        names = f"{called(model, first)} and {called(model, second)}"
        found[bodies] = (max(away, distance(model, first, second)), max(deepest, depth), names)
    near = {bodies for bodies, (away, _, _) in found.items() if away < FAR}
    for pair in near | _base_and_first_links(model):
        spec.add_exclude(bodyname1=pair[0], bodyname2=pair[1])
    passing = [names for away, _, names in found.values() if away < FAR]
    others = [
        f"{names} ({1e3 * depth:.3g} mm deep)"
        for away, depth, names in found.values()
        if away == FAR
    ]
    if passing:
        notes.append(f"neighbours that overlap at home do not collide: {listed(passing)}")
    if others:
        notes.append(
            Note(
                f"in contact at home: {listed(others)}",
                "; give a robot.home without, or robot.contacts = false lets all bodies pass",
            )
        )


def _base_and_first_links(model: mujoco.MjModel) -> set[tuple[str, ...]]:
    """Each body of a base that does not move, with each link that moves on it."""
    weld, root, parent = model.body_weldid, model.body_rootid, model.body_parentid
    links = [b for b in range(1, model.nbody) if weld[b] == b and weld[parent[b]] == 0]
    return {
        (model.body(base).name, model.body(link).name)
        for link in links
        for base in range(1, link)
        if weld[base] == 0 and root[base] == root[link]
    }


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
