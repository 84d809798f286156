"""Motors behind gears that give way: a rotor of its own for each joint, a stiff spring between.

A rotor is a body without weight that turns, or slides, as its joint does; the spring is a fixed
tendon whose length is the angle of the rotor less the joint's, slack where the gear has play.
"""

from __future__ import annotations

import mujoco
import numpy as np

from ..errors import ExperimentError
from ..experiments.experiment import Experiment
from ..experiments.reality_section import Reality
from . import names

DAMPED = 0.01
"""Damping ratio of a rotor against its joint. MuJoCo's Euler takes a tendon's damping d for that of
each of its joints alone, where it acts as an inertia of d dt: the ratio is small, so that it is."""

FASTEST = 1.0
"""Most that the swing of a rotor against its joint is of 1/dt [rad]."""

NOTHING = 1e-9
"""Mass of a rotor's body, whose inertia is all in its joint's armature [kg]."""


def add(spec: mujoco.MjSpec, joints: tuple[str, ...], reality: Reality) -> dict[str, str]:
    """Put a rotor beside each joint, which its motor turns; stiffness comes with `tighten`.

    Args:
        spec: of the robot, with a motor on each joint; it has no more tendons after these.
        joints: names of the arm's joints.
        reality: says what gears do.

    Returns:
        Names of the rotors' joints, by the arm's; empty for gears that do not give way.
    """
    if reality.joint_stiffness is None:
        return {}
    found = {}
    for joint in joints:
        own = spec.joint(joint)
        name = names.free(
            f"rotor_{joint}", lambda one: spec.joint(one) or spec.body(one) or spec.tendon(one)
        )
        body = spec.worldbody.add_body(name=name)
        body.explicitinertial, body.mass, body.inertia = True, NOTHING, [NOTHING] * 3
        rotor = body.add_joint(name=name, type=own.type, axis=[0.0, 0.0, 1.0])
        rotor.limited, rotor.stiffness, rotor.damping = False, [0.0] * 3, [0.0] * 3
        rotor.frictionloss, rotor.ref = 0.0, 0.0
        rotor.armature, own.armature = own.armature, 0.0
        spec.actuator(f"motor_{joint}").target = name
        tendon = spec.add_tendon(name=name)
        tendon.wrap_joint(name, 1.0)
        tendon.wrap_joint(joint, -1.0)
        found[joint] = name
    return found


def tighten(
    model: mujoco.MjModel, rotors: dict[str, str], inertia: np.ndarray, experiment: Experiment
) -> np.ndarray:
    """Give the rotors of a model their inertia, and the springs stiffness, play and damping.

    Args:
        model: compiled of what `add` has changed.
        rotors: that `add` has returned.
        inertia: of the arm's joints with what of the rotors is in the file, at home (n, n) [kg m²].
        experiment: says how stiff they are.

    Returns:
        The inertia with that of the rotors.

    Raises:
        ExperimentError: a rotor has no inertia, or swings too fast for the time step.
    """
    if not rotors:
        return inertia
    reality, dt = experiment.reality, experiment.simulation.timestep
    dofs = [int(model.jnt_dofadr[model.joint(rotor).id]) for rotor in rotors.values()]
    links = inertia - np.diag(model.dof_armature[dofs] + NOTHING)
    n, alone = len(rotors), 1 / np.diag(np.linalg.inv(links))
    stiffness = np.broadcast_to(np.asarray(reality.joint_stiffness, float), n)
    given = reality.rotor_inertia
    where = f"experiment {experiment.name!r}: reality"
    for j, (joint, rotor) in enumerate(rotors.items()):
        dof = dofs[j]
        if given is not None:
            model.dof_armature[dof] = np.broadcast_to(np.asarray(given, float), n)[j]
        turned = float(model.dof_armature[dof])
        if not turned > 0.0:
            raise ExperimentError(
                f"{where}.rotor_inertia: {joint} has no armature in its file; give the inertia of "
                "the motors as the joints feel it, in kg m²"
            )
        between = turned * alone[j] / (turned + alone[j])
        if stiffness[j] * dt**2 > FASTEST**2 * between:
            raise ExperimentError(
                f"{where}.joint_stiffness = {stiffness[j]:g}: the rotor of {joint} swings too fast "
                f"for simulation.timestep = {dt:g} s; at most {FASTEST**2 * between / dt**2:.3g} "
                f"N m/rad, or a time step of {np.sqrt(between / stiffness[j]) * FASTEST:.2g} s"
            )
        tendon = model.tendon(rotor).id
        model.tendon_stiffness[tendon] = stiffness[j]
        model.tendon_damping[tendon] = 2 * DAMPED * np.sqrt(stiffness[j] * between)
        model.tendon_lengthspring[tendon] = np.array([-0.5, 0.5]) * reality.backlash
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return np.asarray(links + np.diag(model.dof_armature[dofs] + NOTHING))
