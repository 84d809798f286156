"""What the command line prints of runs and optima."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from ..experiments.motors_section import Motors
from ..springs.cost import KINDS
from ..springs.elements import names
from ..text import NOTHING, number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..evaluation.certificates.certificates import Certificates
    from ..evaluation.checks.check import Judgement
    from ..plan.plan import Plan
    from ..results.motions import MotionOfRun
    from ..results.run import Run

ABREAST = 2
"""Motions side by side in a table: as many as 80 columns hold."""

HINGE, SLIDE = ("N m/rad", "N m", "rad"), ("N/m", "N", "m")
"""Units of stiffness, torque and angle."""


def table(title: str, caption: str = "", tight: bool = False) -> Table:
    """An empty table, with a column for what its rows are called."""
    drawn = Table(
        title=title or None,
        title_justify="left",
        caption=caption or None,
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=0 if tight else (0, 1),
    )
    drawn.add_column("", no_wrap=tight)
    return drawn


def summary(run: Run) -> Group:
    """The figures of each motion's last whole cycle beside the optimum's."""
    starts = range(0, len(run.motions), ABREAST)
    return Group(*(_summary(run, run.motions[at : at + ABREAST]) for at in starts))


def _summary(run: Run, motions: Sequence[MotionOfRun]) -> Table:
    first = motions[0].number == 1
    drawn = table(
        f"{run.experiment.name}: last cycle of each motion" if first else "",
        f"optimum: of constant springs along the joint motion {motions[0].optimum_of}; "
        f"range: of stiffnesses that cost at most 1 % of {run.cost.name} without springs more",
    )
    for motion in motions:
        drawn.add_column(f"motion {motion.number}", justify="right")
        drawn.add_column("optimum", justify="right", style="dim")
    found = [
        motion.summary()
        | {
            "equilibrium": motion.equilibrium[-1].tolist() if len(motion.cycles) else None,
            "equilibrium_optimal": motion.equilibrium_optimal.tolist(),
        }
        for motion in motions
    ]

    def row(label: str, key: str, scale: float, digits: int, joint: int | None = None) -> None:
        cells = []
        for one in found:
            for name in (key, f"{key}_optimal"):
                value = one.get(name)
                if isinstance(value, list) and joint is not None:
                    value = value[joint]
                cells.append(times(value, scale, digits) if name in one else "")
        drawn.add_row(label, *cells)

    def alone(label: str, cells: Sequence[str | Text]) -> None:
        drawn.add_row(label, *(cell for one in cells for cell in (one, "")))

    what = run.cost
    if run.experiment.springs.cost != "torque-squared":
        row(f"{what.name} reduction [%]", "cost_reduction", 100, 1)
        row(f"{what.name} [{what.unit}]", "cost", 1, 3)
        row("  without springs", "cost_without_springs", 1, 3)
    row("torque reduction [%]", "torque_reduction", 100, 1)
    row("mean torque² [N² m²]", "torque_squared", 1, 2)
    row("  without springs", "torque_squared_without_springs", 1, 2)
    if run.experiment.motors != Motors():
        for kind, name in (("energy", "electrical_power"), ("peak", "peak_torque")):
            if run.experiment.springs.cost != kind:
                row(f"{KINDS[kind].name} [{KINDS[kind].unit}]", name, 1, 3)
                row("  without springs", f"{name}_without_springs", 1, 3)
    names, slides = run.data["joint"].values, run.data["slides"].values
    for place, figure in enumerate(("stiffness", "offset", "equilibrium")):
        for j, name in enumerate(names):
            if not any(one.stiffness_least[j] or one.stiffness_most[j] for one in motions):
                continue  # a joint without a spring of its own
            unit = (SLIDE if slides[j] else HINGE)[place]
            row(f"{figure} {name} [{unit}]", figure, 1, 3, j)
            if figure == "stiffness":
                ends = [(one.stiffness_least[j], one.stiffness_most[j]) for one in motions]
                alone("  range", [f"{low:.3g}…{high:.3g}" for low, high in ends])
    for name in motions[0].parameters:
        alone_of = [(one.parameters[name], one.parameters_optimal[name]) for one in motions]
        cells = [(number(v[-1]) if len(v) else NOTHING, number(best)) for v, best in alone_of]
        drawn.add_row(name, *(cell for pair in cells for cell in pair))
    alone("tracking RMS [mm]", [_small(one["tracking_rms"]) for one in found])
    if "rotation_rms" in run.data:
        alone("rotation RMS [mrad]", [_small(one["rotation_rms"]) for one in found])
    if "joint_rms" in run.data:
        alone("joints' RMS [mrad]", [_small(one["joint_rms"]) for one in found])
    alone("first cycle at the optimum", [reached(motion) for motion in motions])
    alone("the last cycle is", [_verdict(motion) for motion in motions])
    return drawn


def _verdict(motion: MotionOfRun) -> Text:
    off = bool(len(motion.cycles)) and not motion.tracks[-1]
    return Text(motion.verdict, style="bold red" if off else "")


def reached(motion: MotionOfRun) -> str:
    """The cycle from which it is at the optimum; of nothing where there is no torque to compare."""
    if not len(motion.cycles) or not motion.cost_optimal > 0:
        return NOTHING
    return str(motion.cycles_to_optimum or "never")


def optimum(plan: Plan) -> Table:
    """The best constant springs of each desired motion and what they leave to the motors."""
    best = plan.optima
    drawn = Table(
        title=f"{plan.experiment.name}: optimal springs along the joint motion desired",
        title_justify="left",
        box=None,
    )
    drawn.add_column("")
    for index in range(len(best)):
        drawn.add_column(f"motion {index + 1}", justify="right")
    for j, joint in enumerate(plan.robot.joints):
        k, force, angle = SLIDE if plan.robot.slides[j] else HINGE
        for figure, unit in (
            ("stiffness", k),
            ("offset", force),
            ("equilibrium", angle),
            ("center", angle),
        ):
            cells = (number(getattr(one, figure)[j]) for one in best)
            drawn.add_row(f"{figure} {joint} [{unit}]", *cells)
    for at, name in enumerate(names(plan.robot.elements)):
        drawn.add_row(name, *(number(one.springs.others.parameters[at]) for one in best))
    kind = plan.experiment.springs.cost
    unit = {"torque-squared": "N² m² s", "peak": KINDS["peak"].unit}.get(kind, "J")
    said = "cost" if kind == "torque-squared" else f"{KINDS[kind].name} of a cycle,"
    drawn.add_row(f"{said} J_min [{unit}]", *(number(one.cost) for one in best))
    without = (number(one.cost_without_springs) for one in best)
    drawn.add_row(f"{said} without springs [{unit}]", *without)
    if kind != "torque-squared":
        cells = (number(100 * one.reduction, 1) for one in best)
        drawn.add_row(f"{KINDS[kind].name} reduction [%]", *cells)
    drawn.add_row("torque reduction [%]", *(number(100 * one.torque_reduction, 1) for one in best))
    return drawn


def certificates(found: Certificates) -> Table:
    """What the stability proof claims and whether it holds, motion by motion.

    Below (22) stand the first, the lowest and the last N, and the cycle of the lowest.
    """
    drawn = table(f"{found.name}: certificates")
    drawn.add_column("worst", justify="right")
    drawn.add_column("needed", justify="right")
    drawn.add_column("in cycle")
    drawn.add_column("verdict, cycles")
    for item in found.items:
        if item.claim.equation == "(9)":
            drawn.add_row(f"motion {item.motion}", style="bold")
        label = f"{item.claim.equation} {item.claim.text}"
        if item.claim.equation == "(15)":
            label += f" [{found.unit}]"
        if item.worst is None:
            drawn.add_row(f"{item.claim.equation} not judged: {item.note}")
            continue
        form = {"(15)": ".3g", "(22)": ".4f"}.get(item.claim.equation, ".1e")
        bad = item.cycles[item.fails] if item.cycles.size else item.cycles
        verdict = f"holds {_ranges(item.cycles)}" if item.holds else f"fails {_ranges(bad)}"
        drawn.add_row(label, f"{item.worst:{form}}", item.claim.needed, item.where, verdict)
        if item.claim.equation == "(22)":
            lowest = int(item.values.argmin())
            through = dict.fromkeys((0, lowest, len(item.values) - 1))
            N = ", ".join(f"{item.values[at]:.3g}" for at in through)
            drawn.add_row(f"     N {N} J", "", "", str(item.cycles[lowest]))
    return drawn


def _ranges(cycles: np.ndarray) -> str:
    """Numbers of cycles as ranges, as 1-39 or, where many are missing, 99 of 1-400."""
    if not cycles.size:
        return ""
    gaps = np.flatnonzero(np.diff(cycles) != 1)
    if gaps.size > 2:
        return f"{cycles.size} of {cycles[0]}-{cycles[-1]}"
    parts = np.split(cycles, gaps + 1)
    return ", ".join(f"{p[0]}-{p[-1]}" if p.size > 1 else f"{p[0]}" for p in parts)


def judgements(run: Run, found: list[Judgement]) -> Table:
    """What a run was expected to show, and what it shows."""
    from ..evaluation.checks import convergence

    missed = sum(not one.passed for one in found)
    title = f"{run.experiment.name}: {missed or 'none'} of {len(found)} expectations missed"
    drawn = Table(
        title=title,
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    drawn.add_column("motion")
    drawn.add_column("figure")
    for heading in ("expected", "tolerance", "found"):
        drawn.add_column(heading, justify="right", no_wrap=True)
    drawn.add_column("verdict")
    for one in found:
        drawn.add_row(
            str(one.motion or ""),
            convergence.figure(one),
            convergence.expected(one.band),
            convergence.tolerance(one.band),
            convergence.number(one.found, one.band),
            "passed" if one.passed else "MISSED",
            style=None if one.passed else "bold red",
        )
    return drawn


def times(value: float | None, scale: float, digits: int) -> str:
    """A multiple of a number with a fixed count of decimals."""
    return number(None if value is None else scale * value, digits)


def _small(value: float | None) -> str:
    """A figure that may fall by orders of magnitude, in thousandths with three digits."""
    return NOTHING if value is None else f"{value * 1e3:#.3g}"
