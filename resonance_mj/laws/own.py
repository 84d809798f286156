"""One robot's block of memory as a control step sees it: `own.tau_min[j]`, `own.alpha`.

Of the tables over the cycle it has the rows of this step. Compiled, building the views costs
nothing but what is used of them.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from ..step_functions import step_function
from .memory import ARRAYS, COLUMNS, Header, matrix, vector

SCALARS = (
    "n",
    "m",
    "step",
    "site",
    "rotates",
    "form",
    "difference",
    "inertial",
    "usual",
    "alpha",
    "alpha_0",
    "timestep",
    "speed_limit",
)

_named: Any = namedtuple  # whose names a type checker cannot follow

Own = _named("Own", [*SCALARS, *(name for name in ARRAYS if name != "record")])
"""The numbers of the header that the law is tuned by, and a view of each array."""

Row = _named("Row", list(COLUMNS))
"""What a control step records."""


@step_function
def own(memory: np.ndarray) -> Any:
    """The block as a control step sees it; compiled, it costs nothing but what is used of it."""
    n, m = int(memory[Header.JOINTS]), int(memory[Header.COORDINATES])
    step, more = int(memory[Header.STEP]), int(memory[Header.MORE])
    return Own(
        n=n,
        m=m,
        step=step,
        site=int(memory[Header.SITE]),
        rotates=memory[Header.ROTATES] == 1.0,
        form=int(memory[Header.FORM]),
        difference=memory[Header.DIFFERENCE] == 1.0,
        inertial=memory[Header.INERTIAL] == 1.0,
        usual=memory[Header.USUAL],
        alpha=memory[Header.ALPHA],
        alpha_0=memory[Header.ALPHA_0],
        timestep=memory[Header.TIMESTEP],
        speed_limit=memory[Header.SPEED_LIMIT],
        qpos_address=vector(memory, memory[Header.QPOS_ADDRESS], n),
        dof_address=vector(memory, memory[Header.DOF_ADDRESS], n),
        joint_id=vector(memory, memory[Header.JOINT_ID], n),
        actuator_id=vector(memory, memory[Header.ACTUATOR_ID], n),
        coordinate=vector(memory, memory[Header.COORDINATE], m),
        before=vector(memory, memory[Header.BEFORE], 3),
        orientation=matrix(memory, memory[Header.ORIENTATION], 3, 3),
        posture=vector(memory, memory[Header.POSTURE], n),
        k_v=vector(memory, memory[Header.K_V], m),
        k_p=vector(memory, memory[Header.K_P], m),
        gamma_k=vector(memory, memory[Header.GAMMA_K], n),
        gamma_qe=vector(memory, memory[Header.GAMMA_QE], n),
        feedback=matrix(memory, memory[Header.FEEDBACK], n, n),
        feedback_p=matrix(memory, memory[Header.FEEDBACK_P], n, n),
        q_c=vector(memory, memory[Header.Q_C], n),
        k_min=vector(memory, memory[Header.K_MIN], n),
        k_max=vector(memory, memory[Header.K_MAX], n),
        low=vector(memory, memory[Header.LOW], n),
        high=vector(memory, memory[Header.HIGH], n),
        parameters=vector(memory, memory[Header.PARAMETERS], int(memory[Header.PARAMETERS_GIVEN])),
        torque_limit=vector(memory, memory[Header.TORQUE_LIMIT], n),
        tau_min=vector(memory, memory[Header.TAU_MIN], n),
        tau_max=vector(memory, memory[Header.TAU_MAX], n),
        stiffness=vector(memory, memory[Header.STIFFNESS], n),
        offset=vector(memory, memory[Header.OFFSET], n),
        x_desired=vector(memory, memory[Header.X_DESIRED] + step * m, m),
        dx_desired=vector(memory, memory[Header.DX_DESIRED] + step * m, m),
        q_desired=vector(memory, memory[Header.Q_DESIRED] + step * n, n),
        dq_desired=vector(memory, memory[Header.DQ_DESIRED] + step * n, n),
        learned=vector(memory, memory[Header.LEARNED] + step * n, n),
        jacobian=matrix(memory, memory[Header.JACOBIAN], 6, int(memory[Header.DOFS])),
        J=matrix(memory, memory[Header.J], m, n),
        error=vector(memory, memory[Header.ERROR], m),
        rate=vector(memory, memory[Header.RATE], m),
        s=vector(memory, memory[Header.S], m),
        y=vector(memory, memory[Header.Y], n),
        tau=vector(memory, memory[Header.TAU], n),
        drift=vector(memory, memory[Header.DRIFT], n),
        q=vector(memory, memory[Header.Q], n),
        dq=vector(memory, memory[Header.DQ], n),
        desired=matrix(memory, memory[Header.DESIRED], 3, 3),
        work=matrix(memory, memory[Header.WORK], more, more),
    )


@step_function
def row(memory: np.ndarray, n: int, m: int, step: int) -> Any:
    """What this control step records."""
    start = memory[Header.RECORD] + step * memory[Header.COLUMNS]
    return Row(
        q=vector(memory, start, n),
        dq=vector(memory, start + n, n),
        x=vector(memory, start + 2 * n, m),
        y=vector(memory, start + 2 * n + m, n),
        tau=vector(memory, start + 3 * n + m, n),
        u=vector(memory, start + 4 * n + m, n),
        stiffness=vector(memory, start + 5 * n + m, n),
        offset=vector(memory, start + 6 * n + m, n),
    )
