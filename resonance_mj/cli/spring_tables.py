"""What the command line prints of springs that a run asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..text import NOTHING, number, percent
from .tables import table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

    from ..evaluation.spring_catalogue import Choice
    from ..evaluation.spring_parts import SpringParts


def parts(found: SpringParts) -> Iterator[Table]:
    """What each spring must be and take, what the motors give, and what adjusting is worth."""
    for motion in found.motions:
        drawn = table(
            f"{found.name}: springs of motion {motion.motion}",
            f"1 %, 5 %: stiffnesses that cost at most so much of {found.cost.name} without springs "
            "more; "
            "travel: from rest; of an element along its length",
            tight=True,
        )
        for heading in (
            "k\n[N m/rad]",
            "1 %",
            "5 %",
            "rest\n[rad]",
            "peak\n[N m]",
            "travel\n[rad]",
            "stores\n[J]",
        ):
            drawn.add_column(heading, justify="right", no_wrap=True)
        for part in motion.parts:
            ranges = [_range(ends) for ends in part.ranges or ((), ())]
            drawn.add_row(
                part.name,
                f"{part.stiffness:.4g}",
                *ranges,
                number(part.rest, 3),
                f"{part.peak:.3g}",
                _range(part.travel),
                f"{part.energy:.3g}",
            )
        yield drawn
        motors = table(f"motors of motion {motion.motion}", tight=True)
        for heading in ("RMS torque\nwithout", "with\n[N m]", "peak\nwithout", "with\n[N m]"):
            motors.add_column(heading, justify="right", no_wrap=True)
        for j, joint in enumerate(found.joints):
            of = (motion.rms[0, j], motion.rms[1, j], motion.peak[0, j], motion.peak[1, j])
            motors.add_row(joint, *(f"{value:.4g}" for value in of))
        without, with_springs = motion.power
        motors.add_section()
        motors.add_row("mean |τ q̇| of all [W]", f"{without:.4g}", f"{with_springs:.4g}")
        yield motors
    if len(found.motions) > 1:
        yield _worth(found)


def _worth(found: SpringParts) -> Table:
    none = found.worth[0]
    drawn = table(f"{found.name}: what adjusting is worth", tight=True)
    drawn.add_column(f"mean {found.cost.name}\n[{found.cost.unit}]", justify="right")
    drawn.add_column("less", justify="right")
    of = ("no springs", "one set for all motions", "the best for each motion")
    for label, value in zip(of, found.worth, strict=True):
        drawn.add_row(label, f"{value:.4g}", percent(1 - value / none) if none else NOTHING)
    return drawn


def chosen(found: SpringParts, choices: tuple[Choice, ...]) -> Iterator[Table]:
    """The best part of a catalogue for each joint and motion, if one was given."""
    if not choices:
        return
    drawn = table(
        f"{found.name}: the best parts of the catalogue",
        "mean square of the motor's torque [N² m²]: without a spring, with the part, with the best "
        "spring of any stiffness",
        tight=True,
    )
    for heading in ("part", "rate\n[N m/rad]", "rest\n[rad]", "without", "part", "best"):
        drawn.add_column(heading, justify="right", no_wrap=True)
    for one in choices:
        drawn.add_row(
            f"motion {one.motion} {one.joint}",
            one.part.part if one.part else "none",
            f"{one.part.rate:.4g}" if one.part else "",
            number(one.rest, 3) if one.part else "",
            *(f"{value:.4g}" for value in (one.without, one.left, one.best)),
        )
    yield drawn


def data(found: SpringParts, choices: tuple[Choice, ...]) -> dict[str, Any]:
    """The same figures as data."""
    return {
        "motions": [
            {
                "motion": motion.motion,
                "parts": [part._asdict() for part in motion.parts],
                "rms_torque": dict(zip(found.joints, motion.rms.T, strict=True)),
                "peak_torque": dict(zip(found.joints, motion.peak.T, strict=True)),
                "mean_power": motion.power,
            }
            for motion in found.motions
        ],
        "worth": dict(zip(("none", "fixed", "adjusted"), found.worth, strict=True)),
        "catalogue": [one._asdict() | {"part": one.part and one.part._asdict()} for one in choices],
    }


def _range(ends: tuple[float, ...]) -> str:
    return "…".join(f"{end:.3g}" for end in ends)
