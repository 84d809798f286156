"""An author's MJCF becomes an arm: a tool, the joints that move it, and a torque motor on each.

The file is never changed: what the law cannot use is changed or taken out on a copy in memory, and
each such change is listed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from . import library, menagerie
from .errors import RobotError

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
    for number, joint in enumerate(spec.joints):
        joint.name = joint.name or f"unnamed_joint{number + 1}"
    model = compile_spec(spec, path)
    notes: list[str] = []
    kind, name = _tool(model, tool, path, notes)
    body = int(model.site(name).bodyid[0]) if kind == "site" else int(model.body(name).id)
    chain = _chain(model, body)
    _check_chain(model, chain, name, path)
    if kind == "body":
        spec.body(name).add_site(name=TOOL_SITE)
        name = TOOL_SITE
    qpos, has_key = _keyframe(model, home, path)
    joints = tuple(model.joint(j).name for j in chain)
    limits = {joint: _torque_limit(model, j) for joint, j in zip(joints, chain, strict=True)}
    _take_out(spec, notes)
    _hold_off_chain(spec, model, qpos, chain, notes)
    _linear_springs(spec, joints, notes)
    for joint in joints:
        _add_motor(spec, joint, limits[joint])
    return Arm(
        spec=spec,
        joints=joints,
        tool=name,
        home=qpos[model.jnt_qposadr[chain]].copy() if has_key else None,
        notes=notes,
    )


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
    lengths = [_arm_length(model, body) for body in range(model.nbody)]
    longest = max(lengths)
    if longest == 0:
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
    best = max(sorted(at_end), key=lambda body: (bool(model.body(body).name), depth[body]))
    if not model.body(best).name:
        raise RobotError(f"{path}: the arm's last body has no name; name it, or a site on it")
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


def _check_chain(model: mujoco.MjModel, chain: list[int], tool: str, path: Path) -> None:
    if not chain:
        raise RobotError(f"{path}: no joint moves the tool {tool!r}")
    for j in chain:
        if not _carries_spring(model, j):
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            raise RobotError(
                f"{path}: joint {model.joint(j).name!r} between the world and the tool {tool!r} is "
                f"a {kind} joint; only hinge and slide joints can carry a spring"
            )


def _keyframe(model: mujoco.MjModel, name: str | None, path: Path) -> tuple[np.ndarray, bool]:
    """The whole model's qpos at home, and whether a keyframe says so."""
    key = mujoco.mj_name2id(model, _OBJ.mjOBJ_KEY, name or "home")
    if key >= 0:
        return model.key_qpos[key].copy(), True
    if name is not None:
        names = [model.key(i).name for i in range(model.nkey)]
        raise RobotError(
            f"{path}: robot.home = {name!r}: no such keyframe; its keyframes are: "
            f"{_listed(names)}. Or give the joint angles as a list"
        )
    return model.qpos0.copy(), False


def _torque_limit(model: mujoco.MjModel, joint: int) -> tuple[float, float] | None:
    """Least and greatest torque that the actuators can put on a joint; None without limit."""
    low, high, found = 0.0, 0.0, False
    for a in range(model.nu):
        on_joint = int(model.actuator_trntype[a]) in (
            mujoco.mjtTrn.mjTRN_JOINT,
            mujoco.mjtTrn.mjTRN_JOINTINPARENT,
        )
        if not on_joint or model.actuator_trnid[a, 0] != joint:
            continue
        gear, gain = model.actuator_gear[a, 0], model.actuator_gainprm[a, 0]
        if model.actuator_forcelimited[a]:
            ends = gear * model.actuator_forcerange[a]
        elif (
            model.actuator_ctrllimited[a]
            and model.actuator_biastype[a] == mujoco.mjtBias.mjBIAS_NONE
            and model.actuator_gaintype[a] == mujoco.mjtGain.mjGAIN_FIXED
        ):
            ends = gear * gain * model.actuator_ctrlrange[a]
        else:
            return None
        low, high, found = low + min(ends), high + max(ends), True
    return (float(low), float(high)) if found and low < high else None


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
    spec: mujoco.MjSpec, model: mujoco.MjModel, qpos: np.ndarray, chain: list[int], notes: list[str]
) -> None:
    """Fix the joints that do not move the tool where the home pose has them."""
    off = [j for j in range(model.njnt) if j not in chain]
    if not off:
        return
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    names = [model.joint(j).name for j in off]
    for body in sorted({int(model.jnt_bodyid[j]) for j in off}):
        held = spec.bodies[body]
        parent = int(model.body_parentid[body])
        rotation = data.xmat[parent].reshape(3, 3)
        held.pos = rotation.T @ (data.xpos[body] - data.xpos[parent])
        inverse, quat = np.empty(4), np.empty(4)
        mujoco.mju_negQuat(inverse, data.xquat[parent])
        mujoco.mju_mulQuat(quat, inverse, data.xquat[body])
        held.quat = quat
        held.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    for name in names:
        spec.delete(spec.joint(name))
    notes.append(f"held where the home pose has them: joints {_listed(names)}")


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


def _add_motor(spec: mujoco.MjSpec, joint: str, limit: tuple[float, float] | None) -> None:
    motor = spec.add_actuator(name=f"motor_{joint}", target=joint)
    motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
    motor.set_to_motor()
    if limit is not None:
        motor.ctrlrange = list(limit)
        motor.ctrllimited = True


def _listed(names: list[str]) -> str:
    return ", ".join(filter(None, names)) or "none with a name"
