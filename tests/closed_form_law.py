"""The paper's arm under the paper's law, step by step in plain Python: no MuJoCo, no package.

The arm is that of `two_link`, written out for speed, under a semi-implicit Euler step with the
viscosity taken implicitly; the law is (4)-(10), sampled and held over a time step.
"""

import math

import numpy as np
import two_link
from two_link import I2, L1, L2, LG1, LG2, M1, M2, D, G

DT, STEPS = 1e-3, 1000
FAR = two_link.I1 + M1 * LG1**2 + M2 * L1**2 + I2 + M2 * LG2**2
NEAR = I2 + M2 * LG2**2
REACH = M2 * L1 * LG2


def springs(k, b, q, q_c):
    return [b[j] - k[j] * (q[j] - q_c[j]) for j in (0, 1)]


def stepped(q, dq, torque):
    """State a time step later under a constant torque: (R + dt D) q̈ = torque - ... at its start."""
    sine, cosine = math.sin(q[1]), math.cos(q[1])
    outer = M2 * LG2 * G * math.cos(q[0] + q[1])
    left = [
        torque[0] + REACH * sine * (2 * dq[0] * dq[1] + dq[1] ** 2) - D[0] * dq[0]
        - (M1 * LG1 + M2 * L1) * G * math.cos(q[0]) - outer,
        torque[1] - REACH * sine * dq[0] ** 2 - D[1] * dq[1] - outer,
    ]  # fmt: skip
    a = FAR + 2 * REACH * cosine + DT * D[0]
    b, d = NEAR + REACH * cosine, NEAR + DT * D[1]
    det = a * d - b * b
    dq = [
        dq[0] + DT * (d * left[0] - b * left[1]) / det,
        dq[1] + DT * (a * left[1] - b * left[0]) / det,
    ]
    return [q[0] + DT * dq[0], q[1] + DT * dq[1]], dq


def simulate(motions, *, cycles, q_c, q_s, transpose=False):
    """The paper's simulation with its gains, from rest at the pose of (-0.3, 0) m.

    Args:
        motions: functions t -> x_d, ẋ_d, ẍ_d, each repeated with a period of 1 s.
        cycles: how often each is repeated.
        q_c: centre of the springs' regressor.
        q_s: centre of the learning's.
        transpose: Jᵀ in place of J⁻¹ in (8).

    Returns:
        For each motion, of its last cycle: k and q̄_e at the end (2,), the mean of τᵀτ and the RMS
        of the position error.
    """
    gamma_k, gamma_qe = (50.0, 5.0), (150.0, 10.0)
    q, dq = [4.00114, -2.00057], [0.0, 0.0]
    k, b = [0.0, 0.0], [0.0, 0.0]
    learned = [[0.0, 0.0]] * STEPS
    found = []
    for motion in motions:
        x_d, dx_d, _ = (part.tolist() for part in motion(np.arange(STEPS) * DT))
        for _ in range(cycles):
            angles, errors, squared, miss = [], [], 0.0, 0.0
            for i in range(STEPS):
                first, both = q[0], q[0] + q[1]
                s1, c1, s12, c12 = math.sin(first), math.cos(first), math.sin(both), math.cos(both)
                j11, j12 = -L1 * s1 - L2 * s12, -L2 * s12
                j21, j22 = L1 * c1 + L2 * c12, L2 * c12
                away = [L1 * c1 + L2 * c12 - x_d[i][0], L1 * s1 + L2 * s12 - x_d[i][1]]
                rate = [
                    j11 * dq[0] + j12 * dq[1] - dx_d[i][0],
                    j21 * dq[0] + j22 * dq[1] - dx_d[i][1],
                ]
                s = [math.sin(away[0]), math.sin(away[1])]  # errors stay below a quarter turn
                force = [200 * rate[0] + 2000 * s[0], 200 * rate[1] + 2000 * s[1]]
                u = learned[i]
                tau = [
                    u[0] - j11 * force[0] - j21 * force[1],
                    u[1] - j12 * force[0] - j22 * force[1],
                ]
                e = [rate[0] + 10 * s[0], rate[1] + 10 * s[1]]
                if transpose:
                    y = [j11 * e[0] + j21 * e[1], j12 * e[0] + j22 * e[1]]
                else:
                    det = j11 * j22 - j12 * j21
                    y = [(j22 * e[0] - j12 * e[1]) / det, (j11 * e[1] - j21 * e[0]) / det]
                angles.append(q)
                errors.append(y)
                squared += tau[0] ** 2 + tau[1] ** 2
                miss += away[0] ** 2 + away[1] ** 2
                spring = springs(k, b, q, q_c)
                k = [k[j] + DT * gamma_k[j] * (q[j] - q_c[j]) * y[j] for j in (0, 1)]
                b = [b[j] - DT * gamma_qe[j] * y[j] for j in (0, 1)]
                q, dq = stepped(q, dq, [tau[0] + spring[0], tau[1] + spring[1]])
            v = np.array(learned) - np.array(errors)
            q_bar = np.array(angles) - q_s
            learned = (v - (v * q_bar).sum(axis=0) / (q_bar**2).sum(axis=0) * q_bar).tolist()
        found.append((np.array(k), np.array(b), squared / STEPS, math.sqrt(miss / STEPS)))
    return found
