"""An author's MJCF becomes an arm: a tool, the joints that move it, and a torque motor on each.

The file is never changed: what the law cannot use is changed or taken out on a copy in memory, and
each such change is listed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from .. import library
from ..errors import RobotError
from . import menagerie

USUAL_TOOLS = (
    "attachment_site",
    "tool",
    "tcp",
    "grip_site",
    "grasp_site",
    "ee",
    "eef",
    "ee_site",
    "end_effector",
    "right_center",
    "right_hand",
    "hand",
    "pinch",
)
"""Names that authors give to the point that works, the likeliest first."""

FINGER_JOINTS = 3
"""Most joints of a gripper's finger."""

UNNAMED = "unnamed_"
"""What the names of joints and bodies begin with that have none in the file."""

BOUNDED = (
    mujoco.mjtDyn.mjDYN_NONE,
    mujoco.mjtDyn.mjDYN_FILTER,
    mujoco.mjtDyn.mjDYN_FILTEREXACT,
)
"""Actuator dynamics whose output stays within the limits of the control."""

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
"""The quaternion of no rotation."""

NO_LIMIT = (-np.inf, np.inf)
"""The ends of a torque that nothing limits [N m]."""

TOOL_SITE = "resonance_mj_tool"
"""The site that is added where the tool is a body."""

_OBJ = mujoco.mjtObj


@dataclass
class Arm:
    """An arm found in an MJCF.

    Attributes:
        spec: an editable copy of the file's model with motors and without what moves off the arm.
        joints: names of the joints from the world to the tool.
        tool: name of the site that follows the motion.
        home: joint angles of the file's keyframe, or None [rad] (n,).
        notes: what was chosen and what was changed, a line each.
    """

    spec: mujoco.MjSpec
    joints: tuple[str, ...]
    tool: str
    home: np.ndarray | None
    notes: list[str] = field(default_factory=list)


def find(mjcf: str) -> Path:
    """The MJCF file that a path or a built-in name means.

    Raises:
        RobotError: there is no such file.
    """
    if mjcf.startswith(menagerie.PREFIX):
        return menagerie.find(mjcf)
    path = Path(mjcf)
    if path.is_file():
        return path
    built_in = library.robots()
    if mjcf in built_in:
        return built_in[mjcf]
    raise RobotError(
        f"robot.mjcf = {mjcf!r}: no such file; give the path of an MJCF file or one of "
        f"{', '.join(built_in)}"
    )


def compile_spec(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    """Compile, with MuJoCo's own message and the file in the error.

    Raises:
        RobotError: MuJoCo rejects the model.
    """
    try:
        return spec.compile()
    except ValueError as error:
        raise RobotError(_rejected(path, error)) from None


def read(mjcf: str, tool: str | None, home: str | None) -> Arm:
    """Find the arm in an MJCF file and make it one that the law can drive.

    Args:
        mjcf: path, or name in mjcf/.
        tool: name of a site or body; None to find it.
        home: name of a keyframe; None for `home` if there is one.

    Raises:
        RobotError: the file is missing, MuJoCo rejects it, or it holds no arm that can be driven;
            the message names the file and the element.
    """
    path = find(mjcf)
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise RobotError(_rejected(path, error)) from None
    # Bodies that are fused would lose their names, and the others their numbers.
    spec.compiler.fusestatic = False
    _name(spec.joints, "joint")
    _name(spec.bodies, "body")
    model = compile_spec(spec, path)
    notes: list[str] = []
    kind, name = _tool(model, tool, path, notes)
    body = int(model.site(name).bodyid[0]) if kind == "site" else int(model.body(name).id)
    chain = _chain(model, body)
    if not chain:
        raise RobotError(f"{path}: no joint moves the tool {name!r}")
    _check_chain(model, chain, path, f"the tool {name!r}")
    if kind == "body":
        _set_pose(spec.body(name).add_site(name=TOOL_SITE), np.zeros(3), IDENTITY)
        name = TOOL_SITE
    at_home, has_key = _at_home(model, home, path)
    joints = tuple(model.joint(j).name for j in chain)
    limits = {joint: _torque_limit(model, j) for joint, j in zip(joints, chain, strict=True)}
    _keep_rotors(spec, model, chain)
    _take_out(spec, notes)
    _hold_off_chain(spec, model, at_home, chain, path, notes)
    _linear_springs(spec, joints, notes)
    _passive_gravity(spec, notes)
    _switch_on(spec, notes)
    for joint in joints:
        _add_motor(spec, joint, limits[joint])
    return Arm(
        spec=spec,
        joints=joints,
        tool=name,
        home=at_home.qpos[model.jnt_qposadr[chain]].copy() if has_key else None,
        notes=notes,
    )


def _name(elements: list[Any], kind: str) -> None:
    """Give a name to each element that has none."""
    taken = {element.name for element in elements}
    for number, element in enumerate(elements, 1):
        name = element.name or f"{UNNAMED}{kind}{number}"
        while not element.name and name in taken:
            name += "_"
        taken.add(name)
        element.name = name


def _rejected(path: Path, error: ValueError) -> str:
    return f"{path}: MuJoCo rejects it: {' '.join(str(error).split())}"


def _chain(model: mujoco.MjModel, body: int) -> list[int]:
    """Ids of the joints from the world to a body."""
    joints: list[int] = []
    while body > 0:
        first = int(model.body_jntadr[body])
        joints[:0] = range(first, first + int(model.body_jntnum[body]))
        body = int(model.body_parentid[body])
    return joints


def _tool(
    model: mujoco.MjModel, given: str | None, path: Path, notes: list[str]
) -> tuple[str, str]:
    """Whether the tool is a site or a body, and its name."""
    sites = [model.site(i).name for i in range(model.nsite)]
    bodies = [model.body(i).name for i in range(1, model.nbody)]
    if given is not None:
        if given in sites:
            return "site", given
        if given in bodies:
            return "body", given
        raise RobotError(
            f"{path}: robot.tool = {given!r}: no such site or body; its sites are: "
            f"{_listed(sites)}; its bodies: {_listed(bodies)}"
        )
    cloth = set(model.flex_vertbodyid.tolist())
    lengths = [_arm_length(model, body) * (body not in cloth) for body in range(model.nbody)]
    longest = max(lengths)
    if longest == 0:
        for j in range(model.njnt):
            if _carries_spring(model, j):
                _check_chain(model, _chain(model, int(model.jnt_bodyid[j])), path)
        raise RobotError(
            f"{path}: no hinge or slide joint moves anything in it; an arm needs at least one"
        )
    # A usual name on the base or on another arm is not the tool: it must be moved by all joints of
    # the arm, which are those of the longest chain without a gripper's.
    longest -= _fingers(model, lengths.index(longest))
    at_end = {body for body in range(model.nbody) if lengths[body] == longest}
    for name in USUAL_TOOLS:
        if name in sites and int(model.site(name).bodyid[0]) in at_end:
            notes.append(f"tool: site {name!r}, found by its usual name")
            return "site", name
        if name in bodies and int(model.body(name).id) in at_end:
            notes.append(f"tool: body {name!r}, found by its usual name")
            return "body", name
    depth = [_depth(model, body) for body in range(model.nbody)]
    best = max(
        sorted(at_end),
        key=lambda body: (not model.body(body).name.startswith(UNNAMED), depth[body]),
    )
    notes.append(
        f"tool: body {model.body(best).name!r}, the deepest of the longest chain of joints"
    )
    return "body", model.body(best).name


def _fingers(model: mujoco.MjModel, tip: int) -> int:
    """How many of the joints that move `tip` are a finger's, past a body where several spread.

    Two arms on a torso spread as well, but with more joints than a finger has.
    """
    moved = {int(model.jnt_bodyid[j]) for j in range(model.njnt)}
    joints, body, found = 0, tip, 0
    while body > 0 and joints <= FINGER_JOINTS:
        joints += int(model.body_jntnum[body])
        body = int(model.body_parentid[body])
        branches = {_child_towards(model, body, other) for other in moved} - {-1}
        if body > 0 and len(branches) > 1 and 0 < joints <= FINGER_JOINTS and _chain(model, body):
            found = joints
    return found


def _child_towards(model: mujoco.MjModel, ancestor: int, body: int) -> int:
    """The child of `ancestor` through which `body` hangs on it, or -1."""
    while body > 0:
        parent = int(model.body_parentid[body])
        if parent == ancestor:
            return body
        body = parent
    return -1


def _arm_length(model: mujoco.MjModel, body: int) -> int:
    """Number of joints that move a body, 0 if one of them can carry no spring."""
    chain = _chain(model, body)
    return 0 if any(not _carries_spring(model, j) for j in chain) else len(chain)


def _depth(model: mujoco.MjModel, body: int) -> int:
    return 0 if body == 0 else 1 + _depth(model, int(model.body_parentid[body]))


def _carries_spring(model: mujoco.MjModel, joint: int) -> bool:
    return int(model.jnt_type[joint]) in (
        mujoco.mjtJoint.mjJNT_HINGE,
        mujoco.mjtJoint.mjJNT_SLIDE,
    )


def _check_chain(
    model: mujoco.MjModel, chain: list[int], path: Path, tool: str = "the arm's end"
) -> None:
    for j in chain:
        if not _carries_spring(model, j):
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            raise RobotError(
                f"{path}: joint {model.joint(j).name!r} between the world and {tool} is "
                f"a {kind} joint; only hinge and slide joints can carry a spring"
            )


def _at_home(model: mujoco.MjModel, name: str | None, path: Path) -> tuple[mujoco.MjData, bool]:
    """The whole model at home, and whether a keyframe says so."""
    names = [model.key(i).name for i in range(model.nkey)]
    data = mujoco.MjData(model)
    if name is None:
        # An arm that is attached to a scene brings its keyframe with a prefix.
        prefixed = [key for key in names if key.endswith("home")]
        name = "home" if "home" in names else prefixed[0] if len(prefixed) == 1 else None
    elif name not in names:
        raise RobotError(
            f"{path}: robot.home = {name!r}: no such keyframe; its keyframes are: "
            f"{_listed(names)}. Or give the joint angles as a list"
        )
    if name is not None:
        mujoco.mj_resetDataKeyframe(model, data, names.index(name))
    mujoco.mj_kinematics(model, data)
    return data, name is not None


def _acting_on(model: mujoco.MjModel, joint: int) -> list[int]:
    """Ids of the actuators on a joint."""
    return [
        a
        for a in range(model.nu)
        if model.actuator_trnid[a, 0] == joint
        and int(model.actuator_trntype[a])
        in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    ]


def _torque_limit(model: mujoco.MjModel, joint: int) -> tuple[float, float] | None:
    """Least and greatest torque that the actuators can put on a joint; None without limit."""
    acting = _acting_on(model, joint)
    low, high = np.sum([_actuator_limit(model, a) for a in acting] or [NO_LIMIT], axis=0)
    if model.jnt_actfrclimited[joint]:
        low = max(low, model.jnt_actfrcrange[joint, 0])
        high = min(high, model.jnt_actfrcrange[joint, 1])
    return (float(low), float(high)) if np.isfinite([low, high]).all() and low < high else None


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


def _keep_rotors(spec: mujoco.MjSpec, model: mujoco.MjModel, chain: list[int]) -> None:
    """Leave to each joint the inertia and the damping of the actuators that are replaced."""
    for j in chain:
        joint = spec.joint(model.joint(j).name)
        for a in _acting_on(model, j):
            gear = model.actuator_gear[a, 0]
            damping = [model.actuator_damping[a], *model.actuator_dampingpoly[a]]
            joint.armature += gear**2 * model.actuator_armature[a]
            joint.damping = joint.damping + gear**2 * np.array(damping)


def _take_out(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Delete what acts on joints besides the law, or refers to what is deleted."""
    for kind, elements in (
        ("actuators", spec.actuators),
        ("tendons", spec.tendons),
        ("equality constraints", spec.equalities),
        ("sensors", spec.sensors),
        ("keyframes", spec.keys),
    ):
        names = [
            element.name or "unnamed"
            for element in elements
            if kind != "actuators" or not _is_torque_motor(element)
        ]
        for element in list(elements):
            spec.delete(element)
        if names and kind == "actuators":
            notes.append(f"replaced by torque motors, limits kept: actuators {_listed(names)}")
        elif names and kind not in ("sensors", "keyframes"):
            notes.append(f"taken out: {kind} {_listed(names)}")


def _is_torque_motor(actuator: mujoco.MjsActuator) -> bool:
    """Whether an actuator of the file does what the motor does that takes its place."""
    return bool(
        actuator.trntype == mujoco.mjtTrn.mjTRN_JOINT
        and actuator.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        and actuator.biastype == mujoco.mjtBias.mjBIAS_NONE
        and actuator.dyntype == mujoco.mjtDyn.mjDYN_NONE
        and actuator.gainprm[0] == 1.0
        and actuator.gear[0] == 1.0
    )


def _hold_off_chain(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    at_home: mujoco.MjData,
    chain: list[int],
    path: Path,
    notes: list[str],
) -> None:
    """Fix the joints that do not move the tool, and mocap bodies, where the home pose has them."""
    off = [j for j in range(model.njnt) if j not in chain]
    mocap = np.flatnonzero(model.body_mocapid >= 0)
    _place(spec, model, at_home, sorted({*model.jnt_bodyid[off].tolist(), *mocap.tolist()}), path)
    names = [model.joint(j).name for j in off]
    for name in names:
        spec.delete(spec.joint(name))
    if names:
        notes.append(f"held where the home pose has them: joints {_listed(names)}")


def _place(
    spec: mujoco.MjSpec, model: mujoco.MjModel, data: mujoco.MjData, bodies: list[int], path: Path
) -> None:
    """Write the poses that bodies have in `data`, relative to their parents, into the spec."""
    for body in bodies:
        parent = int(model.body_parentid[body])
        _set_pose(
            spec.bodies[body],
            *_relative(data.xpos[parent], data.xquat[parent], data.xpos[body], data.xquat[body]),
        )
    framed = [body for body in bodies if spec.bodies[body].frame is not None]
    if not framed:
        return
    # MuJoCo puts the pose of a <frame> before that of a body in it; a body without a pose shows it.
    poses = {body: (spec.bodies[body].pos.copy(), spec.bodies[body].quat.copy()) for body in framed}
    for body in framed:
        _set_pose(spec.bodies[body], np.zeros(3), IDENTITY)
    bare = compile_spec(spec, path)
    for body, (pos, quat) in poses.items():
        within = _relative(bare.body_pos[body], bare.body_quat[body], pos, quat)
        _set_pose(spec.bodies[body], *within)


def _relative(
    pos: np.ndarray, quat: np.ndarray, of_pos: np.ndarray, of_quat: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The pose (of_pos, of_quat) as seen from the pose (pos, quat)."""
    inverse, seen_pos, seen_quat = np.empty(4), np.empty(3), np.empty(4)
    mujoco.mju_negQuat(inverse, quat)
    mujoco.mju_rotVecQuat(seen_pos, of_pos - pos, inverse)
    mujoco.mju_mulQuat(seen_quat, inverse, of_quat)
    return seen_pos, seen_quat


def _set_pose(element: Any, pos: np.ndarray, quat: np.ndarray) -> None:
    element.pos, element.quat = pos, quat
    element.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _linear_springs(spec: mujoco.MjSpec, joints: tuple[str, ...], notes: list[str]) -> None:
    """Take the file's own springs off the arm's joints: the law puts its own there."""
    taken = []
    for name in joints:
        joint = spec.joint(name)
        if np.any(joint.stiffness) or joint.springyield > 0 or np.any(joint.springdamper):
            taken.append(name)
        joint.stiffness = [0.0, 0.0, 0.0]
        joint.springyield = 0.0
        joint.springdamper = [0.0, 0.0]
    if taken:
        notes.append(f"taken off, the law puts its own there: springs of {_listed(taken)}")


def _passive_gravity(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Leave gravity compensation outside the motors, whose torque is the law's alone."""
    for joint in spec.joints:
        joint.actgravcomp = False
    names = [body.name for body in spec.bodies if body.gravcomp]
    if names:
        notes.append(f"the file takes weight off besides the motors (gravcomp): {_listed(names)}")


def _switch_on(spec: mujoco.MjSpec, notes: list[str]) -> None:
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
        notes.append(f"switched on, the law needs them: {_listed(names)}")


def _add_motor(spec: mujoco.MjSpec, joint: str, limit: tuple[float, float] | None) -> None:
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


def _listed(names: list[str]) -> str:
    return ", ".join(filter(None, names)) or "none with a name"
