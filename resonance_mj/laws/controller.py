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
from . import equations
from .memory import Header, matrix, vector

Command = Callable[..., None]
"""Sets y and τ from (memory, n, m, qpos, qvel, u, y, tau)."""


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

    Args:
        memory: the controller's block; its `jacobian` is the tool's, current (6, dofs).
        qpos: mjData.qpos.
        qvel: mjData.qvel.
        tool: position of the tool (3,) [m].
        orientation: of the tool (3, 3).
        ctrl: mjData.ctrl, written.
        command: sets y and τ: `standard`, `joint_space`, or a custom law's.
    """
    n = int(memory[Header.JOINTS])
    m = int(memory[Header.COORDINATES])
    step = int(memory[Header.STEP])
    columns = int(memory[Header.COLUMNS])
    qpos_address = vector(memory, Header.QPOS_ADDRESS, n)
    dof_address = vector(memory, Header.DOF_ADDRESS, n)
    actuator_id = vector(memory, Header.ACTUATOR_ID, n)
    y = vector(memory, Header.Y, n)
    tau = vector(memory, Header.TAU, n)
    q_c = vector(memory, Header.Q_C, n)
    k = vector(memory, Header.STIFFNESS, n)
    offset = vector(memory, Header.OFFSET, n)
    x_desired = vector(memory, Header.X_DESIRED, (step + 1) * m)[step * m :]
    u = vector(memory, Header.LEARNED, (step + 1) * n)[step * n :]
    row = vector(memory, Header.RECORD, (step + 1) * columns)[step * columns :]

    measure(memory, n, m, step, qvel, tool, orientation, x_desired, row[2 * n :])
    command(memory, n, m, qpos, qvel, u, y, tau)
    limit(memory, n, tau)

    torque_limit = vector(memory, Header.TORQUE_LIMIT, n)
    for j in range(n):
        speed = abs(qvel[int(dof_address[j])])
        spring = abs(springs.torque(k[j], offset[j], qpos[int(qpos_address[j])], q_c[j]))
        hardest = torque_limit[j]
        # Written so that what is not a number fails too.
        if not (
            speed <= memory[Header.SPEED_LIMIT] and abs(tau[j]) <= hardest and spring <= hardest
        ):
            memory[Header.FAILED_STEP] = step + 1
            memory[Header.FAILED_JOINT] = j
            return

    for j in range(n):
        q = qpos[int(qpos_address[j])]
        row[j] = q
        row[n + j] = qvel[int(dof_address[j])]
        row[2 * n + m + j] = y[j]
        row[3 * n + m + j] = tau[j]
        row[4 * n + m + j] = u[j]
        row[5 * n + m + j] = k[j]
        row[6 * n + m + j] = offset[j]
        ctrl[int(actuator_id[j])] = tau[j]
        adapt(memory, n, j, q, q_c[j], y[j], k, offset)


@step_function
def measure(
    memory: np.ndarray,
    n: int,
    m: int,
    step: int,
    qvel: np.ndarray,
    tool: np.ndarray,
    orientation: np.ndarray,
    x_desired: np.ndarray,
    x: np.ndarray,
) -> None:
    """Task Jacobian, position (to `x`), position error and rate of the tool, into the memory."""
    dof_address = vector(memory, Header.DOF_ADDRESS, n)
    coordinate = vector(memory, Header.COORDINATE, m)
    jacobian = matrix(memory, Header.JACOBIAN, 6, int(memory[Header.DOFS]))
    J = matrix(memory, Header.J, m, n)
    error = vector(memory, Header.ERROR, m)
    rate = vector(memory, Header.RATE, m)
    before = vector(memory, Header.BEFORE, 3)
    dx_desired = vector(memory, Header.DX_DESIRED, (step + 1) * m)[step * m :]
    for i in range(m):
        axis = int(coordinate[i])
        if axis < 3:
            x[i] = tool[axis]
            error[i] = tool[axis] - x_desired[i]
        rate[i] = -dx_desired[i]
        for j in range(n):
            dof = int(dof_address[j])
            J[i, j] = jacobian[axis, dof]
            rate[i] += J[i, j] * qvel[dof]
        if axis < 3 and memory[Header.DIFFERENCE] == 1.0:
            rate[i] = (tool[axis] - before[axis]) / memory[Header.TIMESTEP] - dx_desired[i]
            before[axis] = tool[axis]
    if memory[Header.ROTATES] == 1.0:
        home = matrix(memory, Header.ORIENTATION, 3, 3)
        desired = matrix(memory, Header.DESIRED, 3, 3)
        rotations.rotation(x_desired[m - 3 :], home, desired)
        rotations.rotation_vector(orientation, desired, error[m - 3 :])
        rotations.rotation_vector(orientation, home, x[m - 3 :])


@step_function
def standard(
    memory: np.ndarray,
    n: int,
    m: int,
    qpos: np.ndarray,
    qvel: np.ndarray,
    u: np.ndarray,
    y: np.ndarray,
    tau: np.ndarray,
) -> None:
    """Error signal y (8) and motor torque τ (4)."""
    alpha = memory[Header.ALPHA]
    form = memory[Header.FORM]
    J = matrix(memory, Header.J, m, n)
    error = vector(memory, Header.ERROR, m)
    rate = vector(memory, Header.RATE, m)
    s = vector(memory, Header.S, m)
    more = int(memory[Header.MORE])
    work = matrix(memory, Header.WORK, more, more)
    equations.saturation(error, s)
    if form == 0.0:
        equations.error_inverse(J, rate, alpha, s, work, y)
    elif form == 1.0:
        equations.error_transpose(J, rate, alpha, s, y)
    else:
        drift = vector(memory, Header.DRIFT, n)
        posture = vector(memory, Header.POSTURE, n)
        qpos_address = vector(memory, Header.QPOS_ADDRESS, n)
        dof_address = vector(memory, Header.DOF_ADDRESS, n)
        for j in range(n):
            away = qpos[int(qpos_address[j])] - posture[j]
            drift[j] = qvel[int(dof_address[j])] + memory[Header.ALPHA_0] * away
        equations.error_damped(J, rate, alpha, s, drift, memory[Header.USUAL], work, y)
    equations.motor_torque(
        J, vector(memory, Header.K_V, m), vector(memory, Header.K_P, m), rate, s, u, tau
    )
    if memory[Header.INERTIAL] == 1.0:
        equations.inertial_feedback(matrix(memory, Header.FEEDBACK, n, n), y, tau)


@step_function
def joint_space(
    memory: np.ndarray,
    n: int,
    m: int,
    qpos: np.ndarray,
    qvel: np.ndarray,
    u: np.ndarray,
    y: np.ndarray,
    tau: np.ndarray,
) -> None:
    """Error signal y = Δq̇ + α s(Δq) and motor torque τ = u - G Δq̇ - G_p s(Δq), given q_d."""
    step = int(memory[Header.STEP])
    alpha = memory[Header.ALPHA]
    qpos_address = vector(memory, Header.QPOS_ADDRESS, n)
    dof_address = vector(memory, Header.DOF_ADDRESS, n)
    q_desired = vector(memory, Header.Q_DESIRED, (step + 1) * n)[step * n :]
    dq_desired = vector(memory, Header.DQ_DESIRED, (step + 1) * n)[step * n :]
    G = matrix(memory, Header.FEEDBACK, n, n)
    G_p = matrix(memory, Header.FEEDBACK_P, n, n)
    error = vector(memory, Header.Q, n)
    rate = vector(memory, Header.DQ, n)
    s = vector(memory, Header.DRIFT, n)
    for j in range(n):
        error[j] = qpos[int(qpos_address[j])] - q_desired[j]
        rate[j] = qvel[int(dof_address[j])] - dq_desired[j]
    equations.saturation(error, s)
    for j in range(n):
        y[j] = rate[j] + alpha * s[j]
        tau[j] = u[j]
        for i in range(n):
            tau[j] -= G[j, i] * rate[i] + G_p[j, i] * s[i]


@step_function
def limit(memory: np.ndarray, n: int, tau: np.ndarray) -> None:
    """Keep the torque within the motors' limits."""
    tau_min = vector(memory, Header.TAU_MIN, n)
    tau_max = vector(memory, Header.TAU_MAX, n)
    for j in range(n):
        # What is not a number stays so, for the check that follows.
        if tau[j] < tau_min[j]:
            tau[j] = tau_min[j]
        elif tau[j] > tau_max[j]:
            tau[j] = tau_max[j]


@step_function
def adapt(
    memory: np.ndarray,
    n: int,
    j: int,
    q: float,
    q_c: float,
    y: float,
    k: np.ndarray,
    offset: np.ndarray,
) -> None:
    """One explicit Euler step of (6), (7) for joint `j`, kept within the springs' bounds."""
    gamma_k = vector(memory, Header.GAMMA_K, n)[j]
    gamma_qe = vector(memory, Header.GAMMA_QE, n)[j]
    if gamma_k == 0.0 and gamma_qe == 0.0:
        return
    timestep = memory[Header.TIMESTEP]
    new_k = k[j] + timestep * equations.stiffness_rate(gamma_k, q, q_c, y)
    new_offset = offset[j] + timestep * equations.offset_rate(gamma_qe, y)
    # The metric of the Lyapunov function (16); a gain of 0 stands for a very stiff direction.
    weight = max(gamma_qe, 1e-9) / max(gamma_k, 1e-9)
    k[j], offset[j] = springs.nearest(
        new_k,
        new_offset,
        vector(memory, Header.K_MIN, n)[j],
        vector(memory, Header.K_MAX, n)[j],
        vector(memory, Header.LOW, n)[j],
        vector(memory, Header.HIGH, n)[j],
        weight,
    )


@step_function
def end_stage(memory: np.ndarray, jnt_stiffness: np.ndarray, qpos_spring: np.ndarray) -> None:
    """Count this callback; after the last of a time step, write the springs into the model."""
    memory[Header.STAGE] += 1.0
    if memory[Header.STAGE] < memory[Header.STAGES]:
        return
    memory[Header.STAGE] = 0.0
    memory[Header.STEP] += 1.0
    write_springs(memory, jnt_stiffness, qpos_spring)


@step_function
def write_springs(memory: np.ndarray, jnt_stiffness: np.ndarray, qpos_spring: np.ndarray) -> None:
    """Rewrite mjModel's joint springs with the k and q̄_e of the memory."""
    n = int(memory[Header.JOINTS])
    joint_id = vector(memory, Header.JOINT_ID, n)
    qpos_address = vector(memory, Header.QPOS_ADDRESS, n)
    q_c = vector(memory, Header.Q_C, n)
    k = vector(memory, Header.STIFFNESS, n)
    offset = vector(memory, Header.OFFSET, n)
    for j in range(n):
        stiffness, angle = springs.equilibrium(k[j], offset[j], q_c[j])
        jnt_stiffness[int(joint_id[j])] = stiffness
        qpos_spring[int(qpos_address[j])] = angle


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
    qvel[:] = 0.0
    ctrl[:] = 0.0
    for force in forces:
        force[:] = 0.0
