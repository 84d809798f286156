"""An author's MJCF becomes an arm: a tool, the joints that move it, and a torque motor on each.

The file is never changed: what the law cannot use is changed or taken out on a copy in memory, and
each such change is listed. The arm is found in the model as its author wrote it, compiled once; the
edited copy is compiled by `robot.build`.
"""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from .. import library
from ..errors import RobotError
from ..experiments.sections import Robot
from ..files import is_file, is_folder
from ..text import listed, shown
from . import chain, clearing, closures, menagerie, motors, moving, names, poses, sound, source
from .compiling import compile_spec, parse
from .couplings import Followers
from .tool import Tool, find_tools, moved

TOOL_SITE = "resonance_mj_tool"
"""The site that is added where the tool is a body, with underscores behind it if it is taken."""


@dataclass
class Arm:
    """An arm found in an MJCF.

    Attributes:
        path: of the file.
        spec: an editable copy of the file's model with motors and without what moves off the arm.
        model: the file's model as it is, what is off the arm welded to it.
        at_home: its state, with the joints off the arm where they are held.
        joints: names of the joints from the world to the tool.
        joint_id: their ids in `model` (n,).
        followers: the joints that are coupled to them.
        tools: what could follow the motion, first what does.
        site: name of the site of `spec` that follows it.
        body: id in `model` of the body that carries it.
        point: where the site is in that body (3,) [m].
        home: joint angles of the file's keyframe, or None [rad] (n,).
        notes: what was chosen and what was changed, a line each.
    """

    path: Path
    spec: mujoco.MjSpec
    model: mujoco.MjModel
    at_home: mujoco.MjData
    joints: tuple[str, ...]
    joint_id: np.ndarray
    followers: Followers
    tools: tuple[Tool, ...]
    site: str
    body: int
    point: np.ndarray
    home: np.ndarray | None
    notes: list[str]

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """The tool's Jacobian (6, n) in the file's model at joint angles (n,) [m/rad, rad/rad]."""
        model, data = self.model, self.at_home
        self.pose(q)
        mujoco.mj_comPos(model, data)
        full = np.zeros((6, model.nv))
        at = data.xpos[self.body] + data.xmat[self.body].reshape(3, 3) @ self.point
        mujoco.mj_jac(model, data, full[:3], full[3:], at, self.body)
        return self.followers.borne(full)[:, model.jnt_dofadr[self.joint_id]]

    def pose(self, q: np.ndarray) -> None:
        """Bring the file's model to joint angles (n,) [rad]."""
        self.at_home.qpos[self.model.jnt_qposadr[self.joint_id]] = q
        self.followers.place(self.at_home.qpos)
        mujoco.mj_kinematics(self.model, self.at_home)


def find(mjcf: str) -> Path:
    """The MJCF file that a built-in name or a path means; a name means the same in every folder.

    Raises:
        RobotError: there is no such file.
    """
    if mjcf.startswith(menagerie.PREFIX):
        return menagerie.find(mjcf)
    built_in = library.robots()
    if mjcf in built_in:
        return built_in[mjcf]
    if is_file(mjcf):
        return Path(mjcf)
    if mjcf and is_folder(mjcf) and (inside := source.robots_in(Path(mjcf))):
        if len(inside) == 1:
            return inside[0]
        raise RobotError(
            f"robot.mjcf = {shown(mjcf)}: a folder with several robots; give one of "
            f"{listed(map(str, inside))}"
        )
    raise RobotError(
        f"robot.mjcf = {shown(mjcf)}: no such file; give the path of an MJCF file or one of "
        f"{listed(built_in)}"
    )


def read(given: Robot) -> Arm:
    """Find the arm in an MJCF file and make it one that the law can drive.

    Args:
        given: what the experiment says of the robot.

    Raises:
        RobotError: the file is missing, MuJoCo rejects it, or it holds no arm that can be driven;
            the message names the file and the element.
    """
    path = find(given.mjcf)
    # MuJoCo takes a mesh from memory if its file has the same time, which counts whole seconds.
    mujoco.mj_clearCache(mujoco.mj_getCache())
    # Read twice: to find the arm takes none of the meshes that are only seen, and to edit a spec
    # that has been compiled copies all of them each time.
    notes: list[str] = []
    model = compile_spec(parse(path, given.packages, visuals=False), path)
    spec = parse(path, given.packages, notes)
    sound.check_numbers(model, path)
    tools = find_tools(model, given.tool, given.arm, path, notes)
    site, body = tools[0].name, int(model.body(tools[0].body).id)
    between = chain.joints_to(model, body)
    joint_ids = moving.joints(model, between, given.joints, path, notes)
    if not joint_ids:
        only = "".join(
            f" but the free joint {model.joint(j).name!r}, which is held" for j in between
        )
        raise RobotError(
            f"{path}: no joint moves the tool {site!r}{only}; an arm needs hinge and slide joints"
        )
    chain.check(model, joint_ids, path, f"the tool {site!r}")
    if given.tool is None:
        tools = moved(model, tools, joint_ids, notes)
    point = np.array(tools[0].point)
    if tools[0].kind == "site":
        point = model.site(site).pos.copy()
    else:
        of_body, site = spec.body(tools[0].body), names.free(TOOL_SITE, spec.site)
        poses.set_pose(of_body.add_site(name=site), point, poses.IDENTITY)
    at_home, key = _at_home(model, given.home if isinstance(given.home, str) else None, path)
    others = [model.key(i).name for i in range(model.nkey) if model.key(i).name not in ("", key)]
    if others:
        notes.append(f"keyframes that robot.home can name: {listed(others)}")
    followers = Followers(model, joint_ids)
    notes += followers.said()
    followers.place(at_home.qpos)
    followers.narrow(model)
    moved_ids = [*joint_ids, *followers.joint]
    chain.weld_rest(model, moved_ids)
    joints = tuple(model.joint(j).name for j in joint_ids)
    limits = [motors.torque_limit(model, followers.moved_by(j)) for j in joint_ids]
    motors.keep_rotors(spec, model, moved_ids)
    closures.check(model, joint_ids, followers.constraint, given.joints is not None, path)
    motors.replace(spec, model, moved_ids, notes)
    clearing.take_out(spec, notes, followers.constraint)
    poses.hold_off_chain(spec, model, at_home, moved_ids, notes)
    clearing.take_springs_off(spec, model, [model.joint(j).name for j in moved_ids], notes)
    clearing.passive_gravity(spec, notes)
    clearing.switch_on(spec, notes)
    for joint, limit in zip(joints, limits, strict=True):
        motors.add_motor(spec, joint, limit)
    return Arm(
        path=path,
        spec=spec,
        model=model,
        at_home=at_home,
        joints=joints,
        joint_id=np.array(joint_ids),
        followers=followers,
        tools=tools,
        site=site,
        body=body,
        point=point,
        home=at_home.qpos[model.jnt_qposadr[joint_ids]].copy() if key is not None else None,
        notes=notes,
    )


def _at_home(
    model: mujoco.MjModel, name: str | None, path: Path
) -> tuple[mujoco.MjData, str | None]:
    """The whole model at home, and the name of the keyframe that says so."""
    keys = [model.key(i).name for i in range(model.nkey)]
    data = mujoco.MjData(model)
    if name is None:
        # An arm that is attached to a scene brings its keyframe with a prefix.
        prefixed = [key for key in keys if key.endswith("home")]
        name = "home" if "home" in keys else prefixed[0] if len(prefixed) == 1 else None
    elif name not in keys:
        raise RobotError(
            f"{path}: robot.home = {shown(name)}: no such keyframe; its keyframes are: "
            f"{listed(keys)}. Or give the joint angles as a list"
        )
    if name is not None:
        mujoco.mj_resetDataKeyframe(model, data, keys.index(name))
    mujoco.mj_kinematics(model, data)
    return data, name
