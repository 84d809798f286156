"""An author's MJCF becomes an arm: a tool, the joints that move it, and a torque motor on each.

The file is never changed: what the law cannot use is changed or taken out on a copy in memory, and
each such change is listed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from .. import library
from ..errors import RobotError
from . import chain, clearing, menagerie, motors, names, poses
from .compiling import compile_spec, rejected
from .tool import find_tool

TOOL_SITE = "resonance_mj_tool"
"""The site that is added where the tool is a body."""


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
    # MuJoCo takes a mesh from memory if its file has the same time, which counts whole seconds.
    mujoco.mj_clearCache(mujoco.mj_getCache())
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise RobotError(rejected(path, error)) from None
    # Bodies that are fused would lose their names, and the others their numbers; a payload's body
    # must not be made one with the tool's.
    spec.compiler.fusestatic = False
    names.name_all(spec.joints, "joint")
    names.name_all(spec.bodies, "body")
    model = compile_spec(spec, path)
    notes: list[str] = []
    kind, name = find_tool(model, tool, path, notes)
    body = int(model.site(name).bodyid[0]) if kind == "site" else int(model.body(name).id)
    joint_ids = chain.joints_to(model, body)
    if not joint_ids:
        raise RobotError(f"{path}: no joint moves the tool {name!r}")
    chain.check(model, joint_ids, path, f"the tool {name!r}")
    if kind == "body":
        poses.set_pose(spec.body(name).add_site(name=TOOL_SITE), np.zeros(3), poses.IDENTITY)
        name = TOOL_SITE
    at_home, has_key = _at_home(model, home, path)
    joints = tuple(model.joint(j).name for j in joint_ids)
    limits = [motors.torque_limit(model, j) for j in joint_ids]
    motors.keep_rotors(spec, model, joint_ids)
    clearing.take_out(spec, notes)
    poses.hold_off_chain(spec, model, at_home, joint_ids, path, notes)
    clearing.take_springs_off(spec, joints, notes)
    clearing.passive_gravity(spec, notes)
    clearing.switch_on(spec, notes)
    for joint, limit in zip(joints, limits, strict=True):
        motors.add_motor(spec, joint, limit)
    return Arm(
        spec=spec,
        joints=joints,
        tool=name,
        home=at_home.qpos[model.jnt_qposadr[joint_ids]].copy() if has_key else None,
        notes=notes,
    )


def _at_home(model: mujoco.MjModel, name: str | None, path: Path) -> tuple[mujoco.MjData, bool]:
    """The whole model at home, and whether a keyframe says so."""
    keys = [model.key(i).name for i in range(model.nkey)]
    data = mujoco.MjData(model)
    if name is None:
        # An arm that is attached to a scene brings its keyframe with a prefix.
        prefixed = [key for key in keys if key.endswith("home")]
        name = "home" if "home" in keys else prefixed[0] if len(prefixed) == 1 else None
    elif name not in keys:
        raise RobotError(
            f"{path}: robot.home = {name!r}: no such keyframe; its keyframes are: "
            f"{names.listed(keys)}. Or give the joint angles as a list"
        )
    if name is not None:
        mujoco.mj_resetDataKeyframe(model, data, keys.index(name))
    mujoco.mj_kinematics(model, data)
    return data, name is not None
