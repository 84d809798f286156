"""An MJCF becomes a robot: tunable joint springs, torque motors, a tool; names looked up once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from . import library
from .errors import ExperimentError, RobotError
from .experiment import Experiment
from .memory import Layout

AXES = {"x": 0, "y": 1, "z": 2}

INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}


@dataclass(frozen=True)
class Robot:
    """An arm whose joints, from the world to the tool, have a spring and a torque motor each.

    Attributes:
        model: the compiled model, with room for the controller in `userdata`.
        joints: names of the joints, from the base to the tool (n).
        joint_id: their ids (n,).
        qpos_address: their addresses in qpos (n,).
        dof_address: their addresses in qvel (n,).
        actuator_id: the motor of each (n,).
        site: id of the tool's site.
        coordinate: axes of the world that the task controls (m,).
        home: joint angles at the start (n,) [rad].
        qpos: the whole model's qpos at the start (nq,).
        inertia: of each joint with the others held, at home (n,) [kg m^2].
        layout: sizes of the controller's block.
    """

    model: mujoco.MjModel
    joints: tuple[str, ...]
    joint_id: np.ndarray
    qpos_address: np.ndarray
    dof_address: np.ndarray
    actuator_id: np.ndarray
    site: int
    coordinate: np.ndarray
    home: np.ndarray
    qpos: np.ndarray
    inertia: np.ndarray
    layout: Layout

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def m(self) -> int:
        """Number of task coordinates."""
        return len(self.coordinate)


def build(experiment: Experiment) -> Robot:
    """Load an experiment's MJCF and find the arm in it.

    The file is not changed: gravity, time step, integrator and room in `userdata` are set on a
    copy in memory.

    Raises:
        ExperimentError: a list in the experiment is not as long as the arm or the task needs.
        RobotError: the file is missing, MuJoCo rejects it, or the arm is not one that the law can
            drive; the message names the file and the element.
    """
    path = find(experiment.robot.mjcf)
    spec = _parse(path)
    spec.option.timestep = experiment.simulation.timestep
    spec.option.integrator = INTEGRATORS[experiment.simulation.integrator]
    if experiment.simulation.gravity is not None:
        spec.option.gravity = experiment.simulation.gravity
    # A reset would wipe the record of a run that diverges; the controller detects it first.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    model = _compile(spec, path)

    site = _site(model, experiment.robot.tool, path)
    joint_id = _chain(model, site, path)
    joints = tuple(model.joint(int(j)).name or f"joint{j}" for j in joint_id)
    actuator_id = np.array([_motor(model, int(j), path) for j in joint_id])
    coordinate = np.array([AXES[axis] for axis in experiment.task.coordinates])
    if len(coordinate) != len(joints):
        raise RobotError(
            f"{path}: task.coordinates = {list(experiment.task.coordinates)} has "
            f"{len(coordinate)} coordinates and the arm has {len(joints)} joints "
            f"({', '.join(joints)}); the law needs as many coordinates as joints"
        )
    qpos_address = model.jnt_qposadr[joint_id].copy()
    home, qpos = _home(model, experiment.robot.home, qpos_address, joints, path)
    _check_lengths(experiment, joints, path)
    layout = Layout(
        joints=len(joints),
        coordinates=len(coordinate),
        dofs=model.nv,
        steps=max(motion.steps(experiment.simulation.timestep) for motion in experiment.motion),
    )
    spec.nuserdata = model.nuserdata + layout.size
    return Robot(
        model=_compile(spec, path),
        joints=joints,
        joint_id=joint_id,
        qpos_address=qpos_address,
        dof_address=model.jnt_dofadr[joint_id].copy(),
        actuator_id=actuator_id,
        site=site,
        coordinate=coordinate,
        home=home,
        qpos=qpos,
        inertia=_inertia(model, qpos)[model.jnt_dofadr[joint_id]],
        layout=layout,
    )


def _check_lengths(experiment: Experiment, joints: tuple[str, ...], path: Path) -> None:
    """Raise where an experiment gives a list that is not as long as the arm or the task."""
    law, bounds, axes = experiment.law, experiment.springs, experiment.task.coordinates
    for key, value, each, names in (
        ("law.k_v", law.k_v, "coordinate", axes),
        ("law.k_p", law.k_p, "coordinate", axes),
        ("law.gamma_k", law.gamma_k, "joint", joints),
        ("law.gamma_qe", law.gamma_qe, "joint", joints),
        ("law.q_c", law.q_c, "joint", joints),
        ("law.q_s", law.q_s, "joint", joints),
        ("springs.initial_stiffness", bounds.initial_stiffness, "joint", joints),
        ("springs.initial_equilibrium", bounds.initial_equilibrium, "joint", joints),
    ):
        if isinstance(value, tuple) and len(value) != len(names):
            raise ExperimentError(
                f"experiment {experiment.name!r}: {key} = {list(value)} has {len(value)} numbers; "
                f"{len(names)} are needed, one per {each} of {path.name}: {', '.join(names)}"
            )


def find(mjcf: str) -> Path:
    """The MJCF file that a path or a built-in name means.

    Raises:
        RobotError: there is no such file.
    """
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


def _parse(path: Path) -> mujoco.MjSpec:
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise RobotError(_rejected(path, error)) from None


def _compile(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        raise RobotError(_rejected(path, error)) from None


def _rejected(path: Path, error: ValueError) -> str:
    return f"{path}: MuJoCo rejects it: {' '.join(str(error).split())}"


def _site(model: mujoco.MjModel, name: str, path: Path) -> int:
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name)
    if site < 0:
        names = [model.site(i).name for i in range(model.nsite)]
        listed = ", ".join(filter(None, names)) or "none with a name"
        raise RobotError(f"{path}: robot.tool = {name!r}: no such site; its sites are: {listed}")
    return int(site)


def _chain(model: mujoco.MjModel, site: int, path: Path) -> np.ndarray:
    """Ids of the joints from the world to the tool's body."""
    joints: list[int] = []
    body = int(model.site_bodyid[site])
    while body > 0:
        first = int(model.body_jntadr[body])
        count = int(model.body_jntnum[body])
        joints[:0] = range(first, first + count)
        body = int(model.body_parentid[body])
    if not joints:
        raise RobotError(f"{path}: no joint moves the tool {model.site(site).name!r}")
    for j in joints:
        if int(model.jnt_type[j]) not in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            raise RobotError(
                f"{path}: joint {model.joint(j).name!r} between the world and the tool is a {kind} "
                "joint; only hinge and slide joints can carry a spring"
            )
        if model.jnt_stiffnesspoly[j].any() or model.jnt_springyield[j] > 0:
            raise RobotError(
                f"{path}: joint {model.joint(j).name!r} has a polynomial or plastic spring "
                "(stiffness with several numbers, or springyield); the law needs a linear one"
            )
    return np.array(joints)


def _motor(model: mujoco.MjModel, joint: int, path: Path) -> int:
    """The actuator whose control is the torque of `joint`."""
    name = model.joint(joint).name
    mine = [
        a
        for a in range(model.nu)
        if model.actuator_trntype[a] == mujoco.mjtTrn.mjTRN_JOINT
        and model.actuator_trnid[a, 0] == joint
    ]
    if len(mine) != 1:
        raise RobotError(
            f"{path}: joint {name!r} has {len(mine)} actuators; one is needed: "
            f'<motor joint="{name}" gear="1"/>'
        )
    a = mine[0]
    is_motor = (
        model.actuator_dyntype[a] == mujoco.mjtDyn.mjDYN_NONE
        and model.actuator_gaintype[a] == mujoco.mjtGain.mjGAIN_FIXED
        and model.actuator_biastype[a] == mujoco.mjtBias.mjBIAS_NONE
        and model.actuator_gainprm[a, 0] == 1.0
        and model.actuator_gear[a, 0] == 1.0
    )
    if not is_motor:
        raise RobotError(
            f"{path}: actuator {model.actuator(a).name!r} of joint {name!r} is not a torque motor; "
            f'use <motor joint="{name}" gear="1"/>'
        )
    return a


def _home(
    model: mujoco.MjModel,
    home: str | tuple[float, ...],
    qpos_address: np.ndarray,
    joints: tuple[str, ...],
    path: Path,
) -> tuple[np.ndarray, np.ndarray]:
    qpos = model.qpos0.copy()
    if isinstance(home, str):
        key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, home)
        if key < 0:
            names = [model.key(i).name for i in range(model.nkey)]
            listed = ", ".join(filter(None, names)) or "none with a name"
            raise RobotError(
                f"{path}: robot.home = {home!r}: no such keyframe; its keyframes are: {listed}. "
                "Or give the joint angles as a list"
            )
        qpos = model.key_qpos[key].copy()
    else:
        if len(home) != len(joints):
            raise RobotError(
                f"{path}: robot.home has {len(home)} angles and the arm has {len(joints)} joints "
                f"({', '.join(joints)})"
            )
        qpos[qpos_address] = home
    return qpos[qpos_address].copy(), qpos


def _inertia(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    """Diagonal of the inertia matrix at `qpos` (nv,)."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return np.diag(full).copy()
