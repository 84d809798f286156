"""What the command line prints of an arm: its joints, its tools, what suits it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.table import Table

from ..text import number
from .tables import table

if TYPE_CHECKING:
    from ..evaluation.inspection import Inspection, Joint


def joints(title: str, of: list[Joint]) -> Table:
    """Joints as they are in the MJCF; all are hinges, or all are slides."""
    angle, torque, inertia = _units(of)
    drawn = table(title)
    for heading, unit in (
        ("home", angle),
        ("range", angle),
        ("damping", f"{torque} s/{angle}"),
        ("inertia", inertia),
        ("motor limit", torque),
    ):
        drawn.add_column(f"{heading}\n[{unit}]", justify="right")
    for joint in of:
        drawn.add_row(
            joint.name,
            number(joint.home, 3),
            _interval(joint.range),
            number(joint.damping, 3),
            number(joint.inertia, 4),
            _interval(joint.torque_limit),
        )
    return drawn


def effort(title: str, of: list[Joint]) -> Table:
    """What a motion asks of joints, beside the limits of their motors."""
    angle, torque, _ = _units(of)
    drawn = table(title)
    for heading in (
        f"peak speed\n[{angle}/s]",
        f"peak torque\nwithout springs [{torque}]",
        "of the limit\n[%]",
        f"with the best\nsprings [{torque}]",
    ):
        drawn.add_column(heading, justify="right")
    for joint in of:
        limited = any(map(math.isfinite, joint.torque_limit))
        drawn.add_row(
            joint.name,
            number(joint.peak_speed, 3),
            number(joint.peak_torque, 3),
            number(100 * joint.share if limited else None, 0),
            number(joint.peak_torque_with_springs, 3),
        )
    return drawn


def tools(found: Inspection) -> Table:
    """The sites and bodies that could follow the motion."""
    drawn = table("what could be the tool")
    for heading in ("kind", "on body", "chosen"):
        drawn.add_column(heading)
    for tool in found.tools:
        chosen = found.tool_reason if tool == found.tool else ""
        drawn.add_row(tool.name, tool.kind, tool.body, chosen)
    return drawn


def suggestion(found: Inspection) -> Table:
    """The motion and gains that an arm gets where its user gives none."""
    motion, law, gains = found.experiment.motion[0], found.experiment.law, found.gains
    least, most = found.conditioning.min(), found.conditioning.max()
    drawn = table("suggested motion and gains")
    drawn.add_column("")
    drawn.show_header = False
    for label, value in (
        ("reach, stretched out [m]", number(found.reach, 3)),
        ("task", ", ".join(found.axes)),
        ("motion", f"{motion.shape} in {', '.join(dict.fromkeys(motion.plane or ()))}"),
        ("  center [m]", ", ".join(number(at) for at in motion.center or ())),
        ("  half sizes [m]", ", ".join(number(at) for at in motion.size or ())),
        ("  period T [s]", f"{motion.period:g}"),
        ("  smallest / largest singular value of J", f"{least:.3f} to {most:.3f}"),
        ("  torque reduction with the best springs [%]", number(100 * found.torque_reduction, 1)),
        ("feedback bandwidth omega [1/s]", f"{gains.omega:g}"),
        ("share eta that is learned in a cycle", f"{law.learned_share:g}"),
        ("lead [control periods]", str(gains.lead)),
        ("harmonics of 1/T that are learned", str(gains.harmonics or "all")),
    ):
        drawn.add_row(label, value)
    return drawn


def _units(joints: list[Joint]) -> tuple[str, str, str]:
    """Units of angle, torque and inertia of hinges, or of what they are for slides."""
    return ("m", "N", "kg") if joints[0].slides else ("rad", "N m", "kg m²")


def _interval(ends: tuple[float, float] | None) -> str:
    if ends is None or not any(map(math.isfinite, ends)):
        return "none"
    return f"{ends[0]:.4g} to {ends[1]:.4g}"
