"""The section [motors]: what a motor and its gear lose, and what they give back."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from .sections import Positive, Section

Efficiency = Annotated[float, Field(gt=0, le=1, allow_inf_nan=False, strict=True)]
Part = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False, strict=True)]
Loss = Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False, strict=True)]
Each = Annotated[tuple[Positive, ...], Field(min_length=1)]


class Motors(Section):
    """The motors, for their electrical power and where `springs.cost` is not torque².

    One number for all joints, or one each.
    """

    k_m: Positive | Each | None = None
    """Motor constant, torque of the shaft per root of the heat in the windings [N m/√W]; such that
    a motor heats with 100 W at its rated torque if not given."""
    gear_ratio: Positive | Each = 1.0
    """Turns of the shaft per turn of the joint."""
    gear_efficiency: Efficiency | Annotated[tuple[Efficiency, ...], Field(min_length=1)] = 1.0
    """Share of the power that the gear passes on, either way."""
    no_load_friction: Loss | Annotated[tuple[Loss, ...], Field(min_length=1)] = 0.0
    """Torque that the shaft needs to turn alone [N m]."""
    regeneration: Part = 0.0
    """Share of the power of a motor that brakes which its supply takes back."""
    rated_torque: Positive | Each | None = None
    """Torque at the joint that the peak is a share of [N m]; the limit of the joint's motor, and
    without one the peak that the motions would need without springs, if not given."""
