"""Springs to build or buy: how stiff each must be, how exactly, and what adjusting is worth."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...evaluation.spring_parts import RISES, PartsOfMotion, SpringParts, spring_parts
from ...results.run import Run
from ...text import cut, minus, percent
from ..palette import MUTED, NOTE, OPTIMAL, SPRING_POSITIVE
from .sheet import Row, Sheet, heading, width_of
from .style import Line, enlarged, remark, small

PITCH = 0.19
"""Between two springs [in]."""

LONGEST = 14
"""Letters of a spring's name."""

NARROW = 20.0
"""Times the softest spring up to which the stiffest is shown at an even scale."""

THICK = 5.0
"""Of the line of a range [pt]."""

BEST: Line = {"color": OPTIMAL, "marker": "D", "markersize": 3.5, "linestyle": ""}
LEGEND: dict[str, Line] = {
    f"costs at most {percent(RISES[1], 0)} more": {
        "color": SPRING_POSITIVE,
        "linewidth": THICK,
        "alpha": 0.35,
    },
    f"{percent(RISES[0], 0)} more": {"color": SPRING_POSITIVE, "linewidth": THICK},
    "best": BEST,
}


def draw(run: Run, width: float) -> Figure:
    """A panel of stiffnesses for each motion, and where there are several one of their worth."""
    found = spring_parts(run)
    names = [cut(part.name, LONGEST) for motion in found.motions for part in motion.parts]
    several = len(found.motions) > 1
    labels = [*names, *(_SETS if several else ())]
    left = 0.16 + max((width_of(name, small()) for name in labels), default=0.3) / enlarged()
    rows = [Row(PITCH * (len(motion.parts) + 0.6), 0.4) for motion in found.motions]
    if several:
        rows.append(Row(PITCH * (len(_SETS) + 0.6), 0.4))
    sheet = Sheet(width, rows, heading=heading(run), legend=LEGEND, left=left)
    for row, motion in enumerate(found.motions):
        unit, name = _unit(run, motion), f"motion {motion.motion}"
        titles = f"{name}: stiffness of its springs, and how exact it must be", f"{name}: stiffness"
        ax = sheet.panel(row, 0, *(f"{title} [{unit}]" for title in titles))
        ax.set_xlabel(f"stiffness k [{unit}]")
        _stiffnesses(ax, motion)
    if several:
        unit = f"[{found.cost.unit}]"
        ax = sheet.panel(len(found.motions), 0, f"what adjusting is worth {unit}", f"worth {unit}")
        _worth(ax, found)
    return sheet.figure


def _stiffnesses(ax: Axes, motion: PartsOfMotion) -> None:
    """Best stiffness and ranges of each spring, from above."""
    best = np.array([part.stiffness for part in motion.parts])
    wide, narrow, dot = LEGEND.values()
    finite = [
        end for part in motion.parts for ends in part.ranges or () for end in ends
    ] + best.tolist()
    finite = [end for end in finite if np.isfinite(end)]
    low, high = min(finite, default=0.0), max(finite, default=1.0)
    for place, part in enumerate(motion.parts):
        for ends, line in zip(reversed(part.ranges or ()), (wide, narrow), strict=False):
            shown = np.clip(ends, low, high)
            ax.plot(shown, [place, place], **line, solid_capstyle="butt")
        ax.plot(part.stiffness, place, **dot)
    if high > NARROW * max(low, 0.0):
        ax.set_xscale("symlog", linthresh=1.0, linscale=0.5)
    ax.xaxis.set_major_formatter(lambda value, _: minus(f"{value:g}"))
    ax.set_yticks(range(len(motion.parts)), [cut(one.name, LONGEST) for one in motion.parts])
    ax.set_ylim(len(motion.parts) - 0.4, -0.6)
    ax.grid(axis="x", linewidth=0.4, alpha=0.4)


def _unit(run: Run, motion: PartsOfMotion) -> str:
    """Of the stiffness of its springs."""
    lengths = {one.name for one in run.plan.robot.elements if set(np.abs(one.radii)) - {0.0, 1.0}}
    slides = run.data["joint"].values[run.data["slides"].values.astype(bool)].tolist()
    given = {one.name in lengths or one.name in slides for one in motion.parts}
    return ", ".join({True: "N/m", False: "N m/rad"}[one] for one in sorted(given))


_SETS = ("no springs", "one set", "best of each")


def _worth(ax: Axes, found: SpringParts) -> None:
    """The cost over all motions without springs, with one set, and with the best of each."""
    colors = (MUTED, SPRING_POSITIVE, OPTIMAL)
    ax.barh(range(len(_SETS)), found.worth, height=0.6, color=colors)
    for place, value in enumerate(found.worth):
        share = f", {percent(value / found.worth[0])}" if place and found.worth[0] else ""
        at = (value, place)
        remark(
            ax,
            f"{value:.4g}{share}",
            at,
            xycoords="data",
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            color=NOTE,
        )
    ax.set_yticks(range(len(_SETS)), _SETS)
    ax.set_ylim(len(_SETS) - 0.4, -0.6)
    ax.set_xlim(0, 1.25 * max(found.worth.max(), 1e-12))
    ax.set_xlabel(f"mean {found.cost.name} over all motions [{found.cost.unit}]")
