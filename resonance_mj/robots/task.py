"""The task's coordinates: the positions that an arm controls, and the joints that have no part."""

import itertools
from pathlib import Path

import numpy as np

from ..errors import ExperimentError, RobotError
from ..experiments.experiment import Experiment
from ..text import listed, shown
from .mjcf import Arm

AXES = {"x": 0, "y": 1, "z": 2, "rx": 3, "ry": 4, "rz": 5}

IDLE = 1e-9
"""Share of the Jacobian's size below which a joint does not move the tool."""


def axes(given: tuple[str, ...] | None, arm: Arm, home: np.ndarray) -> tuple[str, ...]:
    """The task's coordinates; if not given, the positions that the arm controls at home.

    Joints that move none of them are said.

    Raises:
        RobotError: the arm can move its tool in no direction.
    """
    found = _found(arm, home) if given is None else _written_out(given)
    idle = _idle(arm, home, [AXES[axis] for axis in found])
    if idle:
        others = [tool.name for tool in arm.tools[1:]]
        arm.notes.append(
            f"{'joints' if len(idle) > 1 else 'joint'} {listed(idle)} cannot move the tool "
            f"{arm.tools[0].name!r} in {', '.join(found)}; robot.tool names another: "
            f"{listed(others, most=8, none='a site beside the axis would be one')}"
        )
    return found


def _written_out(given: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(
        axis for name in given for axis in (("rx", "ry", "rz") if name == "rotation" else (name,))
    )


def _found(arm: Arm, home: np.ndarray) -> tuple[str, ...]:
    # One arm moves in x and z, another in all three: as many axes as it moves independently of
    # each other, x and z before y where it is about as good at them.
    jacobian = arm.jacobian(home)
    size = np.linalg.norm(jacobian[:3])
    found: tuple[str, ...] = ()
    for count in range(1, min(3, jacobian.shape[1]) + 1):
        sets = list(itertools.combinations("xzy", count))
        least = np.array(
            [
                np.linalg.svd(jacobian[[AXES[axis] for axis in one]], compute_uv=False)[-1]
                for one in sets
            ]
        )
        if least.max() > 1e-3 * size:
            found = sets[int(np.argmax(least > 0.3 * least.max()))]
    if not found:
        raise RobotError(
            f"{arm.path}: the tool {shown(arm.tools[0].name)} cannot be moved from the home pose: "
            "give another as robot.tool, such as a site away from the joints' axes, or another "
            "robot.home"
        )
    named = tuple(sorted(found))
    arm.notes.append(f"task: position in {', '.join(named)}, which the arm controls at home")
    return named


def _idle(arm: Arm, home: np.ndarray, coordinate: list[int]) -> list[str]:
    """Names of the joints that do not move the task's coordinates, at home and elsewhere."""
    rng = np.random.default_rng(0)
    poses = [home, *(home + 0.3 * rng.standard_normal((4, len(home))))]
    rows = np.array([arm.jacobian(q)[coordinate] for q in poses])
    size = np.abs(rows).max(axis=(0, 1))
    return [joint for joint, of in zip(arm.joints, size, strict=True) if of <= IDLE * size.max()]


def check_lengths(
    experiment: Experiment, joints: tuple[str, ...], axes: tuple[str, ...], path: Path
) -> None:
    """Raise where the task, or a list, is not as long as the arm or the task needs."""
    if len(axes) > len(joints):
        raise RobotError(
            f"{path}: the task has {len(axes)} coordinates ({', '.join(axes)}) and the arm "
            f"{len(joints)} joints ({', '.join(joints)}); a task needs no more coordinates than "
            "joints"
        )
    law, bounds, motors = experiment.law, experiment.springs, experiment.motors
    position = tuple(axis for axis in axes if axis in "xyz")
    lists = [
        ("law.k_v", law.k_v, "coordinate", axes),
        ("law.k_p", law.k_p, "coordinate", axes),
        ("law.gamma_k", law.gamma_k, "joint", joints),
        ("law.gamma_qe", law.gamma_qe, "joint", joints),
        ("law.q_c", law.q_c, "joint", joints),
        ("law.q_s", law.q_s, "joint", joints),
        ("reality.motor_torque", experiment.reality.motor_torque, "joint", joints),
        ("reality.torque_rate", experiment.reality.torque_rate, "joint", joints),
        ("reality.motor_speed", experiment.reality.motor_speed, "joint", joints),
        ("reality.joint_stiffness", experiment.reality.joint_stiffness, "joint", joints),
        ("reality.rotor_inertia", experiment.reality.rotor_inertia, "joint", joints),
        ("reality.link_error", experiment.reality.link_error, "joint", joints),
        ("reality.spring_error", experiment.reality.spring_error, "joint", joints),
        ("motors.k_m", motors.k_m, "joint", joints),
        ("motors.gear_ratio", motors.gear_ratio, "joint", joints),
        ("motors.gear_efficiency", motors.gear_efficiency, "joint", joints),
        ("motors.no_load_friction", motors.no_load_friction, "joint", joints),
        ("motors.rated_torque", motors.rated_torque, "joint", joints),
        ("springs.weights", bounds.weights, "joint", joints),
        ("springs.initial_stiffness", bounds.initial_stiffness, "joint", joints),
        ("springs.initial_equilibrium", bounds.initial_equilibrium, "joint", joints),
    ]
    own = ("joint", joints) if experiment.task.space == "joint" else None
    for index, motion in enumerate(experiment.motion):
        lists.append((f"motion.{index}.offset", motion.offset, *(own or ("coordinate", axes))))
        lists.append((f"motion.{index}.center", motion.center, *(own or ("coordinate", position))))
    for key, value, each, names in lists:
        if isinstance(value, tuple) and len(value) != len(names):
            raise ExperimentError(
                f"experiment {experiment.name!r}: {key} = {list(value)} has {len(value)} numbers; "
                f"{len(names)} are needed, one per {each} of {path.name}: {', '.join(names)}"
            )
