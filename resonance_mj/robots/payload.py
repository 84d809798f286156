"""What the tool carries: a point mass at its site, of another size in each motion."""

import copy

import mujoco
import numpy as np

from .names import free

BODY = "payload"
"""Name of the body that is the payload, with as many underscores as it takes to be a new one."""


def add(spec: mujoco.MjSpec, tool: str, point: np.ndarray) -> str:
    """Add a body without mass at the tool's site, to be given one by `carrying`.

    Args:
        spec: of the robot, changed.
        tool: the site's name.
        point: where the site is in its body (3,) [m].

    Returns:
        The body's name.
    """
    name = free(BODY, spec.body)
    body = spec.site(tool).parent.add_body(name=name, pos=point)
    body.explicitinertial, body.mass, body.ipos = True, 0.0, [0.0, 0.0, 0.0]
    return name


def carrying(model: mujoco.MjModel, body: int, mass: float) -> mujoco.MjModel:
    """A copy of a model with a payload.

    Args:
        model: compiled from a spec that `add` has changed.
        body: id of the payload's body.
        mass: its mass [kg].
    """
    loaded = copy.copy(model)
    loaded.body_mass[body] = mass
    loaded.body_inertia[body] = 0.0
    # What MuJoCo derives from masses: those of subtrees, and how light each joint is.
    mujoco.mj_setConst(loaded, mujoco.MjData(loaded))
    return loaded
