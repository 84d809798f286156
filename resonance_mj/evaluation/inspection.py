"""What the program finds in an arm: its numbers, a motion and gains for it, and why."""

import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tomlkit

from ..experiments.experiment import Experiment, describe
from ..laws.gains import Gains
from ..motions.kinematics import JointMotion
from ..plan.filling import found
from ..plan.plan import Plan, plan_for
from ..robots.reach import reach
from ..robots.robot import Robot
from ..robots.tool import Tool
from ..springs.optimum import Optimum


@dataclass(frozen=True)
class Joint:
    """A joint of the arm, with what the suggested motion asks of it.

    Where it slides, its angles are in m, its torques in N, its damping in N s/m and its inertia in
    kg.

    Attributes:
        name: in the MJCF.
        slides: whether it is a slide joint; else it is a hinge.
        home: angle at home [rad].
        range: least and greatest angle [rad]; None without limit.
        damping: viscosity [N m s/rad].
        inertia: diagonal element of the inertia matrix at home [kg m^2].
        torque_limit: least and greatest torque of its motor [N m]; infinite without limit.
        peak_speed: largest speed along the motion [rad/s].
        peak_torque: largest motor torque along it without springs [N m].
        peak_torque_with_springs: the same with the best constant springs [N m].
    """

    name: str
    slides: bool
    home: float
    range: tuple[float, float] | None
    damping: float
    inertia: float
    torque_limit: tuple[float, float]
    peak_speed: float
    peak_torque: float
    peak_torque_with_springs: float

    @property
    def share(self) -> float:
        """Peak motor torque without springs, as a share of the motor's smaller limit."""
        weaker = min(abs(end) for end in self.torque_limit)
        return self.peak_torque / weaker if weaker else np.inf


@dataclass(frozen=True)
class Inspection:
    """What was found in an arm.

    Attributes:
        experiment: the suggestion, with all that was found written out; it runs to the same result
            as with nothing given but the MJCF.
        joints: of the arm, from the base to the tool.
        tools: what could be the tool, first what is.
        tool: the one that is.
        tool_reason: why.
        axes: names of the task's coordinates.
        reach: from the first joint to the tool with the arm stretched out [m].
        conditioning: smallest to largest singular value of J, at each time step of a cycle (N,).
        gains: that the experiment has on the arm.
        torque_reduction: share of ∫τᵀτ dt that the best constant springs take over.
        notes: what was chosen and changed, and what to know before a run, a line each.
    """

    experiment: Experiment
    joints: tuple[Joint, ...]
    tools: tuple[Tool, ...]
    tool: Tool
    tool_reason: str
    axes: tuple[str, ...]
    reach: float
    conditioning: np.ndarray
    gains: Gains
    torque_reduction: float
    notes: tuple[str, ...]

    def to_toml(self) -> str:
        """The suggested experiment as a TOML text with comments: what is worth changing."""
        meanings = {key: meaning for key, _, meaning in describe()}
        values = self.experiment.model_dump()
        values |= {"": values, "motion.0": values["motion"][0]}
        units = (f"{joint.name} [{'m' if joint.slides else 'rad'}]" for joint in self.joints)
        more = {"robot.home": f" Here: {', '.join(units)}."}
        if any(joint.slides for joint in self.joints):
            more["springs.stiffness"] = " [N/m] for slide joints."
            more["springs.equilibrium"] = " [m] for slide joints."
        lines = [line for text in (_HEADING, *self.notes) for line in _comment(text)]
        for section, names in WORTH_CHANGING.items():
            if section:
                lines += ["", "[[motion]]" if section == "motion.0" else f"[{section}]"]
            for name in names:
                key, value = f"{section}.{name}".lstrip("."), values[section][name]
                if value is None or value == ():
                    continue
                # How it is found if not given says nothing here, where it is given.
                meaning = re.sub(r";[^;]*if not given\.$", ".", " ".join(meanings[key].split()))
                lines += _comment(meaning + more.get(key, ""))
                item = list(value) if isinstance(value, tuple) else value
                lines.append(f"{name} = {tomlkit.item(item).as_string()}")
        return "\n".join(lines) + "\n"


def inspect(planned: Experiment | Plan) -> Inspection:
    """Look at the arm of an experiment, or of its plan, and at its first motion.

    Raises:
        RobotError: the robot cannot be loaded.
        MotionError: the arm cannot follow the motion.
    """
    plan = planned if isinstance(planned, Plan) else plan_for(planned)
    robot, motion, best, tool = plan.robot, plan.joints[0], plan.optima[0], plan.robot.tools[0]
    values = np.linalg.svd(plan.kinematics.jacobians(motion.q), compute_uv=False)
    chosen = [note for note in robot.notes if note.startswith("tool: ")]
    return Inspection(
        experiment=_written_out(plan),
        joints=_joints(robot, motion, best),
        tools=robot.tools,
        tool=tool,
        tool_reason=chosen[0].rpartition(", ")[2] if chosen else "given",
        axes=robot.axes,
        reach=reach(robot),
        conditioning=np.array([one[-1] / one[0] for one in values]),
        gains=plan.gains,
        torque_reduction=best.torque_reduction,
        notes=plan.notes,
    )


def _joints(robot: Robot, motion: JointMotion, best: Optimum) -> tuple[Joint, ...]:
    model, joint_id = robot.model, robot.joint_id
    limited = model.jnt_limited[joint_id].astype(bool)
    return tuple(
        Joint(
            name=name,
            slides=bool(robot.slides[j]),
            home=float(robot.home[j]),
            range=_ends(model.jnt_range[joint_id[j]]) if limited[j] else None,
            damping=float(model.dof_damping[robot.dof_address[j]]),
            inertia=float(robot.inertia[j, j]),
            torque_limit=_ends(robot.torque_limit[j]),
            peak_speed=float(np.abs(motion.dq[:, j]).max()),
            peak_torque=float(np.abs(best.torque_without_springs[:, j]).max()),
            peak_torque_with_springs=float(np.abs(best.torque[:, j]).max()),
        )
        for j, name in enumerate(robot.joints)
    )


def _ends(pair: np.ndarray) -> tuple[float, float]:
    return float(pair[0]), float(pair[1])


def _written_out(plan: Plan) -> Experiment:
    """An experiment with what was found in its robot and for its gains written out."""
    path = Path(plan.experiment.robot.mjcf)
    shown = {f"{section}.{key}" for section, keys in WORTH_CHANGING.items() for key in keys}
    all_found = found(plan.experiment, plan.robot, plan.gains)
    changes = {key: value for key, value in all_found.items() if key in shown}
    if path.exists():
        changes["robot.mjcf"] = str(path.resolve())
    return plan.experiment.replace(changes)


WORTH_CHANGING = {
    "": ("name",),
    "robot": ("mjcf", "tool", "joints", "home", "packages"),
    "task": ("coordinates",),
    "simulation": ("timestep",),
    "motion.0": ("duration", "period", "blend", "shape", "center", "size", "plane"),
    "law": ("kind", "omega", "eta", "lead", "harmonics", "listens"),
    "springs": ("stiffness", "equilibrium"),
}
"""Keys that a suggested experiment has, by their sections."""

_HEADING = (
    "Written by `resonance-mj inspect --toml`: what was found, in SI units and radians. Every "
    "other key has its default; `resonance-mj keys` lists them all."
)


def _comment(text: str) -> list[str]:
    return textwrap.wrap(
        " ".join(text.split()),
        100,
        initial_indent="# ",
        subsequent_indent="# ",
        break_long_words=False,
        break_on_hyphens=False,
    )
