"""Which bodies of an arm touch which along a motion, how deep, and for what share of it."""

from typing import NamedTuple

import mujoco
import numpy as np

from ..text import length

PASSING = "robot.contacts = false, with which bodies pass through each other"
"""What cures a contact that is none of the real arm's."""

UNFELT = 1e-6
"""Depth up to which bodies lie on each other [m]."""


class Touch(NamedTuple):
    """Two bodies that touch along a motion.

    Attributes:
        first: name of the body nearer to the root; where the world touches, of its geom, or
            `world` if that has none.
        second: name of the other one.
        depth: deepest overlap [m].
        share: of the samples of the motion.
    """

    first: str
    second: str
    depth: float
    share: float

    def __str__(self) -> str:
        deep = f", {length(self.depth)} deep" if self.depth > UNFELT else ""
        return f"{self.first} touches {self.second}{deep}"


FAR = 3
"""What `distance` gives for bodies of which none is the other's neighbour."""


def distance(model: mujoco.MjModel, first: int, second: int) -> int:
    """How many joints' bodies lie from one geom to the other: 1 for parent and child, at most FAR.

    Of what does not move only the robot's own base is near, and what of the world is no ground.

    Args:
        model: of the arm, what is held welded to what holds it.
        first: id of a geom.
        second: id of the other one.
    """
    grounds = (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD))
    if min(first, second) < 0 or any(model.geom_type[geom] in grounds for geom in (first, second)):
        return FAR
    bodies = sorted(int(model.geom_bodyid[geom]) for geom in (first, second))
    near, far = (int(model.body_weldid[body]) for body in bodies)
    if near > far:
        near, far, bodies = far, near, bodies[::-1]
    if bodies[0] and model.body_rootid[bodies[0]] != model.body_rootid[bodies[1]]:
        return FAR
    for steps in range(1, FAR):
        far = int(model.body_weldid[model.body_parentid[far]])
        if far == near:
            return steps if bodies[0] or steps == 1 else FAR
    return FAR


def touching(model: mujoco.MjModel, positions: np.ndarray, clearance: float = 0.0) -> list[Touch]:
    """The pairs of bodies that touch along a motion, the one that touches longest first.

    None where contacts are switched off in the model.

    Args:
        model: of the arm.
        positions: qpos at each sample (N, nq) [rad or m].
        clearance: distance below which bodies count as touching [m]; 0 for the file's own margins.
    """
    data = mujoco.MjData(model)
    depths: dict[tuple[str, str], dict[int, float]] = {}
    margin, flags = model.opt.o_margin, model.opt.enableflags
    if clearance:
        model.opt.o_margin = clearance
        model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_OVERRIDE
    try:
        for sample, q in enumerate(positions):
            data.qpos[:] = q
            for first, second, depth in contacts(model, data):
                at = depths.setdefault((called(model, first), called(model, second)), {})
                at[sample] = max(at.get(sample, 0.0), depth)
    finally:
        model.opt.o_margin, model.opt.enableflags = margin, flags
    found = [
        Touch(*pair, max(at.values()), len(at) / len(positions)) for pair, at in depths.items()
    ]
    return sorted(found, key=lambda touch: -touch.share)


def contacts(model: mujoco.MjModel, data: mujoco.MjData) -> list[tuple[int, int, float]]:
    """Ids of the two geoms of each contact in a pose, first that of the body nearer to the root.

    With each the depth [m].
    """
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_flex(model, data)
    mujoco.mj_collision(model, data)
    found = []
    # To ask for data.contact takes thirty times longer than to find that there is none.
    for contact in data.contact if data.ncon else ():
        if not contact.exclude:
            first, second = sorted(map(int, contact.geom), key=lambda geom: model.geom_bodyid[geom])
            found.append((first, second, max(0.0, -float(contact.dist))))
    return found


def called(model: mujoco.MjModel, geom: int) -> str:
    """What carries a geom; a cloth or rope, which has no geom, is one that bends."""
    if geom < 0:
        return "a flexible body"
    body = int(model.geom_bodyid[geom])
    return (model.geom(geom).name if body == 0 else "") or str(model.body(body).name)
