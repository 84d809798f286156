"""The controller's block as a control step sees it: `own.tau_min[j]`, `own.alpha`, a row to record.

Compiled, building the views costs nothing but what is used of them.
"""

from collections import namedtuple
from typing import Any

import numpy as np

from ..step_functions import step_function
from .memory import ARRAYS, COLUMNS, SIGNATURE, Header


@step_function
def block(userdata: np.ndarray) -> np.ndarray:
    """The controller's block of `userdata`; empty if the model has none.

    The callback is called for every model that the process steps, forwards or compiles.
    """
    end = userdata.size - 2
    if end < 0 or userdata[end + 1] != SIGNATURE:
        return userdata[:0]
    return userdata[int(userdata[end]) : end]


def vector(memory: np.ndarray, start: float, size: int) -> np.ndarray:
    """View of `size` numbers of the block from `start`."""
    return memory[int(start) : int(start) + size]


def matrix(memory: np.ndarray, start: float, rows: int, columns: int) -> np.ndarray:
    """View of numbers of the block from `start`, as (rows, columns)."""
    return memory[int(start) : int(start) + rows * columns].reshape(rows, columns)


_named: Any = namedtuple  # whose names a type checker cannot follow

_NUMBERS = (
    "n m dofs step site rotates form difference inertial usual length alpha alpha_0 timestep "
    "filtered slots delay torque_delay hold resolution differs clock"
)
_VIEWS = [name for name in ARRAYS if name != "record"]
Own = _named("Own", [*_NUMBERS.split(), "speed_limit", *_VIEWS])
"""The numbers of the header that the law is tuned by, and a view of each array."""

Row = _named("Row", list(COLUMNS))
"""What a control step records."""


@step_function
def own(memory: np.ndarray) -> Any:
    """The block as a control step sees it, and of the tables over the cycle this step's rows."""
    n, m = int(memory[Header.JOINTS]), int(memory[Header.COORDINATES])
    step, more = int(memory[Header.STEP]), int(memory[Header.MORE])
    slots, dofs = int(memory[Header.SLOTS]), int(memory[Header.DOFS])
    return Own(
        n=n,
        m=m,
        dofs=dofs,
        step=step,
        site=int(memory[Header.SITE]),
        rotates=memory[Header.ROTATES] == 1.0,
        form=int(memory[Header.FORM]),
        difference=memory[Header.DIFFERENCE] == 1.0,
        inertial=memory[Header.INERTIAL] == 1.0,
        usual=memory[Header.USUAL],
        length=memory[Header.LENGTH],
        alpha=memory[Header.ALPHA],
        alpha_0=memory[Header.ALPHA_0],
        timestep=memory[Header.TIMESTEP],
        filtered=memory[Header.FILTERED],
        slots=slots,
        delay=int(memory[Header.DELAY]),
        torque_delay=int(memory[Header.TORQUE_DELAY]),
        hold=int(memory[Header.HOLD]),
        resolution=memory[Header.RESOLUTION],
        differs=memory[Header.DIFFERS] == 1.0,
        clock=int(memory[Header.CLOCK]),
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
        jacobian=matrix(memory, memory[Header.JACOBIAN], 6, dofs),
        leader=vector(memory, memory[Header.LEADER], dofs),
        ratio=vector(memory, memory[Header.RATIO], dofs),
        qvel_seen=vector(memory, memory[Header.QVEL_SEEN], dofs),
        tool_seen=vector(memory, memory[Header.TOOL_SEEN], 3),
        orientation_seen=matrix(memory, memory[Header.ORIENTATION_SEEN], 3, 3),
        ring=matrix(memory, memory[Header.RING], slots, n + 7 * dofs + 12),
        torques=matrix(memory, memory[Header.TORQUES], slots, n),
        noise=vector(memory, memory[Header.NOISE] + step * n, n),
        angle=vector(memory, memory[Header.ANGLE], n),
        speed=vector(memory, memory[Header.SPEED], n),
        angle_before=vector(memory, memory[Header.ANGLE_BEFORE], n),
        seen=vector(memory, memory[Header.SEEN], n),
        commanded=vector(memory, memory[Header.COMMANDED], n),
        stiffness_step=vector(memory, memory[Header.STIFFNESS_STEP], n),
        offset_step=vector(memory, memory[Header.OFFSET_STEP], n),
        slow=vector(memory, memory[Header.SLOW], n),
        slower=vector(memory, memory[Header.SLOWER], n),
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
