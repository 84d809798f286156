"""What the command line prints of laws beside each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..evaluation.robustness import described, written
from ..text import number
from .tables import reached, table, times

if TYPE_CHECKING:
    from rich.table import Table

    from ..evaluation.comparison import Comparison
    from ..evaluation.robustness import RobustnessMap


def robustness(found: RobustnessMap) -> Table:
    """What each law keeps under each imperfection."""
    drawn = table(
        f"{found.experiment.name}: reduction of {found.cost}, of what is possible [%]",
        f"n ×: {found.cost} is so many times that without springs; off: the tool is off its path; "
        "×: diverged; ↑: diverging; ~: motors act on noise. Each law has its default gains; the "
        "worst of the motions.",
        tight=True,
    )
    for title in found.titles.values():
        drawn.add_column(title, justify="right")
    laws = len(found.titles)
    for at in range(0, len(found.cells), laws):
        row = found.cells[at : at + laws]
        if at % (3 * laws) == laws:
            drawn.add_section()
        drawn.add_row(
            described(row[0].imperfection, row[0].strength),
            *(written(cell, short=True) for cell in row),
        )
    return drawn


def comparison(found: Comparison) -> Table:
    """Every law on every motion, in the motion's last cycle, and what became of it in the end."""
    rows, motions = found.rows(), found.experiment.motion
    of = found.runs[next(iter(found.runs))].motions[0].optimum_of
    drawn = table(
        f"{found.experiment.name}: last cycle of each motion",
        "The best: the optimum of constant springs along the joint motion "
        + ("desired" if of == "desired" else "made by each law")
        + ". Cycles to the best: the first from which "
        f"{found.cost} stays within 5 % of it; off: the tool is off its path, and its torque "
        "that of another motion. Energy: the sum over joints of ∫|τ q̇| dt.",
        tight=True,
    )
    for heading in (
        "reduc-\ntion\n[%]",
        "of the\nbest\n[%]",
        "cycles\nto the\nbest",
        "track-\ning\n[mm]",
        "peak\ntorque\n[N m]",
        "energy\n\n[J]",
    ):
        drawn.add_column(heading, justify="right", no_wrap=True)
    if found.long:
        cycles = next(iter(found.long.values())).experiment.motion[-1].cycles
        drawn.add_column(f"{found.cost} over\n{cycles} cycles\nof motion {len(motions)}")
    for at in range(len(motions)):
        mine = [row for row in rows if row["motion"] == at + 1]
        best = sorted({times(row["reduction_optimal"], 100, 1) for row in mine})
        drawn.add_section()
        drawn.add_row(
            f"motion {at + 1}: the best", best[0] if len(best) == 1 else "", "100.0", style="bold"
        )
        for row in mine:
            motion = found.runs[row["law"]].motions[at]
            off = bool(len(motion.cycles)) and not motion.tracks[-1]
            drawn.add_row(
                row["title"],
                times(row["reduction"], 100, 1),
                times(row["share"], 100, 1),
                "off" if off else reached(motion),
                times(row["tracking_rms"], 1e3, 3),
                number(row["peak_torque"], 2),
                number(row["energy"], 2),
                row["long_run"],
                style="dim" if off else None,
            )
    return drawn
