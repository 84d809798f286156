"""What each joint's spring may be, and the elements besides."""

from typing import NamedTuple, Protocol

import numpy as np

from ..errors import ExperimentError
from ..experiments.springs_section import Springs
from ..text import listed, nearest
from .cost import Cost
from .elements import Element
from .material import Material


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

    @property
    def elements(self) -> tuple[Element, ...]:
        """Elastic elements besides the joints' own springs."""

    @property
    def weights(self) -> np.ndarray | tuple[float, ...] | None:
        """Of each joint's torque² in the cost (n,); None for 1 each."""

    @property
    def objective(self) -> Cost | None:
        """What is to be least; None for torque²."""

    @property
    def material(self) -> Material | None:
        """What the springs do besides Hooke's law; None for nothing."""

    @property
    def resolution(self) -> float:
        """Step in which stiffness is set [N m/rad]; 0 for any."""


class JointBounds(NamedTuple):
    """`Bounds` joint by joint, (n,) each."""

    stiffness: tuple[np.ndarray, np.ndarray]
    equilibrium: tuple[np.ndarray, np.ndarray]
    about_zero: np.ndarray
    elements: tuple[Element, ...] = ()
    weights: np.ndarray | None = None
    """Of each joint's torque² (n,); None for 1 each."""
    objective: Cost | None = None
    """What is to be least; None for torque²."""
    material: Material | None = None
    """What the springs do besides Hooke's law; None for nothing."""
    resolution: float = 0.0
    """Step in which stiffness is set [N m/rad]; 0 for any."""


UNBOUNDED = JointBounds(
    (np.array(0.0), np.array(np.inf)), (np.array(-np.inf), np.array(np.inf)), np.array(False)
)
"""Springs of any stiffness >= 0 and any equilibrium."""


def passive(bounds: JointBounds) -> JointBounds:
    """The same without springs of negative stiffness, where others are allowed."""
    least, most = bounds.stiffness
    return bounds._replace(stiffness=(np.where(most >= 0, np.maximum(least, 0.0), least), most))


def adjusted(bounds: Bounds, n: int) -> np.ndarray:
    """Which of n joints have a spring of their own that is more than one given spring (n,)."""
    (least, most), (low, high) = bounds.stiffness, bounds.equilibrium
    given = (np.asarray(least) == most) & ((np.asarray(most) == 0) | (np.asarray(low) == high))
    return np.broadcast_to(~given, n)


def steps(bounds: JointBounds, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The stiffnesses that can be set next below and next above given ones (n,)."""
    below = np.floor(stiffness / bounds.resolution) * bounds.resolution
    low, high = (np.clip(k, *bounds.stiffness) for k in (below, below + bounds.resolution))
    return low, high


def near(bounds: JointBounds, stiffness: np.ndarray, away: float) -> JointBounds:
    """The same with stiffnesses at most so far from given ones (n,), or as near as they allow."""
    least, most = (np.clip(stiffness + side * away, *bounds.stiffness) for side in (-1, 1))
    return bounds._replace(stiffness=(least, most))


def per_joint(
    springs: Springs, joints: tuple[str, ...], elements: tuple[Element, ...], source: str
) -> JointBounds:
    """The bounds of each joint's spring, with the elements.

    A joint without a spring has one that is bound to stiffness 0 about its centre, and a given rest
    angle is an equilibrium that is bound to it. An element over one joint is its spring, if that
    is not said.

    Args:
        springs: of the experiment.
        joints: names of the arm's joints.
        elements: on the arm.
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
    alone = np.sum([one.radii != 0 for one in elements if (one.radii != 0).sum() == 1], axis=0)
    rows = []
    for j, joint in enumerate(joints):
        own = springs.joint.get(joint)
        stiffness, equilibrium, zero = springs.stiffness, springs.equilibrium, springs.about_zero
        if own is None and np.any(alone) and alone[j]:
            stiffness, equilibrium, zero = (0.0, 0.0), (0.0, 0.0), False
        elif own is not None:
            stiffness, equilibrium = own.stiffness or stiffness, own.equilibrium or equilibrium
            if own.kind == "none":
                stiffness, equilibrium, zero = (0.0, 0.0), (0.0, 0.0), False
            elif own.rest is not None:
                equilibrium, zero = (own.rest, own.rest), True
        rows.append((*stiffness, *equilibrium, zero))
    weights = None if springs.weights is None else np.array(springs.weights)
    k_min, k_max, low, high, zero = np.array(rows, float).T
    return JointBounds((k_min, k_max), (low, high), zero.astype(bool), elements, weights)
