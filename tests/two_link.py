"""The paper's arm in closed form, from its own mechanics (Sec. VI-A) and from nothing of MuJoCo.

q1 is measured from the x axis towards y, q2 from the first link; gravity points along -y. Every
function takes angles (..., 2) and works along the leading axes. The package's model lies in the
vertical plane of MuJoCo's world: the paper's (x, y) are the model's (x, z).
"""

import numpy as np

M1, M2 = 3.0, 2.0  # [kg]
L1, L2 = 0.3, 0.25  # [m]
LG1, LG2 = 0.13, 0.1  # joint to centre of mass [m]
I1, I2 = 0.01, 0.005  # about the centre of mass [N m s^2/rad]
D = np.array([0.2, 0.1])  # viscosity [N m s/rad]
G = 9.8  # [m/s^2]


def inertia(q):
    """R(q) (..., 2, 2) [kg m^2]: two rigid links, each m v²/2 + I ω²/2."""
    coupling = M2 * L1 * LG2 * np.cos(q[..., 1])
    distal = I2 + M2 * LG2**2
    R = np.empty((*q.shape[:-1], 2, 2))
    R[..., 0, 0] = I1 + M1 * LG1**2 + M2 * L1**2 + distal + 2 * coupling
    R[..., 0, 1] = R[..., 1, 0] = distal + coupling
    R[..., 1, 1] = distal
    return R


def coriolis(q, dq):
    """(Ṙ/2 + S) q̇ (..., 2) [N m]: centrifugal and Coriolis torque."""
    h = M2 * L1 * LG2 * np.sin(q[..., 1])
    first = -h * (2 * dq[..., 0] * dq[..., 1] + dq[..., 1] ** 2)
    return np.stack([first, h * dq[..., 0] ** 2], axis=-1)


def gravity(q):
    """g(q) (..., 2) [N m]: the gradient of `potential`."""
    second = M2 * LG2 * G * np.cos(q[..., 0] + q[..., 1])
    return np.stack([(M1 * LG1 + M2 * L1) * G * np.cos(q[..., 0]) + second, second], axis=-1)


def potential(q):
    """Potential energy of gravity (...) [J]."""
    first, both = np.sin(q[..., 0]), np.sin(q[..., 0] + q[..., 1])
    return G * ((M1 * LG1 + M2 * L1) * first + M2 * LG2 * both)


def kinetic(q, dq):
    """Kinetic energy (...) [J]."""
    return 0.5 * np.einsum("...i,...ij,...j->...", dq, inertia(q), dq)


def inverse_dynamics(q, dq, ddq):
    """Torque of motors and springs together that makes the motion, (2) (..., 2) [N m]."""
    inertial = np.einsum("...ij,...j->...i", inertia(q), ddq)
    return inertial + coriolis(q, dq) + D * dq + gravity(q)


def forward_dynamics(q, dq, torque):
    """Acceleration under a torque of motors and springs together, (1) (..., 2) [rad/s^2]."""
    left = torque - coriolis(q, dq) - D * dq - gravity(q)
    return np.linalg.solve(inertia(q), left[..., None])[..., 0]


def position(q):
    """Tip x = f(q) (..., 2) [m], Sec. VI-A."""
    first, both = q[..., 0], q[..., 0] + q[..., 1]
    return np.stack(
        [L1 * np.cos(first) + L2 * np.cos(both), L1 * np.sin(first) + L2 * np.sin(both)], axis=-1
    )


def jacobian(q):
    """J(q) = ∂f/∂q (..., 2, 2) [m/rad]."""
    first, both = q[..., 0], q[..., 0] + q[..., 1]
    J = np.empty((*q.shape[:-1], 2, 2))
    J[..., 0, 0] = -L1 * np.sin(first) - L2 * np.sin(both)
    J[..., 0, 1] = -L2 * np.sin(both)
    J[..., 1, 0] = L1 * np.cos(first) + L2 * np.cos(both)
    J[..., 1, 1] = L2 * np.cos(both)
    return J


def jacobian_rate(q, dq):
    """dJ/dt along a motion (..., 2, 2) [m/rad/s]."""
    first, both = q[..., 0], q[..., 0] + q[..., 1]
    d_first, d_both = dq[..., 0], dq[..., 0] + dq[..., 1]
    rate = np.empty((*q.shape[:-1], 2, 2))
    rate[..., 0, 0] = -L1 * np.cos(first) * d_first - L2 * np.cos(both) * d_both
    rate[..., 0, 1] = -L2 * np.cos(both) * d_both
    rate[..., 1, 0] = -L1 * np.sin(first) * d_first - L2 * np.sin(both) * d_both
    rate[..., 1, 1] = -L2 * np.sin(both) * d_both
    return rate


def inverse_kinematics(x):
    """Joint angles (..., 2) [rad] of the branch q2 < 0, with q1 in [0, 2π)."""
    cosine = ((x**2).sum(axis=-1) - L1**2 - L2**2) / (2 * L1 * L2)
    q2 = -np.arccos(cosine)
    bend = np.arctan2(L2 * np.sin(q2), L1 + L2 * np.cos(q2))
    q1 = np.arctan2(x[..., 1], x[..., 0]) - bend
    return np.stack([np.mod(q1, 2 * np.pi), q2], axis=-1)


def joint_motion(x, dx, ddx):
    """q, q̇, q̈ (..., 2) of a motion of the tip, on the branch q2 < 0."""
    q = inverse_kinematics(x)
    J = jacobian(q)
    dq = np.linalg.solve(J, dx[..., None])[..., 0]
    drift = np.einsum("...ij,...j->...i", jacobian_rate(q, dq), dq)
    return q, dq, np.linalg.solve(J, (ddx - drift)[..., None])[..., 0]


def first_motion(t):
    """x_d, ẋ_d, ẍ_d (..., 2) of the paper's first motion, written out from Sec. VI-A."""
    w = 2 * np.pi
    x = np.stack([0.05 * np.sin(w * t) - 0.3, -0.2 * np.sin(w * t)], axis=-1)
    dx = np.stack([0.05 * w * np.cos(w * t), -0.2 * w * np.cos(w * t)], axis=-1)
    ddx = np.stack([-0.05 * w**2 * np.sin(w * t), 0.2 * w**2 * np.sin(w * t)], axis=-1)
    return x, dx, ddx


def second_motion(t):
    """x_d, ẋ_d, ẍ_d (..., 2) of the paper's second motion, written out from Sec. VI-A."""
    w = 2 * np.pi
    x = np.stack([0.1 * np.sin(w * t) - 0.2, 0.1 * np.cos(2 * w * t) + 0.2], axis=-1)
    dx = np.stack([0.1 * w * np.cos(w * t), -0.2 * w * np.sin(2 * w * t)], axis=-1)
    ddx = np.stack([-0.1 * w**2 * np.sin(w * t), -0.4 * w**2 * np.cos(2 * w * t)], axis=-1)
    return x, dx, ddx
