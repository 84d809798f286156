"""The certificates of a run as a figure: (11), c_7 of (15) and N of (22), cycle by cycle."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...evaluation.certificates.certificates import ROUNDING, Certificate, Certificates
from ..palette import DESIRED, MEASURED, MUTED, NOTE, OPTIMAL
from .asked import PAGE
from .sheet import Row, Sheet
from .style import if_titled, one_of, remark, styled
from .ticks import counted, even, logarithmic

NARROW = 2.4
"""Width of a motion's column, at the least [in]."""

NOTHING = 1e-17
"""Where exactly nothing is drawn on a logarithmic axis."""


@styled()
def figure(found: Certificates) -> Figure:
    """A column for each motion that was reached; cycles that fail are marked.

    Args:
        found: from `certify`.
    """
    rows = [found.of(equation) for equation in DRAWINGS]
    columns = list(zip(*rows, strict=True))
    reached = [column for column in columns if any(item.cycles.size for item in column)] or columns
    sheet = Sheet(
        max(PAGE, NARROW * len(reached)),
        [Row(1.3, 0.34, 0.34)] * len(rows),
        len(reached),
        heading=if_titled(f"{found.name}: certificates of the stability proof"),
        legend={name: one_of(joint) for joint, name in enumerate(found.joints)},
        lettered=False,
    )
    for column, items in enumerate(reached):
        for row, (item, (what, draw)) in enumerate(zip(items, DRAWINGS.values(), strict=True)):
            title = "not judged" if item.note else what.format(found.unit)
            ax = sheet.panel(row, column, f"{item.claim.equation} motion {item.motion}: {title}")
            ax.set_title(ax.get_title(loc="left"), pad=14)  # above a legend
            if item.note:
                ax.set(xticks=[], yticks=[])
                ax.text(0.5, 0.5, item.note, color=NOTE, ha="center", transform=ax.transAxes)
            else:
                draw(ax, item, found)
                counted(ax)
                ax.set_xlim(item.cycles[0] - 1, item.cycles[-1] + 1)
                if ax.get_legend_handles_labels()[0]:
                    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.01), ncols=8)
    return sheet.figure


def _orthogonality(ax: Axes, item: Certificate, found: Certificates) -> None:
    values = np.maximum(item.values, NOTHING)
    for joint in range(len(found.joints)):
        ax.plot(item.cycles, values[:, joint], marker=".", ms=3, **one_of(joint))
    ax.axhline(ROUNDING, color=DESIRED, linestyle="--")
    logarithmic(ax)
    _mark(ax, item, values.max(axis=1), "fails")


def _passivity(ax: Axes, item: Certificate, found: Certificates) -> None:
    ax.plot(item.cycles, item.values, ".-", ms=3, color=MEASURED)
    ax.axhline(0, color=DESIRED, linestyle="--")
    ax.axhline(found.enough, color=MUTED, linestyle=":", label=f"N falls above {found.enough:.3g}")
    # The jump with which a motion begins stands far above all else.
    first, others = item.values[0], item.values[1:]
    if others.size and first > 3 * others.max() > 0:
        low, high = min(0.0, others.min()), max(others.max(), found.enough)
        ax.set_ylim(low - 0.1 * (high - low), high + 0.2 * (high - low))
        remark(ax, f"{first:.3g} in cycle {item.cycles[0]}", (0.2, 0.92), va="center")
    even(ax)
    _mark(ax, item, item.values, "fails")


def _decrease(ax: Axes, item: Certificate, found: Certificates) -> None:
    ax.plot(item.cycles, item.values, ".-", ms=3, color=MEASURED)
    logarithmic(ax)
    _mark(ax, item, item.values, "grows from here")


DRAWINGS = {
    "(11)": ("share left over [1]", _orthogonality),
    "(15)": ("c₇ [{}]", _passivity),
    "(22)": ("N [J]", _decrease),
}
"""What is drawn of each equation, in which unit."""


def _mark(ax: Axes, item: Certificate, values: np.ndarray, label: str) -> None:
    if item.fails.any():
        at = item.cycles[item.fails], values[item.fails]
        ax.plot(*at, "o", ms=3.5, color=OPTIMAL, label=label)
