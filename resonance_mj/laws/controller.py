"""One control step: (4)-(8) on the controller's memory and the robot's state.

It runs inside MuJoCo's control callback, where positions, velocities and the tool's Jacobian are
current and the joint springs' torque of this step has been computed already: springs written here
act from the next step on, which is explicit Euler for (6) and (7).
"""

from collections.abc import Callable

import numpy as np

from ..motions import rotations
from ..springs import spring as springs
from ..step_functions import step_function
from . import equations, sensing
from .adjusting import adapt, write_springs
from .memory import Header
from .views import own as views
from .views import row as record

Command = Callable[..., None]
"""Sets y and τ in the memory, from what is measured there."""


@step_function
def begins_step(memory: np.ndarray) -> bool:
    """Whether this callback is the first of its time step, and the run goes on.

    RK4 calls back at each of its four stages; the law acts at the first and holds.
    """
    return memory[Header.STAGE] == 0.0 and memory[Header.FAILED_STEP] == 0.0


@step_function
def act(
    memory: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    tool: np.ndarray,
    orientation: np.ndarray,
    ctrl: np.ndarray,
    command: Command,
) -> None:
    """Measure the errors, set the motor torque (4), record the step, adapt the springs (6), (7).

    Where the arm is a real one, the law acts on what its sensors say, and holds its torque between
    its own steps; what is recorded is what the arm does.

    Args:
        memory: the controller's block; its `jacobian` is the tool's, current (6, dofs).
        qpos: mjData.qpos.
        qvel: mjData.qvel.
        tool: position of the tool (3,) [m].
        orientation: of the tool (3, 3).
        ctrl: mjData.ctrl, written.
        command: sets y and τ: `standard`, `joint_task`, `joint_space`, or a custom law's.
    """
    own = views(memory)
    row = record(memory, own.n, own.m, own.step)
    k, offset, q_c = own.stiffness, own.offset, own.q_c
    taken = own.tool_taken if own.misjudged else tool
    if own.slots == 0:
        for j in range(own.n):
            own.angle[j] = qpos[int(own.qpos_address[j])]
            own.speed[j] = qvel[int(own.dof_address[j])]
        measure(memory, qvel, taken, orientation, row.x)
        command(memory)
        if own.misjudged:
            locate(memory, tool, orientation, row.x)
    else:
        sensing.remember(memory, qpos, qvel, taken, orientation)
        if own.clock % own.hold == 0:
            sensing.sense(memory)
            measure(memory, own.qvel_seen, own.tool_seen, own.orientation_seen, row.x)
            command(memory)
            for j in range(own.n):
                own.commanded[j] = own.tau[j]
        sensing.exert(memory)
        locate(memory, tool, orientation, row.x)
    if failed(memory):
        return
    for j in range(own.n):
        # Within the motors' limits; what is not a number stays so, for the check that follows.
        low, high = own.tau_min[j], own.tau_max[j]
        if own.driven:
            low, high = driven(memory, j, qvel[int(own.dof_address[j])], low, high)
            before, step = ctrl[int(own.actuator_id[j])], own.torque_step[j]
            if own.tau[j] < before - step:
                own.tau[j] = before - step
            elif own.tau[j] > before + step:
                own.tau[j] = before + step
        if own.tau[j] < low:
            own.tau[j] = low
        elif own.tau[j] > high:
            own.tau[j] = high
        speed = abs(qvel[int(own.dof_address[j])])
        spring = abs(springs.torque(k[j], offset[j], qpos[int(own.qpos_address[j])], q_c[j]))
        hardest = own.torque_limit[j]
        # Written so that what is not a number fails too.
        if not (speed <= own.speed_limit and abs(own.tau[j]) <= hardest and spring <= hardest):
            memory[Header.FAILED_STEP] = own.step + 1
            memory[Header.FAILED_JOINT] = j
            return

    for j in range(own.n):
        row.q[j] = qpos[int(own.qpos_address[j])]
        row.dq[j] = qvel[int(own.dof_address[j])]
        row.y[j] = own.y[j]
        row.tau[j] = own.tau[j]
        row.u[j] = own.learned[j]
        row.stiffness[j] = k[j]
        row.offset[j] = offset[j]
        ctrl[int(own.actuator_id[j])] = own.tau[j]
    adapt(memory, row.q)


@step_function
def driven(
    memory: np.ndarray, j: int, speed: float, low: float, high: float
) -> tuple[float, float]:
    """Least and greatest torque of a motor that turns, of those when it stands still [N m]."""
    own = views(memory)
    left = 1.0 - abs(speed) / own.no_load[j]
    if left < 0.0:
        left = 0.0
    if speed > 0.0:
        return low, high * left
    return low * left, high


@step_function
def measure(
    memory: np.ndarray,
    qvel: np.ndarray,
    tool: np.ndarray,
    orientation: np.ndarray,
    x: np.ndarray,
) -> None:
    """Task Jacobian, position (to `x`), position error and rate of the tool, into the memory."""
    own = views(memory)
    for i in range(own.m):
        axis = int(own.coordinate[i])
        if axis < 3:
            x[i] = tool[axis]
            own.error[i] = tool[axis] - own.x_desired[i]
        own.rate[i] = -own.dx_desired[i]
        for j in range(own.n):
            dof = int(own.dof_address[j])
            own.J[i, j] = own.jacobian[axis, dof]
            own.rate[i] += own.J[i, j] * qvel[dof]
        if own.dofs > own.n:
            for dof in range(own.dofs):
                if own.leader[dof] >= 0:
                    own.J[i, int(own.leader[dof])] += own.ratio[dof] * own.jacobian[axis, dof]
                    own.rate[i] += own.jacobian[axis, dof] * qvel[dof]
        if axis < 3 and own.difference:
            passed = own.timestep if own.slots == 0 else own.hold * own.timestep
            own.rate[i] = (tool[axis] - own.before[axis]) / passed - own.dx_desired[i]
            own.before[axis] = tool[axis]
    if own.rotates:
        rotations.rotation(own.x_desired[own.m - 3 :], own.orientation, own.desired)
        rotations.rotation_vector(orientation, own.desired, own.error[own.m - 3 :])
        rotations.rotation_vector(orientation, own.orientation, x[own.m - 3 :])


@step_function
def locate(memory: np.ndarray, tool: np.ndarray, orientation: np.ndarray, x: np.ndarray) -> None:
    """Where the tool is, to `x` (m,)."""
    own = views(memory)
    for i in range(own.m):
        if int(own.coordinate[i]) < 3:
            x[i] = tool[int(own.coordinate[i])]
    if own.rotates:
        rotations.rotation_vector(orientation, own.orientation, x[own.m - 3 :])


@step_function
def standard(memory: np.ndarray) -> None:
    """Error signal y (8) and motor torque τ (4)."""
    own = views(memory)
    positions = own.m - 3 if own.rotates else own.m
    for i in range(positions):
        own.error[i] /= own.length
    equations.saturation(own.error, own.s)
    for i in range(positions):
        own.s[i] *= own.length
    if own.form == 0:
        equations.error_inverse(own.J, own.rate, own.alpha, own.s, own.work, own.y)
    elif own.form == 1:
        equations.error_transpose(own.J, own.rate, own.alpha, own.s, own.y)
    else:
        for j in range(own.n):
            own.drift[j] = own.speed[j] + own.alpha_0 * (own.angle[j] - own.posture[j])
        equations.error_damped(
            own.J, own.rate, own.alpha, own.s, own.drift, own.usual, own.work, own.y
        )
    equations.motor_torque(own.J, own.k_v, own.k_p, own.rate, own.s, own.learned, own.tau)
    feed_back(memory)


@step_function
def feed_back(memory: np.ndarray) -> None:
    """Take the inertial feedback of y off the motor torque, filtered where y is noisy."""
    own = views(memory)
    if own.inertial and own.filtered == 0.0:
        equations.inertial_feedback(own.feedback, own.y, own.tau)
    elif own.inertial:
        for j in range(own.n):
            own.slow[j] += own.filtered * (own.y[j] - own.slow[j])
            own.slower[j] += own.filtered * (own.slow[j] - own.slower[j])
        equations.inertial_feedback(own.feedback, own.slower, own.tau)


@step_function
def joint_task(memory: np.ndarray) -> None:
    """Of a task of the joints, y = Δq̇ + α s(Δq) in place of (8), and motor torque τ."""
    own = views(memory)
    error, s = own.q, own.drift
    for j in range(own.n):
        error[j] = own.angle[j] - own.q_desired[j]
    equations.saturation(error, s)
    for j in range(own.n):
        own.y[j] = own.speed[j] - own.dq_desired[j] + own.alpha * s[j]
        own.tau[j] = own.learned[j]
    feed_back(memory)


@step_function
def joint_space(memory: np.ndarray) -> None:
    """Error signal y = Δq̇ + α s(Δq) and motor torque τ = u - G Δq̇ - G_p s(Δq), given q_d."""
    own = views(memory)
    error, rate, s = own.q, own.dq, own.drift
    for j in range(own.n):
        error[j] = own.angle[j] - own.q_desired[j]
        rate[j] = own.speed[j] - own.dq_desired[j]
    equations.saturation(error, s)
    for j in range(own.n):
        own.y[j] = rate[j] + own.alpha * s[j]
        own.tau[j] = own.learned[j]
        for i in range(own.n):
            own.tau[j] -= own.feedback[j, i] * rate[i] + own.feedback_p[j, i] * s[i]


@step_function
def end_stage(
    memory: np.ndarray,
    jnt_stiffness: np.ndarray,
    qpos_spring: np.ndarray,
    dof_damping: np.ndarray,
) -> None:
    """Count this callback; after the last of a time step, write the springs into the model."""
    memory[Header.STAGE] += 1.0
    if memory[Header.STAGE] < memory[Header.STAGES]:
        return
    memory[Header.STAGE] = 0.0
    memory[Header.STEP] += 1.0
    memory[Header.CLOCK] += 1.0
    write_springs(memory, jnt_stiffness, qpos_spring, dof_damping)


@step_function
def failed(memory: np.ndarray) -> bool:
    """Whether the run has failed: what follows is no run."""
    return memory[Header.FAILED_STEP] > 0.0


@step_function
def hold(qvel: np.ndarray, ctrl: np.ndarray, *forces: np.ndarray) -> None:
    """Stop the arm, without motors or forces.

    It keeps MuJoCo from integrating, and warning about, numbers that are not finite.

    Args:
        qvel: mjData.qvel, written.
        ctrl: mjData.ctrl, written.
        forces: mjData.qfrc_bias and mjData.qfrc_passive, written.
    """
    _clear(qvel)
    _clear(ctrl)
    for force in forces:
        _clear(force)


@step_function
def _clear(array: np.ndarray) -> None:
    for i in range(array.size):
        array[i] = 0.0


COMMANDS: tuple[Command, ...] = (standard, joint_task, joint_space)
"""The commands that come with the program."""
