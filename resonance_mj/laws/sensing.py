"""What a real arm's law sees and when it acts: encoders, delays, a control period of its own.

The true state goes into a ring, from which the law is handed what was measured a delay ago; its
torques go through a second ring to the motors. Without imperfections none of this runs.
"""

import numpy as np

from ..step_functions import step_function
from .views import own as views


@step_function
def remember(
    memory: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    tool: np.ndarray,
    orientation: np.ndarray,
) -> None:
    """Put this step's true state into the ring; arguments as of `controller.act`."""
    own = views(memory)
    now, at = own.ring[own.clock % own.slots], own.n
    for j in range(own.n):
        now[j] = qpos[int(own.qpos_address[j])]
        now[at + 7 * own.dofs + 12 + j] = qpos[int(own.encoder_address[j])]
    for dof in range(own.dofs):
        now[at + dof] = qvel[dof]
        for i in range(6):
            now[at + own.dofs + 12 + i * own.dofs + dof] = own.jacobian[i, dof]
    at += own.dofs
    for i in range(3):
        now[at + i] = tool[i]
        for k in range(3):
            now[at + 3 + 3 * i + k] = orientation[i, k]


@step_function
def sense(memory: np.ndarray) -> None:
    """What is measured in this step, into the memory.

    Joint angles are those of a delay ago, of the rotors where gears give way, with noise and in
    steps of the encoders; the tool's place is where these put it: to first order about where it
    was, by the Jacobian there.
    """
    own = views(memory)
    n, dofs = own.n, own.dofs
    then = own.ring[max(own.clock - own.delay, 0) % own.slots]
    at = n + dofs
    for dof in range(dofs):
        own.qvel_seen[dof] = then[n + dof]
        for i in range(6):
            own.jacobian[i, dof] = then[at + 12 + i * dofs + dof]
    for i in range(3):
        own.tool_seen[i] = then[at + i]
        for k in range(3):
            own.orientation_seen[i, k] = then[at + 3 + 3 * i + k]
    for j in range(n):
        angle, dof = then[at + 12 + 6 * dofs + j] + own.noise[j], int(own.dof_address[j])
        own.qvel_seen[dof] = then[n + int(own.encoder_dof[j])]
        if own.resolution > 0.0:
            angle = own.resolution * np.floor(angle / own.resolution + 0.5)
        own.angle[j], own.seen[j] = angle, angle - then[j]
        if own.differs and own.clock > 0:
            own.qvel_seen[dof] = (angle - own.angle_before[j]) / (own.hold * own.timestep)
        own.speed[j] = own.qvel_seen[dof]
        own.angle_before[j] = angle
    for dof in range(dofs):
        away = 0.0
        if own.leader[dof] >= 0:
            leader = int(own.leader[dof])
            away = own.ratio[dof] * own.seen[leader]
            own.qvel_seen[dof] = own.ratio[dof] * own.speed[leader]
        for j in range(n):
            if int(own.dof_address[j]) == dof:
                away = own.seen[j]
        for i in range(3):
            own.tool_seen[i] += own.jacobian[i, dof] * away


@step_function
def exert(memory: np.ndarray) -> None:
    """Put the law's torque into the ring, and what the motors exert in this step into τ."""
    own = views(memory)
    then = own.clock - own.torque_delay
    for j in range(own.n):
        own.torques[own.clock % own.slots, j] = own.commanded[j]
        own.tau[j] = own.torques[then % own.slots, j] if then >= 0 else 0.0
