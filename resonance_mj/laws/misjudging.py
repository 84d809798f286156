"""The arm as a controller takes it to be whose dimensions are not quite the arm's.

What lies between a joint and the next, or the tool, it takes for longer by a share, and the tool
for elsewhere on the last link. Orientations and the joints' axes are as they are, so that a column
of its Jacobian is off by the axis times what is off between that joint and the tool.
"""

import numpy as np

from ..step_functions import step_function
from .views import own as views


@step_function
def misjudge(
    memory: np.ndarray,
    qpos: np.ndarray,
    anchor: np.ndarray,
    tool: np.ndarray,
    orientation: np.ndarray,
) -> None:
    """Put the tool where the controller takes it to be into the memory, and its Jacobian likewise.

    Args:
        memory: the controller's block; its `jacobian` is the tool's, rotation included.
        qpos: mjData.qpos.
        anchor: mjData.xanchor (joints of the model, 3) [m].
        tool: position of the tool (3,) [m].
        orientation: of the tool (3, 3).
    """
    own = views(memory)
    off, end, J = own.tool_taken, own.link_end, own.jacobian
    for i in range(3):
        off[i], end[i] = 0.0, tool[i]
        for k in range(3):
            off[i] += orientation[i, k] * own.tool_offset[k]
    for at in range(own.dofs - 1, -1, -1):
        if own.chain[at] < 0.0:
            continue
        joint, dof, travel = int(own.chain[at]), int(own.chain_dof[at]), 0.0
        if own.chain_slide[at] >= 0.0:  # a slide's own travel is measured, and no link's
            travel = qpos[int(own.chain_slide[at])] - own.chain_zero[at]
        for i in range(3):
            start = anchor[joint, i] + travel * J[i, dof]
            off[i] += own.link_error[at] * (end[i] - start)
            end[i] = anchor[joint, i]
        J[0, dof] += J[4, dof] * off[2] - J[5, dof] * off[1]
        J[1, dof] += J[5, dof] * off[0] - J[3, dof] * off[2]
        J[2, dof] += J[3, dof] * off[1] - J[4, dof] * off[0]
    for i in range(3):
        off[i] += tool[i]
        if own.clock == 0:
            own.before[i] = off[i]
