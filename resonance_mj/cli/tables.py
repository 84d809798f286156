"""What the command line prints: tables of runs, optima and arms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.console import Group
from rich.table import Table

if TYPE_CHECKING:
    from ..evaluation.certificates.claims import Certificates
    from ..evaluation.checks.check import Judgement
    from ..evaluation.comparison.comparison import Comparison
    from ..evaluation.inspection import Inspection, Joint
    from ..experiments.experiment import Experiment
    from ..results.run import Run
    from ..robots.robot import Robot
    from ..springs.optimum import Optimum


ABREAST = 2
"""Motions side by side in a table: as many as 80 columns hold."""


def summary(run: Run) -> Group:
    """The figures of each motion's last whole cycle beside the optimum's."""
    segments = run.summary()["segments"]
    starts = range(0, len(segments), ABREAST)
    return Group(*(_summary(run, segments[at : at + ABREAST], at) for at in starts))


def _summary(run: Run, segments: list[dict[str, Any]], before: int) -> Table:
    title = "" if before else f"{run.experiment.name}: last cycle of each motion"
    table = _table(title, len(segments), before)

    def row(label: str, key: str, scale: float, digits: int, joint: int | None = None) -> None:
        cells = [label]
        for segment in segments:
            for name in (key, f"{key}_optimal"):
                value = segment.get(name)
                if isinstance(value, list) and joint is not None:
                    value = value[joint]
                cells.append(_number(value, scale, digits) if name in segment else "")
        table.add_row(*cells)

    row("torque reduction [%]", "torque_reduction", 100, 1)
    row("mean torque² [N² m²]", "torque_squared", 1, 2)
    row("  without springs", "torque_squared_without_springs", 1, 2)
    slides = run.data["slides"].values
    for joint, name in enumerate(run.data["joint"].values):
        unit = "N/m" if slides[joint] else "N m/rad"
        row(f"stiffness {name} [{unit}]", "stiffness", 1, 3, joint)
    for joint, name in enumerate(run.data["joint"].values):
        row(f"offset {name} [{'N' if slides[joint] else 'N m'}]", "offset", 1, 3, joint)
    for label, key in (
        ("tracking RMS [mm]", "tracking_rms"),
        ("rotation RMS [mrad]", "rotation_rms"),
    ):
        if key in run.data:
            table.add_row(
                label, *(cell for one in segments for cell in (_small(one[key], 1e3), ""))
            )
    reached = [segment["cycles_to_optimum"] for segment in segments]
    cells = ((str(cycle or "never"), "") for cycle in reached)
    table.add_row("first cycle at the optimum", *(cell for pair in cells for cell in pair))
    return table


def optimum(experiment: Experiment, arm: Robot, best: list[Optimum]) -> Table:
    """The best constant springs of each motion and what they leave to the motors."""
    table = Table(title=f"{experiment.name}: optimal springs", title_justify="left", box=None)
    table.add_column("")
    for index in range(len(best)):
        table.add_column(f"motion {index + 1}", justify="right")
    for j, joint in enumerate(arm.joints):
        k, force, angle = ("N/m", "N", "m") if arm.slides[j] else ("N m/rad", "N m", "rad")
        table.add_row(f"stiffness {joint} [{k}]", *(_number(b.stiffness[j], 1, 3) for b in best))
        table.add_row(f"offset {joint} [{force}]", *(_number(b.offset[j], 1, 3) for b in best))
        table.add_row(
            f"equilibrium {joint} [{angle}]", *(_number(b.equilibrium[j], 1, 3) for b in best)
        )
        table.add_row(f"center {joint} [{angle}]", *(_number(b.center[j], 1, 3) for b in best))
    table.add_row("cost J_min [N² m² s]", *(_number(b.cost, 1, 3) for b in best))
    table.add_row(
        "cost without springs [N² m² s]", *(_number(b.cost_without_springs, 1, 3) for b in best)
    )
    table.add_row("torque reduction [%]", *(_number(b.torque_reduction, 100, 1) for b in best))
    return table


def certificates(found: Certificates) -> Table:
    """What the stability proof claims and whether it holds, motion by motion.

    Below (22) stand the first, the lowest and the last N, and the cycle of the lowest.
    """
    table = _table(f"{found.name}: certificates", 0)
    table.add_column("worst", justify="right")
    table.add_column("needed", justify="right")
    table.add_column("in cycle")
    table.add_column("verdict, cycles")
    for item in found.items:
        if item.claim.equation == "(9)":
            table.add_row(f"motion {item.motion}", style="bold")
        label = f"{item.claim.equation} {item.claim.text}"
        if item.claim.equation == "(15)":
            label += f" [{found.unit}]"
        if item.worst is None:
            table.add_row(f"{item.claim.equation} not judged: {item.note}")
            continue
        form = {"(15)": ".3g", "(22)": ".4f"}.get(item.claim.equation, ".1e")
        bad = item.cycles[item.fails] if item.cycles.size else item.cycles
        verdict = f"holds {_ranges(item.cycles)}" if item.holds else f"fails {_ranges(bad)}"
        table.add_row(label, f"{item.worst:{form}}", item.claim.needed, item.where, verdict)
        if item.claim.equation == "(22)":
            lowest = int(item.values.argmin())
            through = dict.fromkeys((0, lowest, len(item.values) - 1))
            N = ", ".join(f"{item.values[at]:.3g}" for at in through)
            table.add_row(f"     N {N} J", "", "", str(item.cycles[lowest]))
    return table


def _ranges(cycles: np.ndarray) -> str:
    """Numbers of cycles as ranges, as 1-39 or, where many are missing, 99 of 1-400."""
    if not cycles.size:
        return ""
    gaps = np.flatnonzero(np.diff(cycles) != 1)
    if gaps.size > 2:
        return f"{cycles.size} of {cycles[0]}-{cycles[-1]}"
    parts = np.split(cycles, gaps + 1)
    return ", ".join(f"{p[0]}-{p[-1]}" if p.size > 1 else f"{p[0]}" for p in parts)


def comparison(found: Comparison) -> Table:
    """Every law on every motion, in the motion's last cycle, and what became of it in the end."""
    rows, motions = found.rows(), found.experiment.motion
    table = Table(
        title=f"{found.experiment.name}: last cycle of each motion",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=0,
        caption="The best: the optimum of constant springs. Cycles to the best: the first from "
        "which torque² stays within 5 % of it. Energy: the sum over joints of ∫|τ q̇| dt.",
        caption_justify="left",
    )
    table.add_column("", no_wrap=True)
    for heading in (
        "reduc-\ntion\n[%]",
        "of the\nbest\n[%]",
        "cycles\nto the\nbest",
        "track-\ning\n[mm]",
        "peak\ntorque\n[N m]",
        "energy\n\n[J]",
    ):
        table.add_column(heading, justify="right", no_wrap=True)
    if found.long:
        cycles = next(iter(found.long.values())).experiment.motion[-1].cycles
        table.add_column(f"torque² over\n{cycles} cycles\nof motion {len(motions)}")
    for number in range(1, len(motions) + 1):
        mine = [row for row in rows if row["motion"] == number]
        best = mine[-1]["torque_reduction_optimal"]
        table.add_section()
        table.add_row(f"motion {number}: the best", _number(best, 100, 1), "100.0", style="bold")
        for row in mine:
            table.add_row(
                row["title"],
                _number(row["torque_reduction"], 100, 1),
                _number(row["share"], 100, 1),
                str(row["cycles_to_optimum"] or "never"),
                _number(row["tracking_rms"], 1e3, 3),
                _number(row["peak_torque"], 1, 2),
                _number(row["energy"], 1, 2),
                row["long_run"],
            )
    return table


def joints(title: str, of: list[Joint]) -> Table:
    """Joints as they are in the MJCF; all are hinges, or all are slides."""
    angle, torque, inertia = _units(of)
    table = _table(title, 0)
    damping = f"{torque} s/{angle}"
    for heading in (
        f"home\n[{angle}]",
        f"range\n[{angle}]",
        f"damping\n[{damping}]",
        f"inertia\n[{inertia}]",
        f"motor limit\n[{torque}]",
    ):
        table.add_column(heading, justify="right")
    for joint in of:
        table.add_row(
            joint.name,
            _number(joint.home, 1, 3),
            _interval(joint.range),
            _number(joint.damping, 1, 3),
            _number(joint.inertia, 1, 4),
            _interval(joint.torque_limit),
        )
    return table


def effort(title: str, of: list[Joint]) -> Table:
    """What a motion asks of joints, beside the limits of their motors."""
    angle, torque, _ = _units(of)
    table = _table(title, 0)
    for heading in (
        f"peak speed\n[{angle}/s]",
        f"peak torque\nwithout springs [{torque}]",
        "of the limit\n[%]",
        f"with the best\nsprings [{torque}]",
    ):
        table.add_column(heading, justify="right")
    for joint in of:
        limited = any(map(math.isfinite, joint.torque_limit))
        table.add_row(
            joint.name,
            _number(joint.peak_speed, 1, 3),
            _number(joint.peak_torque, 1, 3),
            _number(joint.share if limited else None, 100, 0),
            _number(joint.peak_torque_with_springs, 1, 3),
        )
    return table


def tools(found: Inspection) -> Table:
    """The sites and bodies that could follow the motion."""
    table = _table("what could be the tool", 0)
    for heading in ("kind", "on body", "chosen"):
        table.add_column(heading)
    for tool in found.tools:
        chosen = found.tool_reason if tool == found.tool else ""
        table.add_row(tool.name, tool.kind, tool.body, chosen)
    return table


def suggestion(found: Inspection) -> Table:
    """The motion and gains that an arm gets where its user gives none."""
    motion, law, gains = found.experiment.motion[0], found.experiment.law, found.gains
    least, most = found.conditioning.min(), found.conditioning.max()
    table = _table("suggested motion and gains", 0)
    table.add_column("")
    table.show_header = False
    for label, value in (
        ("reach, stretched out [m]", _number(found.reach, 1, 3)),
        ("task", ", ".join(found.axes)),
        ("motion", f"{motion.shape} in {', '.join(dict.fromkeys(motion.plane or ()))}"),
        ("  center [m]", _listed(motion.center)),
        ("  half sizes [m]", _listed(motion.size)),
        ("  period T [s]", f"{motion.period:g}"),
        ("  smallest / largest singular value of J", f"{least:.3f} to {most:.3f}"),
        ("  torque reduction with the best springs [%]", _number(found.torque_reduction, 100, 1)),
        ("feedback bandwidth omega [1/s]", f"{gains.omega:g}"),
        ("share eta that is learned in a cycle", f"{law.eta:g}"),
        ("lead [control periods]", str(gains.lead)),
        ("harmonics of 1/T that are learned", str(gains.harmonics or "all")),
    ):
        table.add_row(label, value)
    return table


def judgements(run: Run, found: list[Judgement]) -> Table:
    """What a run was expected to show, and what it shows."""
    from ..evaluation.checks import convergence

    missed = sum(not one.passed for one in found)
    table = Table(
        title=f"{run.experiment.name}: {missed or 'none'} of {len(found)} expectations missed",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    table.add_column("motion")
    table.add_column("figure")
    for heading in ("expected", "tolerance", "found"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("verdict")
    for one in found:
        table.add_row(
            str(one.motion or ""),
            convergence.figure(one),
            convergence.expected(one.band),
            convergence.tolerance(one.band),
            convergence.number(one.found, one.band),
            "passed" if one.passed else "MISSED",
            style=None if one.passed else "bold red",
        )
    return table


def _units(joints: list[Joint]) -> tuple[str, str, str]:
    """Units of angle, torque and inertia of hinges, or of what they are for slides."""
    return ("m", "N", "kg") if joints[0].slides else ("rad", "N m", "kg m²")


def _interval(ends: tuple[float, float] | None) -> str:
    if ends is None or not any(map(math.isfinite, ends)):
        return "none"
    return f"{ends[0]:.4g} to {ends[1]:.4g}"


def _listed(values: Sequence[float] | None) -> str:
    return ", ".join(f"{value:.3f}" for value in values or ())


def _table(title: str, motions: int, before: int = 0) -> Table:
    table = Table(title=title or None, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    for index in range(before, before + motions):
        table.add_column(f"motion {index + 1}", justify="right")
        table.add_column("optimum", justify="right", style="dim")
    return table


def _small(value: float | None, scale: float) -> str:
    """A figure that may fall by orders of magnitude, with three digits."""
    return "-" if value is None else f"{value * scale:#.3g}"


def _number(value: float | None, scale: float, digits: int) -> str:
    return "-" if value is None else f"{value * scale:.{digits}f}"
