"""The section [reality]: what sensors, timing and joints of a real arm do that ideal ones don't."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ..text import listed, nearest, shown
from .sections import Gains, Positive, Section

Share = Annotated[float, Field(ge=0, le=10, allow_inf_nan=False, strict=True)]
Seconds = Annotated[float, Field(ge=0, le=1.0, allow_inf_nan=False, strict=True)]
Angle = Annotated[float, Field(ge=-3.2, le=3.2, allow_inf_nan=False, strict=True)]
Several = Positive | Annotated[tuple[Positive, ...], Field(min_length=1, max_length=1000)]
Error = Annotated[float, Field(gt=-1, le=10, allow_inf_nan=False, strict=True)]
Metres = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False, strict=True)]
Radians = Annotated[float, Field(ge=0, le=1.0, allow_inf_nan=False, strict=True)]

BITS_17 = 4.793689962142628e-05
BITS_12 = 1.5339807878856412e-03
"""Resolution of an encoder of 17, 12 bits: 2π / 2^17, 2π / 2^12 [rad]."""

PRESETS: dict[str, dict[str, Any]] = {
    "encoder": {"encoder_resolution": BITS_17, "encoder_noise": 1e-4},
    "lab": {
        "encoder_resolution": BITS_17,
        "encoder_noise": 1e-4,
        "measurement_delay": 0.002,
        "control_period": 0.002,
        "friction": 0.01,
    },
    "cheap": {
        "encoder_resolution": BITS_12,
        "encoder_noise": 1e-3,
        "measurement_delay": 0.005,
        "control_period": 0.005,
        "friction": 0.1,
    },
}
"""Imperfections by name: of good encoders alone, of an arm in a laboratory, of hobby servos."""


class Reality(Section):
    """What the law has to live with and is not told; all off if not given.

    In a file `reality = "lab"` in place of the table takes a preset: encoder, lab or cheap.
    """

    preset: Literal["encoder", "lab", "cheap"] | None = None
    """encoder: 17 bits and noise of 1e-4 rad; lab: that, 2 ms of delay, control at 500 Hz, 1 %
    friction; cheap: 12 bits, noise of 1e-3 rad, 5 ms of delay, control at 200 Hz, 10 % friction.
    What is given beside it counts more."""
    seed: Annotated[int, Field(ge=0, le=2**31)] = 0
    """Of the noise: the same seed gives the same numbers."""
    encoder_resolution: Radians = 0.0
    """Step of the joints' encoders [rad]; 2π / 2^17 = 4.79e-5 for 17 bits."""
    encoder_noise: Radians = 0.0
    """Standard deviation of a measured joint angle, anew at each control step [rad]."""
    velocity: Literal["difference", "sensor"] = "difference"
    """How joint velocities are measured where angles are not exact: as the difference of two angles
    in a row over a control period, or by exact sensors."""
    measurement_delay: Seconds = 0.0
    """How old the measured state is when the law acts on it [s]."""
    torque_delay: Seconds = 0.0
    """How long after the law's step motors exert its torque [s]."""
    control_period: Seconds = 0.0
    """Time from one step of the law to the next, in which its torque is held [s]; every time step
    if 0."""
    motor_torque: Gains | None = None
    """Largest torque of the motors [N m], one for all joints or one each, where it is less than
    what the robot's file allows."""
    torque_rate: Several | None = None
    """How fast motors change their torque [N m/s], one for all joints or one each; at once if not
    given."""
    motor_speed: Several | None = None
    """Speed at which motors have no torque left [rad/s], one for all joints or one each: towards it
    what they give in the direction in which they turn falls evenly from their limit."""
    joint_stiffness: Several | None = None
    """Stiffness of the gear between a motor's rotor, which carries the encoder, and its joint
    [N m/rad], one for all joints or one each; rigid if not given."""
    rotor_inertia: Several | None = None
    """Inertia of a motor behind such a gear, as its joint feels it [kg m^2], one for all joints or
    one each; the armature of the robot's file if not given."""
    backlash: Radians = 0.0
    """Play of such gears, from one side to the other [rad]."""
    stiffness_resolution: Positive | None = None
    """Step in which the mechanism sets a spring's stiffness [N m/rad], which the law knows."""
    stiffness_rate: Positive | None = None
    """How fast the mechanism that sets a spring changes its stiffness [N m/rad/s], which the law
    knows; at once if not given."""
    stiffness_lag: Seconds = 0.0
    """Time in which the mechanism that sets a spring goes 63 % of its way, and ever slower [s],
    which the law knows."""
    spring_error: Error | Annotated[tuple[Error, ...], Field(max_length=1000)] = 0.0
    """Share by which a spring is stiffer than it is set to be, one for all joints or one each."""
    spring_stiffening: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False, strict=True)] = 0.0
    """c of springs that exert k x (1 + c x²) at x from their equilibrium [1/rad²], which the law is
    not told."""
    spring_hysteresis: Annotated[float, Field(ge=0, lt=1, allow_inf_nan=False, strict=True)] = 0.0
    """Share of a spring's torque by which it is more as the spring is loaded, and less as it is
    unloaded."""
    spring_damping: Seconds = 0.0
    """Damping of a spring, over its stiffness [s]."""
    tool_offset: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    """Where the controller takes the tool to be, from where it is, in the tool's own axes [m]."""
    link_error: Error | Annotated[tuple[Error, ...], Field(max_length=1000)] = 0.0
    """Share by which the controller takes what lies between a joint and the next, or the tool, for
    longer than it is, one for all joints or one each."""
    base_tilt: tuple[Angle, Angle] = (0.0, 0.0)
    """Angles about x, and then about y, by which the base leans [rad]; the task leans with it."""
    friction: Share = 0.0
    """Dry friction of each joint, as a share of the largest torque that it needs without springs
    or friction."""

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: Any) -> Any:
        if isinstance(given, str):
            given = {"preset": given}
        if not isinstance(given, dict) or (name := given.get("preset")) is None:
            return given
        if name not in PRESETS:
            raise ValueError(
                f"{shown(name)}: valid presets are {listed(PRESETS)}{nearest(str(name), PRESETS)}"
            )
        return PRESETS[name] | given

    @model_validator(mode="after")
    def _play_of_a_gear(self) -> Self:
        for key in ("backlash", "rotor_inertia"):
            if getattr(self, key) and self.joint_stiffness is None:
                raise ValueError(
                    f"{key} = {shown(getattr(self, key))} is of gears that give way: give "
                    "joint_stiffness too"
                )
        return self

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.stiffness_lag and self.stiffness_rate is not None:
            raise ValueError(
                f"stiffness_lag = {self.stiffness_lag:g} and stiffness_rate = "
                f"{self.stiffness_rate:g} together: a mechanism has the one or the other"
            )
        return self

    @property
    def misjudged(self) -> bool:
        """Whether the controller takes the arm's dimensions for others."""
        return bool(any(self.tool_offset) or np.any(self.link_error))

    @property
    def slow_springs(self) -> bool:
        """Whether springs take time on their way to what the law wants of them."""
        return self.stiffness_rate is not None or self.stiffness_lag > 0

    @property
    def sensed(self) -> bool:
        """Whether what the law sees, or when it acts, differs from an ideal arm's."""
        return bool(
            self.encoder_resolution
            or self.encoder_noise
            or self.measurement_delay
            or self.torque_delay
            or self.control_period
            or self.joint_stiffness
        )

    @property
    def hookean(self) -> bool:
        """Whether springs are what the law takes them to be."""
        given = self.spring_stiffening, self.spring_hysteresis, self.spring_damping
        return not (any(given) or np.any(self.spring_error))

    def steps(self, key: str, timestep: float) -> int:
        """A time of this section in time steps; 1 for a control period that is not given."""
        return max(round(getattr(self, key) / timestep), int(key == "control_period"))
