"""Which of the joints between the world and the tool move; the others are held, with a reason."""

from pathlib import Path

import mujoco
import numpy as np

from ..errors import RobotError
from ..text import Note, listed, shown
from . import chain, couplings


def joints(
    model: mujoco.MjModel,
    path_to_tool: list[int],
    given: tuple[str, ...] | None,
    path: Path,
    notes: list[str],
) -> list[int]:
    """Ids of the joints that move the tool.

    Args:
        model: of the file.
        path_to_tool: ids of the joints between the world and the tool.
        given: names of those that move; None for all that an arm on a fixed base drives.
        path: of the file.
        notes: get a line for each reason to hold some.

    Raises:
        RobotError: one that is given is not between the world and the tool.
    """
    names = {j: model.joint(j).name for j in path_to_tool}
    held = [j for j in path_to_tool if chain.floats(model, j)]
    if held:
        notes.append(f"the base floats on joint {names[held[0]]} and is held (robot.base)")
    rest = [j for j in path_to_tool if j not in held]
    if given is not None:
        unknown = [name for name in given if name not in [names[j] for j in rest]]
        if unknown:
            raise RobotError(
                f"{path}: robot.joints = {shown(given)}: {shown(unknown[0])} is no joint that can "
                f"move the tool; those are: {listed(names[j] for j in rest)}"
            )
        return [j for j in rest if names[j] in given]
    base = chain.mobile_base(model, rest)
    if base:
        notes.append(
            Note(
                f"joints {listed(names[j] for j in base)} move the arm's base and are held",
                "; robot.joints takes them in",
            )
        )
        rest = rest[len(base) :]
    driven = _driven(model)
    follow = couplings.dependent(model, rest, driven)
    rest = [j for j in rest if j not in follow]
    idle = [j for j in rest if j not in driven]
    if idle and len(idle) < len(rest):
        notes.append(
            Note(
                f"joints {listed(names[j] for j in idle)} are turned by no actuator of the file "
                "and are held",
                "; robot.joints takes them in",
            )
        )
        rest = [j for j in rest if j in driven]
    return rest


def _driven(model: mujoco.MjModel) -> set[int]:
    """Ids of the joints that an actuator of the file acts on, itself or through a tendon."""
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    rows = [
        slice(first, first + count)
        for first, count in zip(data.moment_rowadr, data.moment_rownnz, strict=True)
    ]
    reached = [data.moment_colind[row][data.actuator_moment[row] != 0.0] for row in rows]
    return set(model.dof_jntid[np.concatenate([[], *reached]).astype(int)].tolist())
