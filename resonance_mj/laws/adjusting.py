"""The springs in a control step: adapted by (6), (7), written into the model, and as they are.

Without gains of (6), (7) they stay as the law has set them between two cycles, or go on their way.
"""

import numpy as np

from ..springs import material
from ..springs import spring as springs
from ..step_functions import step_function
from . import equations
from .views import own as views


@step_function
def adapt(memory: np.ndarray, q: np.ndarray) -> None:
    """One explicit Euler step of (6), (7) at joint angles q (n,), within the springs' bounds.

    By motor torque, in place of y stands -τ: K̇ = -ε Ω Φ F of Nasiri et al., F the motors' torque.
    """
    own = views(memory)
    dt = own.timestep
    for j in range(own.n):
        gamma_k, gamma_qe = own.gamma_k[j], own.gamma_qe[j]
        y = own.y[j] if own.by_torque == 0.0 else -own.tau[j]
        if gamma_k == 0.0 and gamma_qe == 0.0:
            # On its way to where the law wants it, if its mechanism takes time.
            own.stiffness[j] += own.stiffness_step[j]
            own.offset[j] += own.offset_step[j]
            own.stiffness_step[j] *= own.ease
            own.offset_step[j] *= own.ease
            continue
        k_rate, offset_rate = equations.spring_rates(gamma_k, gamma_qe, q[j], own.q_c[j], y)
        k, offset = own.stiffness[j] + dt * k_rate, own.offset[j] + dt * offset_rate
        # The metric of the Lyapunov function (16); a gain of 0 stands for a very stiff direction.
        weight = max(gamma_qe, 1e-9) / max(gamma_k, 1e-9)
        own.stiffness[j], own.offset[j] = springs.nearest(
            k, offset, own.k_min[j], own.k_max[j], own.low[j], own.high[j], weight
        )


@step_function
def deviate(
    memory: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    jnt_stiffness: np.ndarray,
    qpos_spring: np.ndarray,
    qfrc_passive: np.ndarray,
) -> None:
    """Add what real springs exert besides MuJoCo's linear ones to its passive forces."""
    own = views(memory)
    if not own.material:
        return
    for j in range(own.n):
        k = jnt_stiffness[int(own.joint_id[j])]
        if abs(k) <= springs.LIMP:
            continue
        address, dof = int(own.qpos_address[j]), int(own.dof_address[j])
        x, v = qpos[address] - qpos_spring[address], qvel[dof]
        # Damping is MuJoCo's own, which it takes implicitly.
        phi = material.shape(x, v, own.spring_error[j], own.stiffening[j], own.hysteresis[j], 0.0)
        qfrc_passive[dof] -= k * (phi - x)


@step_function
def write_springs(
    memory: np.ndarray,
    jnt_stiffness: np.ndarray,
    qpos_spring: np.ndarray,
    dof_damping: np.ndarray,
) -> None:
    """Rewrite mjModel's joint springs with the k and q̄_e of the memory, and what they damp."""
    own = views(memory)
    for j in range(own.n):
        k, q_e = springs.equilibrium(own.stiffness[j], own.offset[j], own.q_c[j])
        jnt_stiffness[int(own.joint_id[j])] = k
        qpos_spring[int(own.qpos_address[j])] = q_e
        if own.material:
            dof_damping[int(own.dof_address[j])] = own.viscous[j] + own.damping[j] * k
