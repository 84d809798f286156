"""An MJCF becomes a robot: tunable joint springs, torque motors, a tool; names looked up once."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import mujoco
import numpy as np

from ..experiments.experiment import Experiment
from ..springs.elements import Element
from ..text import joined
from . import clearing, elastic, gears, mjcf, motors, options, payload, sound, task
from . import home as homes
from .compiling import compile_spec
from .couplings import Followers
from .tool import Tool
from .warned import heard

NARROW = 0.2
"""Range of a hinge joint that hardly an arm has, but one in radians read as degrees [rad]."""


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
        followers: the joints that are coupled to these.
        elements: elastic elements besides the joints' springs; the model's tendons.
        site: id of the tool's site.
        axes: names of the task's coordinates: of x, y, z, and rx, ry, rz for rotation (m).
        coordinate: their numbers, 0 to 5 (m,).
        position: of the tool at home (3,) [m].
        orientation: of the tool at home (3, 3).
        payload: id of the body that is the tool's payload; None if it never carries one.
        torque_limit: least and greatest torque of each motor (n, 2) [N m].
        home: joint angles at the start (n,) [rad].
        qpos: the whole model's qpos at the start (nq,).
        inertia: inertia matrix at home (n, n) [kg m^2].
        jacobian: of the task's coordinates at home (m, n) [m/rad].
        usual: manipulability sqrt(det J Jᵀ) of the task's Jacobian at home.
        notes: what was chosen and changed when the robot was loaded, a line each.
        tools: what could follow the motion, first what does.
        path: of its file.
        joint_space: whether motions are the joints'.
    """

    model: mujoco.MjModel
    joints: tuple[str, ...]
    joint_id: np.ndarray
    qpos_address: np.ndarray
    dof_address: np.ndarray
    actuator_id: np.ndarray
    followers: Followers
    elements: tuple[Element, ...]
    site: int
    payload: int | None
    axes: tuple[str, ...]
    coordinate: np.ndarray
    position: np.ndarray
    orientation: np.ndarray
    torque_limit: np.ndarray
    home: np.ndarray
    qpos: np.ndarray
    inertia: np.ndarray
    jacobian: np.ndarray
    usual: float
    notes: tuple[str, ...]
    tools: tuple[Tool, ...]
    path: Path
    joint_space: bool = False
    _loaded: dict[float, Robot] = field(default_factory=dict, repr=False, compare=False)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def m(self) -> int:
        """Number of task coordinates."""
        return len(self.coordinate)

    def copied(self) -> Robot:
        """The same with models of its own, into which springs can be written."""
        return replace(self, model=copy.copy(self.model), _loaded={})

    def carrying(self, mass: float) -> Robot:
        """The robot with a payload at its tool [kg]: one model for each mass."""
        if self.payload is None or mass == 0.0:
            return self
        if mass not in self._loaded:
            model = payload.carrying(self.model, self.payload, mass)
            self._loaded[mass] = replace(self, model=model)
        return self._loaded[mass]

    @property
    def slides(self) -> np.ndarray:
        """1 for each slide joint, 0 for each hinge (n,)."""
        return (self.model.jnt_type[self.joint_id] == int(mujoco.mjtJoint.mjJNT_SLIDE)).astype(int)

    @property
    def damping(self) -> np.ndarray:
        """Viscous damping of each joint (n,) [N m s/rad]."""
        return self._with_followers(self.model.dof_damping, 2)

    @property
    def friction(self) -> np.ndarray:
        """Dry friction of each joint (n,) [N m]."""
        return self._with_followers(self.model.dof_frictionloss, 1)

    def _with_followers(self, of_dof: np.ndarray, power: int) -> np.ndarray:
        address = self.model.jnt_dofadr
        moved = map(self.followers.moved_by, self.joint_id)
        return np.array(
            [sum(of_dof[address[j]] * abs(speed) ** power for j, speed in one) for one in moved]
        )

    def positions(self, q: np.ndarray) -> np.ndarray:
        """The whole model's qpos (..., nq) at joint angles (..., n) [rad]."""
        qpos = np.tile(self.qpos, (*q.shape[:-1], 1))
        qpos[..., self.qpos_address] = q
        self.followers.place(qpos)
        return qpos

    @property
    def limited(self) -> np.ndarray:
        """Whether each joint is stopped at the ends of its range (n,)."""
        stops = not self.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_LIMIT
        return self.model.jnt_limited[self.joint_id].astype(bool) & stops

    @property
    def hint(self) -> str:
        """Where joints hardly turn, what their file may lack; to be put behind a message."""
        width = np.ptp(self.model.jnt_range[self.joint_id], axis=1)
        few = np.flatnonzero(self.limited & (width < NARROW) & (self.slides == 0))
        named = joined([self.joints[j] for j in few])
        if not few.size:
            return ""
        return (
            f"; {named}: less than {NARROW} rad to turn; if the file has its angles in radians, it "
            'lacks <compiler angle="radian"/>'
        )

    @property
    def rotates(self) -> bool:
        """Whether the task has rotation, its last three coordinates."""
        return self.axes[-1] == "rz"

    @property
    def moved(self) -> tuple[str, ...]:
        """The coordinates of motions, without rotation: the task's positions, or the joints."""
        return self.joints if self.joint_space else self.position_axes

    @property
    def position_axes(self) -> tuple[str, ...]:
        """The task's coordinates without rotation."""
        return self.axes[:-3] if self.rotates else self.axes


Room = Callable[[int, int, int], int]
"""Numbers to reserve in `userdata`, of so many joints, task coordinates and dofs."""


def build(experiment: Experiment, room: Room = lambda joints, coordinates, dofs: 0) -> Robot:
    """Load an experiment's MJCF and find the arm in it.

    The file is not changed: all is set on a copy. MuJoCo's warnings are among the robot's notes.

    Args:
        experiment: names the file, the tool, home and task.
        room: how much room a controller needs behind the author's own `userdata`.

    Raises:
        ExperimentError: a list in the experiment is not as long as the arm or the task needs.
        RobotError: the file is missing, MuJoCo rejects it, or the arm is not one that the law can
            drive; the message names the file and the element.
    """
    given = experiment.robot
    with heard() as warned:
        sound.check_texts(mjcf.find(given.mjcf))
        arm = mjcf.read(given)
        path, spec, joints, notes = arm.path, arm.spec, arm.joints, arm.notes
        options.write(spec, experiment, arm)
        arm.model.opt.disableflags = spec.option.disableflags
        home = homes.chosen(given, arm)
        if given.contacts:
            arm.pose(home)
            clearing.let_overlaps_pass(spec, arm.model, arm.at_home, notes)
        axes = task.axes(experiment.task.coordinates, arm, home)
        task.check_lengths(experiment, joints, axes, path)
        n = len(joints)
        reality = experiment.reality
        rotors = 0 if reality.joint_stiffness is None else n
        dofs = n + len(arm.followers.joint) + rotors
        spec.nuserdata = arm.model.nuserdata + room(n, len(axes), dofs)
        carries = any(motion.carries for motion in experiment.motion)
        load = payload.add(spec, arm.site, arm.point) if carries else None
        elements = elastic.elements(experiment.springs, arm, home)
        elastic.add(spec, elements, joints)
        turned = gears.add(spec, joints, reality)
        model = compile_spec(spec, path)
        joint_id = np.array([model.joint(name).id for name in joints])
        actuator_id = np.array([model.actuator(f"motor_{name}").id for name in joints])
        site = int(model.site(arm.site).id)
        followers = Followers(model, joint_id.tolist())
        followers.narrow(model)
        followers.turn({model.joint(j).id: model.joint(r).id for j, r in turned.items()})
        qpos = model.qpos0.copy()
        qpos[model.jnt_qposadr[joint_id]] = home
        followers.place(qpos)
        jacobian, position, orientation, inertia = _at_home(model, qpos, joint_id, site, followers)
        sound.check_inertia(inertia, joints, path)
        inertia = gears.tighten(model, turned, inertia, experiment)
    coordinate = np.array([task.AXES[axis] for axis in axes])
    J = jacobian[coordinate]
    return Robot(
        model=model,
        joints=joints,
        joint_id=joint_id,
        qpos_address=model.jnt_qposadr[joint_id].copy(),
        dof_address=model.jnt_dofadr[joint_id].copy(),
        actuator_id=actuator_id,
        followers=followers,
        elements=elements,
        site=site,
        payload=None if load is None else int(model.body(load).id),
        axes=axes,
        coordinate=coordinate,
        position=position,
        orientation=orientation,
        torque_limit=motors.limits(model, actuator_id, experiment),
        home=home,
        qpos=qpos,
        inertia=inertia,
        jacobian=J,
        usual=float(np.sqrt(max(np.linalg.det(J @ J.T), 0.0))),
        notes=(*notes, *warned),
        tools=arm.tools,
        path=path,
        joint_space=experiment.task.space == "joint",
    )


def _at_home(
    model: mujoco.MjModel,
    qpos: np.ndarray,
    joint_id: np.ndarray,
    site: int,
    followers: Followers,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Jacobian (6, n), the tool's position (3,) and orientation (3, 3), inertia matrix (n, n)."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    dofs = model.jnt_dofadr[joint_id]
    jacobian, full = np.zeros((6, model.nv)), np.zeros((model.nv, model.nv))
    mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
    mujoco.mj_fullM(model, data, full)
    place, turn = data.site_xpos[site].copy(), data.site_xmat[site].reshape(3, 3).copy()
    jacobian, full = followers.borne(jacobian), followers.borne(followers.borne(full).T)
    return jacobian[:, dofs], place, turn, full[np.ix_(dofs, dofs)]
