"""The section [springs]: what the springs can be, how they start, and elements besides them."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from ..text import shown
from .sections import Alone, Angles, Bound, Finite, Gain, Name, Positive, Section, Stiffness


class _Bounds(Section):
    """What a spring can be."""

    @field_validator("stiffness", "equilibrium", check_fields=False)
    @classmethod
    def _interval(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is None:
            return value
        lower, upper = value
        if not lower <= upper or lower == math.inf or upper == -math.inf:
            raise ValueError("[lower, upper] with lower <= upper is needed, inf for no bound")
        return value


class JointSpring(_Bounds):
    """The spring of one joint, where it is another than all others."""

    kind: Literal["adjustable", "none"] = "adjustable"
    """adjustable, or none: the joint has no spring."""
    stiffness: tuple[Bound, Bound] | None = None
    """Bounds of its stiffness [N m/rad], equal ones for a given stiffness; as of all if not
    given."""
    equilibrium: tuple[Bound, Bound] | None = None
    """Bounds of its equilibrium angle [rad], about what springs.equilibrium_about says; as of all
    if not given."""
    rest: Finite | None = None
    """Its given equilibrium angle [rad], the joint's own: only the stiffness is adjusted."""

    @model_validator(mode="after")
    def _one_spring(self) -> JointSpring:
        if self.kind == "none" and (self.stiffness, self.equilibrium, self.rest) != (None,) * 3:
            raise ValueError('kind = "none" has neither stiffness, equilibrium nor rest')
        if self.rest is not None and self.equilibrium is not None:
            raise ValueError("rest is the equilibrium: give it or bounds of the equilibrium")
        return self


class Element(_Bounds):
    """An elastic element over one joint or more; its length is the sum of radius times angle."""

    name: Name = ""
    """What it is called; its joints if not given."""
    kind: Literal["linear", "cubic", "above", "below", "antagonistic"] = "linear"
    """linear; cubic: it stiffens or softens; above, below: it pulls only beyond its rest length, or
    only short of it, and two of them are a spring with two slopes; antagonistic: two tendons that
    stiffen and pull against each other, whose rest lengths are adjusted."""
    joints: Annotated[tuple[Name, ...], Field(min_length=1), Alone] | None = None
    """The joints that it acts on. Over a single joint it takes the place of that joint's spring,
    unless springs.joint.NAME says what that is."""
    radii: Annotated[tuple[Finite, ...], Field(min_length=1), Alone] | None = None
    """Of its pulleys, one per joint [m], or 1 each for a length in radians; of either sign."""
    tendon: Name | None = None
    """A fixed tendon of the robot's file in place of joints and radii; what is not given of its
    stiffness and rest is as there."""
    stiffness: tuple[Bound, Bound] | None = None
    """Bounds of its stiffness, of a cubic one's wherever its joints can go; [0, inf] if not
    given."""
    rest: Finite | tuple[Bound, Bound] | None = None
    """Its rest length, or bounds of it; found if not given, above and below the length at home."""
    pull: tuple[Gain, Positive] | None = None
    """Of an antagonistic pair, a and b [N/m, N/m²]: each tendon pulls with a x + b x² where it is
    stretched by x. The pair has a stiffness of 2 a or more."""
    pretension: Gain = 0.0
    """Of an antagonistic pair, what each tendon pulls with at least along the motion [N]."""
    holding: Gain = 0.0
    """Of an antagonistic pair, the power that an actuator takes to hold a tension, over its square
    [W/N²]; 0 for one that locks."""

    @property
    def called(self) -> str:
        """Its name."""
        return self.name or self.tendon or "-".join(self.joints or ())

    @model_validator(mode="after")
    def _one_element(self) -> Element:
        if (self.joints is None) == (self.tendon is None):
            raise ValueError("give either joints, the names of those that it acts on, or tendon")
        if self.radii is not None:
            if self.joints is None or len(self.radii) != len(self.joints):
                raise ValueError(
                    f"radii = {shown(self.radii)}: one per joint is needed, "
                    f"{len(self.joints or ())} of them"
                )
            if not all(self.radii):
                raise ValueError("a radius of 0: leave that joint out")
        if self.joints and len(set(self.joints)) < len(self.joints):
            raise ValueError("each joint may be named once")
        self._one_pair()
        if isinstance(self.rest, tuple):
            if self.kind not in ("linear", "antagonistic"):
                raise ValueError(f"rest = {list(self.rest)}: a {self.kind} element has a given one")
            if not (self.rest[0] <= self.rest[1] and all(map(math.isfinite, self.rest))):
                raise ValueError("rest = [lower, upper] with two finite numbers is needed")
        if self.rest is not None and self.kind == "linear" and (self.stiffness or (0,))[0] < 0:
            raise ValueError(
                f"rest needs stiffness >= 0, and the lower bound of stiffness is "
                f"{(self.stiffness or (0.0,))[0]:g}: with both signs what it may be is not convex"
            )
        return self

    def _one_pair(self) -> None:
        if self.kind != "antagonistic":
            for name in ("pull", "pretension", "holding"):
                if getattr(self, name):
                    raise ValueError(f'{name} is of a pair: kind = "antagonistic" is needed')
            return
        if self.pull is None:
            raise ValueError(
                "an antagonistic pair needs pull = [a, b] [N/m, N/m²] of its tendons, each of "
                "which pulls with a x + b x² where it is stretched by x"
            )
        if self.joints is None or len(self.joints) > 1:
            raise ValueError('an antagonistic pair is over one joint: joints = "NAME" is needed')
        if self.stiffness is not None and self.stiffness[1] <= 2 * self.pull[0]:
            raise ValueError(
                f"stiffness = {shown(self.stiffness)}: two tendons of {self.pull[0]:g} N/m have "
                f"{2 * self.pull[0]:g} together, and more where they are pulled in"
            )


class Springs(_Bounds):
    """What the springs can do, and how they start."""

    stiffness: tuple[Bound, Bound] = (0.0, math.inf)
    """Bounds of the stiffness [N m/rad]."""
    equilibrium: tuple[Bound, Bound] = (-math.pi, math.pi)
    """Bounds of the equilibrium angle q_e [rad], about what equilibrium_about says."""
    equilibrium_about: Literal["center", "zero"] = "center"
    """center: the bounds are of q_e - q_c, where q_c is the mean joint angle or law.q_c; zero: of
    q_e itself, the joint's own angle, as those of a device are."""
    initial_stiffness: Stiffness | tuple[Stiffness, ...] = 0.0
    """k(0) [N m/rad], one for all joints or one each; 0 for the softest within the bounds."""
    initial_equilibrium: Angles = 0.0
    """q_e(0) [rad], one for all joints or one each; 0 for the nearest to it within the bounds."""
    cost: Literal["torque-squared", "copper", "energy", "peak"] = "torque-squared"
    """What the springs leave the least of: torque-squared, the mean of τᵀτ; copper, the heat in
    the motors' windings; energy, what the motors take from their supply; peak, the largest torque
    of a motor, of its rated one. [motors] says what the motors are."""
    weights: Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    """Weight of each joint's torque² in what the springs leave least of, such as 1 / k_m² for the
    loss in copper of motors with k_m N m per root of a watt; 1 each if not given. Springs of single
    joints are the same for all weights; elements over several joints are not."""
    joint: dict[Name, JointSpring] = Field(default={})
    """Springs of single joints by name, as the table [springs.joint.NAME]."""
    element: Annotated[tuple[Element, ...], Field(max_length=100)] = ()
    """Elastic elements over any joints, a table [[springs.element]] each."""

    @property
    def about_zero(self) -> bool:
        """Whether the bounds of the equilibrium are of the joint's own angle."""
        return self.equilibrium_about == "zero"

    @property
    def elements(self) -> tuple[()]:
        """None, as bounds of any arm's springs: elements are on the joints of one."""
        return ()

    @property
    def objective(self) -> None:
        """Torque², likewise: other costs are of the motors of one."""

    @property
    def material(self) -> None:
        """None, likewise: `[reality]` has that of one."""

    @property
    def resolution(self) -> float:
        """Any stiffness, likewise."""
        return 0.0

    @model_validator(mode="after")
    def _names_differ(self) -> Springs:
        names = [one.called for one in self.element]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"several elements are called {name!r}: give each a name")
        return self

    @model_validator(mode="after")
    def _starts_inside(self) -> Springs:
        lower, upper = self.stiffness
        given = self.initial_stiffness
        every = given if isinstance(given, tuple) else (given,)
        if any(k and not lower <= k <= upper for k in every):
            raise ValueError(
                f"initial_stiffness = {shown(given)} is outside the bounds, stiffness = "
                f"{shown(self.stiffness)}: give a stiffness inside"
            )
        return self

    @model_validator(mode="after")
    def _convex(self) -> Springs:
        each: dict[str, Any] = {
            f"joint.{name}.": one for name, one in self.joint.items() if one.kind != "none"
        }
        for where, one in ({"": self} | each).items():
            stiffness = one.stiffness or self.stiffness
            rest = getattr(one, "rest", None)
            equilibrium = one.equilibrium or self.equilibrium if rest is None else (rest, rest)
            if not any(map(math.isfinite, equilibrium)):
                continue
            name = f"{where}{'rest' if rest is not None else 'equilibrium'}"
            value = rest if rest is not None else list(equilibrium)
            if stiffness[0] < 0:
                raise ValueError(
                    f"{name} = {value} needs stiffness >= 0, and the lower bound of stiffness is "
                    f"{stiffness[0]:g}: with both signs the springs' feasible set is not convex"
                )
            if not all(map(math.isfinite, equilibrium)):
                raise ValueError(
                    f"{name} = {value}: give two finite bounds, or none as [-inf, inf]"
                )
        return self
