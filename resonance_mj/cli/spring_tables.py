"""What the command line prints of springs that a run asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..text import NOTHING, joined, number, percent
from .tables import table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

    from ..evaluation.spring_parts import PartsOfMotion, SpringParts
    from ..evaluation.spring_selection import Selection


def parts(found: SpringParts) -> Iterator[Table]:
    """What each spring must be and take, what the motors give, and what adjusting is worth."""
    for motion in found.motions:
        drawn = table(
            f"{found.name}: springs of motion {motion.motion}",
            f"1 %, 5 %: stiffnesses that cost at most so much of {found.cost.name} without springs "
            "more; travel: from rest; of an element with radii in N/m, m and N along its length",
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
                f"{part.stiffness:.4g}" if abs(part.stiffness) < 1e3 else _short(part.stiffness),
                *ranges,
                number(part.rest, 3),
                f"{part.peak:.3g}",
                _range(part.travel),
                f"{part.energy:.3g}",
            )
        yield drawn
        if any(part.pair for part in motion.parts):
            yield _pairs(motion)
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


def _pairs(motion: PartsOfMotion) -> Table:
    """What the actuators of antagonistic pairs do."""
    drawn = table(
        f"antagonistic pairs of motion {motion.motion}",
        "rest lengths: where each tendon begins to pull, along the pair's length; tension: least "
        "and greatest of both; holding: mean power that their actuators take",
        tight=True,
    )
    for heading in ("rest lengths\n[m]", "tension\n[N]", "holding\n[W]"):
        drawn.add_column(heading, justify="right", no_wrap=True)
    for part in motion.parts:
        if part.pair is not None:
            use = part.pair
            drawn.add_row(part.name, _range(use.ends), _range(use.tension), f"{use.holding:.3g}")
    return drawn


def _worth(found: SpringParts) -> Table:
    none = found.worth[0]
    drawn = table(
        f"{found.name}: what adjusting is worth",
        f"changing the springs for the next motion takes {_changing(found)}; what they give on the "
        "way is not counted",
        tight=True,
    )
    drawn.add_column(f"mean {found.cost.name}\n[{found.cost.unit}]", justify="right")
    drawn.add_column("less", justify="right")
    of = ("no springs", "one set for all motions", "the best for each motion")
    for label, value in zip(of, found.worth, strict=True):
        drawn.add_row(label, f"{value:.4g}", percent(1 - value / none) if none else NOTHING)
    return drawn


def _changing(found: SpringParts) -> str:
    each = [f"{value:.3g} J" if np.isfinite(value) else NOTHING for value in found.changing]
    last = len(each)
    # The first is what the way back takes.
    steps = [f"{number - 1 or last} → {number}" for number in range(1, last + 1)]
    order = [*range(1, last), 0]
    return joined([f"{each[at]} ({steps[at]})" for at in order])


def chosen(found: SpringParts, selections: tuple[Selection, ...]) -> Iterator[Table]:
    """The best parts of a catalogue, if one was given, and what they leave of each motion."""
    if not selections:
        return
    drawn = table(f"{found.name}: the best parts of the catalogue", tight=True)
    for heading in ("part", "rate\n[N m/rad]", "rest\n[rad]"):
        drawn.add_column(heading, justify="right", no_wrap=True)
    for one in selections:
        of = joined([str(motion) for motion in one.motions])
        for mounted in one.mounted:
            part = mounted.part
            drawn.add_row(
                f"motion{'s' * (len(one.motions) > 1)} {of} {mounted.on}",
                part.part if part else "none",
                f"{part.rate:.4g}" if part else "",
                number(mounted.rest, 3) if part else "",
            )
    yield drawn
    left = table(
        f"{found.name}: mean torque² with these parts [N² m²]",
        "best: with the best springs of any stiffness for the motion",
        tight=True,
    )
    for heading in ("without", "parts", "best"):
        left.add_column(heading, justify="right", no_wrap=True)
    for one in selections:
        for motion, *of_motion in zip(one.motions, one.without, one.left, one.best, strict=True):
            left.add_row(f"motion {motion}", *(f"{value:.4g}" for value in of_motion))
    yield left


def data(found: SpringParts, selections: tuple[Selection, ...]) -> dict[str, Any]:
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
        "changing": found.changing,
        "worth": dict(zip(("none", "fixed", "adjusted"), found.worth, strict=True)),
        "catalogue": [
            {
                "motions": one.motions,
                "parts": [
                    {"on": each.on, "part": each.part and each.part._asdict(), "rest": each.rest}
                    for each in one.mounted
                ],
                "left": one.left,
                "without": one.without,
                "best": one.best,
            }
            for one in selections
        ],
    }


def _range(ends: tuple[float, ...]) -> str:
    return "…".join(_short(end) for end in ends)


def _short(value: float) -> str:
    """Three digits, without an exponent up to a hundred thousand."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e5 else f"{value:.3g}"
