"""A torque motor on each joint; the limits and rotors of the file's actuators are kept."""

import mujoco
import numpy as np

from ..errors import ExperimentError
from ..experiments.experiment import Experiment
from ..experiments.reality_section import Reality
from ..text import Note, listed, shown

BOUNDED = (
    mujoco.mjtDyn.mjDYN_NONE,
    mujoco.mjtDyn.mjDYN_FILTER,
    mujoco.mjtDyn.mjDYN_FILTEREXACT,
)
"""Actuator dynamics whose output stays within the limits of the control."""

NO_LIMIT = (-np.inf, np.inf)
"""The ends of a torque that nothing limits [N m]."""


def torque_limit(
    model: mujoco.MjModel, moved: list[tuple[int, float]]
) -> tuple[float, float] | None:
    """Least and greatest torque that the actuators can put on a joint; None without limit.

    Args:
        model: of the file.
        moved: the joint's id and 1, and of joints that follow it their ids and how fast they turn.
    """
    given: list[list[float]] = [
        sorted(speed * end for end in _joint_limit(model, j))
        for j, speed in moved
        if _acting_on(model, j) or model.jnt_actfrclimited[j]
    ]
    low, high = np.sum(given or [list(_joint_limit(model, moved[0][0]))], axis=0)
    return (float(low), float(high)) if np.isfinite([low, high]).all() and low < high else None


def _joint_limit(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    """Least and greatest torque of the actuators on one joint."""
    acting = _acting_on(model, joint)
    low, high = np.sum([_actuator_limit(model, a) for a in acting] or [NO_LIMIT], axis=0)
    if model.jnt_actfrclimited[joint]:
        low = max(low, model.jnt_actfrcrange[joint, 0])
        high = min(high, model.jnt_actfrcrange[joint, 1])
    return low, high


def _acting_on(model: mujoco.MjModel, joint: int) -> list[int]:
    """Ids of the actuators on a joint."""
    return [
        a
        for a in range(model.nu)
        if model.actuator_trnid[a, 0] == joint
        and int(model.actuator_trntype[a])
        in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    ]


def _actuator_limit(model: mujoco.MjModel, a: int) -> tuple[float, float]:
    """Least and greatest torque of an actuator at its joint."""
    gear, gain = model.actuator_gear[a, 0], model.actuator_gainprm[a, 0]
    low, high = NO_LIMIT
    if (
        model.actuator_ctrllimited[a]
        and int(model.actuator_dyntype[a]) in BOUNDED
        and model.actuator_biastype[a] == mujoco.mjtBias.mjBIAS_NONE
        and model.actuator_gaintype[a] == mujoco.mjtGain.mjGAIN_FIXED
    ):
        low, high = sorted(gain * model.actuator_ctrlrange[a])
    if model.actuator_forcelimited[a]:
        low = max(low, model.actuator_forcerange[a, 0])
        high = min(high, model.actuator_forcerange[a, 1])
    ends = sorted((gear * low, gear * high)) if gear else [0.0, 0.0]
    return ends[0], ends[1]


def replace(spec: mujoco.MjSpec, model: mujoco.MjModel, chain: list[int], notes: list[str]) -> None:
    """Take the file's actuators out, and say what becomes of each; `add_motor` puts ours there."""
    ours = {a for j in chain for a in _acting_on(model, j)}
    kept, without, gone = [], [], []
    for a, actuator in enumerate(list(spec.actuators)):
        muscle = int(model.actuator_gaintype[a]) == int(mujoco.mjtGain.mjGAIN_MUSCLE)
        through = int(model.actuator_trntype[a]) == int(mujoco.mjtTrn.mjTRN_TENDON)
        name = actuator.name or f"that of {actuator.target}"
        if muscle or through:
            without.append(f"{name} (a {'muscle' if muscle else 'tendon'})")
        elif a not in ours:
            gone.append(name)
        elif not is_torque_motor(actuator):
            kept.append(name)
        spec.delete(actuator)
    for what, names in (
        ("replaced by torque motors, limits kept: actuators", kept),
        ("replaced by torque motors without limits, which these do not have at joints:", without),
        ("taken out, they turn no joint of the arm: actuators", gone),
    ):
        if names:
            notes.append(f"{what} {listed(names)}")
    for j in chain:
        low, high = torque_limit(model, [(j, 1.0)]) or NO_LIMIT
        if low >= 0 or high <= 0:
            notes.append(
                Note(
                    f"the motor of {model.joint(j).name} gives {low:g} to {high:g} N m",
                    ": it can turn the joint one way only",
                )
            )


def keep_rotors(spec: mujoco.MjSpec, model: mujoco.MjModel, chain: list[int]) -> None:
    """Leave to each joint the inertia and the damping of the actuators that are replaced."""
    for j in chain:
        joint = spec.joint(model.joint(j).name)
        for a in _acting_on(model, j):
            gear = model.actuator_gear[a, 0]
            damping = [model.actuator_damping[a], *model.actuator_dampingpoly[a]]
            joint.armature += gear**2 * model.actuator_armature[a]
            joint.damping = joint.damping + gear**2 * np.array(damping)


def is_torque_motor(actuator: mujoco.MjsActuator) -> bool:
    """Whether an actuator of the file does what the motor does that takes its place."""
    return bool(
        actuator.trntype == mujoco.mjtTrn.mjTRN_JOINT
        and actuator.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        and actuator.biastype == mujoco.mjtBias.mjBIAS_NONE
        and actuator.dyntype == mujoco.mjtDyn.mjDYN_NONE
        and actuator.gainprm[0] == 1.0
        and actuator.gear[0] == 1.0
    )


def add_motor(spec: mujoco.MjSpec, joint: str, limit: tuple[float, float] | None) -> None:
    """Put a torque motor on a joint, with a least and a greatest torque [N m] or without."""
    # All that a file's default class could set otherwise is written out.
    motor = spec.add_actuator(
        name=f"motor_{joint}",
        target=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gear=[1, 0, 0, 0, 0, 0],
        ctrllimited=limit is not None,
        ctrlrange=list(limit or (0.0, 0.0)),
        forcelimited=False,
        forcerange=[0.0, 0.0],
        actlimited=False,
        actrange=[0.0, 0.0],
        actdim=-1,
        damping=[0.0, 0.0, 0.0],
        armature=0.0,
        inheritrange=0.0,
        group=0,
        nsample=0,
        delay=0.0,
    )
    motor.set_to_motor()


def limits(model: mujoco.MjModel, actuator_id: np.ndarray, experiment: Experiment) -> np.ndarray:
    """Least and greatest torque of motors (n, 2) [N m], by the model and by what is allowed.

    Raises:
        ExperimentError: motors lose torque with speed and have no limit to lose it from.
    """
    most, speed = experiment.reality.motor_torque, experiment.reality.motor_speed
    limited = model.actuator_ctrllimited[actuator_id, None].astype(bool)
    limits = np.where(limited, model.actuator_ctrlrange[actuator_id], [-np.inf, np.inf])
    largest = np.broadcast_to(np.inf if most is None else np.asarray(most), len(limits))[:, None]
    found = np.clip(limits, -largest, largest)
    if speed is not None and not np.isfinite(found).all():
        raise ExperimentError(
            f"experiment {experiment.name!r}: reality.motor_speed = {shown(speed)}: motors lose "
            "torque with speed from a limit, which some have not: give reality.motor_torque"
        )
    return found


def limits_along(
    torque_limit: np.ndarray, reality: Reality, timestep: float, tau: np.ndarray, dq: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest torque of motors at each step of a cycle (N, n) [N m].

    Args:
        torque_limit: of each when it stands still (n, 2) [N m].
        reality: says how fast they are.
        timestep: [s].
        tau: what they gave (N, n) [N m].
        dq: joint velocities (N, n) [rad/s].
    """
    low, high = (np.broadcast_to(end, tau.shape) for end in torque_limit.T)
    if reality.motor_speed is not None:
        left = np.maximum(1.0 - np.abs(dq) / np.asarray(reality.motor_speed), 0.0)
        low, high = np.where(dq < 0, low * left, low), np.where(dq > 0, high * left, high)
    if reality.torque_rate is not None:
        step = np.asarray(reality.torque_rate) * timestep * (1 - 1e-9)
        before = np.vstack([tau[:1], tau[:-1]])
        low = np.where(np.arange(len(tau))[:, None] > 0, np.maximum(low, before - step), low)
        high = np.where(np.arange(len(tau))[:, None] > 0, np.minimum(high, before + step), high)
    return low, high
