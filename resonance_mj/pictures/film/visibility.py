"""An arm of which a picture would show nothing is shown all the same."""

from collections.abc import Callable
from itertools import pairwise

import mujoco
import numpy as np

SHOWN = np.flatnonzero(mujoco.MjvOption().geomgroup)
"""The groups of geoms that MuJoCo shows unless it is told otherwise."""
NOTHING = np.array([0.5, 0.5, 0.5, 1.0], np.float32)
"""MuJoCo's colour of a geom that has none, which lets its material's through."""


def show_arm(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    site: str,
    note: Callable[[str], None],
) -> bool:
    """Change a spec so that something of the arm is seen; returns whether that was needed.

    Args:
        spec: of the arm.
        model: compiled from it.
        joints: names of its joints, from the world to the tool.
        site: name of the tool's site.
        note: is called with a line on what was done.
    """
    moving = np.flatnonzero(model.body_weldid[model.geom_bodyid] > 0)
    solid = [i for i in moving if _opacity(model, i) > 0]
    if any(model.geom_group[i] in SHOWN for i in solid):
        return False
    if solid:
        groups = sorted(set(model.geom_group[solid].tolist()))
        note(f"all of the arm is in geom groups that are hidden: {groups} are shown")
        for i in solid:
            spec.geoms[i].group = 0
    else:
        note("the arm has no geom that could be seen: it is drawn as lines between its joints")
        _add_lines(spec, model, joints, site)
    return True


def _opacity(model: mujoco.MjModel, geom: np.integer) -> float:
    material = model.geom_matid[geom]
    own = material < 0 or (model.geom_rgba[geom] != NOTHING).any()
    return float((model.geom_rgba[geom] if own else model.mat_rgba[material])[3])


def _add_lines(
    spec: mujoco.MjSpec, model: mujoco.MjModel, joints: tuple[str, ...], site: str
) -> None:
    """A capsule from each joint to the next, and from the last to the tool."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    ids = [model.joint(name).id for name in joints]
    points = np.array([*data.xanchor[ids], data.site_xpos[model.site(site).id]])
    radius = 0.04 * np.linalg.norm(np.diff(points, axis=0), axis=1).sum() / np.sqrt(len(ids))
    for joint, (start, end) in zip(ids, pairwise(points), strict=True):
        body = int(model.jnt_bodyid[joint])
        ends = (np.stack([start, end]) - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
        apart = np.linalg.norm(end - start) > 1e-6
        spec.body(model.body(body).name).add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE if apart else mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[radius, 0, 0],
            **({"fromto": ends.ravel()} if apart else {"pos": ends[0]}),
            mass=0,
            contype=0,
            conaffinity=0,
        )
