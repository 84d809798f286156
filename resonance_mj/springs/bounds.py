"""What each joint's spring may be."""

from typing import NamedTuple, Protocol

import numpy as np

from ..errors import ExperimentError
from ..experiments.sections import Springs
from ..text import listed, nearest


class Bounds(Protocol):
    """Bounds of springs, of all alike or joint by joint (n,)."""

    @property
    def stiffness(self) -> tuple[float | np.ndarray, float | np.ndarray]:
        """Least and greatest stiffness [N m/rad]."""

    @property
    def equilibrium(self) -> tuple[float | np.ndarray, float | np.ndarray]:
        """Least and greatest equilibrium angle [rad], of which `about_zero` says what about."""

    @property
    def about_zero(self) -> bool | np.ndarray:
        """Whether it is the joint's own angle, or else that from the springs' centre."""


class JointBounds(NamedTuple):
    """`Bounds` joint by joint, (n,) each."""

    stiffness: tuple[np.ndarray, np.ndarray]
    equilibrium: tuple[np.ndarray, np.ndarray]
    about_zero: np.ndarray


def per_joint(springs: Springs, joints: tuple[str, ...], source: str) -> JointBounds:
    """The bounds of each joint's spring.

    A joint without a spring has one that is bound to stiffness 0 about its centre, and a given rest
    angle is an equilibrium that is bound to it.

    Args:
        springs: of the experiment.
        joints: names of the arm's joints.
        source: what the error names.

    Raises:
        ExperimentError: a joint is named that the arm does not have.
    """
    for name in springs.joint:
        if name not in joints:
            raise ExperimentError(
                f"{source}: springs.joint.{name}: the arm has no such joint"
                f"{nearest(name, joints)}; its joints are {listed(joints)}"
            )
    rows = []
    for joint in joints:
        own = springs.joint.get(joint)
        stiffness, equilibrium, zero = springs.stiffness, springs.equilibrium, springs.about_zero
        if own is not None:
            stiffness, equilibrium = own.stiffness or stiffness, own.equilibrium or equilibrium
            if own.kind == "none":
                stiffness, equilibrium, zero = (0.0, 0.0), (0.0, 0.0), False
            elif own.rest is not None:
                equilibrium, zero = (own.rest, own.rest), True
        rows.append((*stiffness, *equilibrium, zero))
    k_min, k_max, low, high, zero = np.array(rows, float).T
    return JointBounds((k_min, k_max), (low, high), zero.astype(bool))
