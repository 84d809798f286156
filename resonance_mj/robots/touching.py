"""Which bodies of an arm touch which along a motion, how deep, and for what share of it."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np


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


def touching(
    model: mujoco.MjModel, qpos: np.ndarray, addresses: np.ndarray, positions: np.ndarray
) -> list[Touch]:
    """The pairs of bodies that touch along a motion, the one that touches longest first.

    None where contacts are switched off in the model.

    Args:
        model: of the arm.
        qpos: of the whole model, for what does not move (nq,).
        addresses: of the joints that move, in qpos (n,).
        positions: their joint angles, at each sample (N, n) [rad or m].
    """
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    depths: dict[tuple[str, str], dict[int, float]] = {}
    for sample, q in enumerate(positions):
        data.qpos[addresses] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_flex(model, data)
        mujoco.mj_collision(model, data)
        for contact in data.contact:
            if contact.exclude:
                continue
            geoms = sorted(contact.geom, key=lambda geom: model.geom_bodyid[geom])
            first, second = (_called(model, int(geom)) for geom in geoms)
            at = depths.setdefault((first, second), {})
            at[sample] = max(at.get(sample, 0.0), -float(contact.dist))
    found = [
        Touch(*pair, max(at.values()), len(at) / len(positions)) for pair, at in depths.items()
    ]
    return sorted(found, key=lambda touch: -touch.share)


def _called(model: mujoco.MjModel, geom: int) -> str:
    """What carries a geom; a cloth or rope, which has no geom, is one that bends."""
    if geom < 0:
        return "a flexible body"
    body = int(model.geom_bodyid[geom])
    return (model.geom(geom).name if body == 0 else "") or str(model.body(body).name)
