"""The certificates of a run as a figure: (11), c_7 of (15) and N of (22), cycle by cycle."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from ...evaluation.certificates.claims import ROUNDING, Certificate, Certificates
from ..palette import DESIRED, MEASURED, MUTED, OPTIMAL, SERIES
from .sheet import Row, Sheet
from .sizes import PAGE
from .style import SMALL, STYLE

FAILING = OPTIMAL

NARROW = 2.4
"""Width of a motion's column, at the least [in]."""

NOTHING = 1e-17
"""Where exactly nothing is drawn on a logarithmic axis."""


def figure(found: Certificates, width: float = PAGE) -> Figure:
    """A column for each motion that was reached; cycles that fail are marked.

    Args:
        found: from `certify`.
        width: of the figure [in].
    """
    rows = [found.of(equation) for equation in ("(11)", "(15)", "(22)")]
    columns = list(zip(*rows, strict=True))
    reached = [column for column in columns if any(item.cycles.size for item in column)] or columns
    width = max(width, NARROW * len(reached))
    with matplotlib.rc_context(STYLE):
        sheet = Sheet(
            width,
            [Row(1.3, 0.34, 0.34)] * len(rows),
            len(reached),
            heading=f"{found.name}: certificates of the stability proof",
        )
        for column, items in enumerate(reached):
            for row, (item, draw) in enumerate(zip(items, DRAWINGS, strict=True)):
                ax = sheet.panel(row, column)
                ax.set_title(f"{item.claim.equation} motion {item.motion}: ", pad=14)
                if item.note:
                    _say(ax, item.note)
                else:
                    draw(ax, item, found)
                    _finish(ax, item)
    return sheet.figure


def _orthogonality(ax: Axes, item: Certificate, found: Certificates) -> None:
    _title(ax, "share left over [1]")
    values = np.maximum(item.values, NOTHING)
    for joint, name in enumerate(found.joints):
        colour = SERIES[joint % len(SERIES)]
        ax.plot(item.cycles, values[:, joint], ".-", ms=3, color=colour, label=name)
    ax.axhline(ROUNDING, color=DESIRED, linestyle="--")
    ax.set_yscale("log")
    _mark(ax, item, values.max(axis=1), "fails")


def _passivity(ax: Axes, item: Certificate, found: Certificates) -> None:
    _title(ax, f"c₇ [{found.unit}]")
    ax.plot(item.cycles, item.values, ".-", ms=3, color=MEASURED)
    ax.axhline(0, color=DESIRED, linestyle="--")
    ax.axhline(found.enough, color=MUTED, linestyle=":", label=f"N falls above {found.enough:.3g}")
    # The jump with which a motion begins stands far above all else.
    first, others = item.values[0], item.values[1:]
    if others.size and first > 3 * others.max() > 0:
        low, high = min(0.0, others.min()), max(others.max(), found.enough)
        ax.set_ylim(low - 0.1 * (high - low), high + 0.2 * (high - low))
        ax.annotate(
            f"{first:.3g} in cycle {item.cycles[0]}",
            (0.2, 0.92),
            xycoords="axes fraction",
            va="center",
            color=MUTED,
            fontsize=SMALL,
        )
    _mark(ax, item, item.values, "fails")


def _decrease(ax: Axes, item: Certificate, found: Certificates) -> None:
    _title(ax, "N [J]")
    ax.plot(item.cycles, item.values, ".-", ms=3, color=MEASURED)
    ax.set_yscale("log")
    decades = np.log10(item.values.max() / item.values.min())
    if decades < 3:
        subs = (1.0, 2.0, 5.0) if decades < 2 else (1.0,)
        ax.yaxis.set_major_locator(LogLocator(subs=subs))
        ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
    _mark(ax, item, item.values, "grows from here")


DRAWINGS = (_orthogonality, _passivity, _decrease)


def _title(ax: Axes, what: str) -> None:
    ax.set_title(ax.get_title(loc="left") + what, pad=14)


def _mark(ax: Axes, item: Certificate, values: np.ndarray, label: str) -> None:
    if item.fails.any():
        at = item.cycles[item.fails], values[item.fails]
        ax.plot(*at, "o", ms=3.5, color=FAILING, label=label)


def _finish(ax: Axes, item: Certificate) -> None:
    ax.set_xlabel("cycle", labelpad=1)
    ax.set_xlim(item.cycles[0] - 1, item.cycles[-1] + 1)
    ax.xaxis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 5, 10], integer=True))
    if ax.get_legend_handles_labels()[0]:
        ax.legend(
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=8,
            borderaxespad=0.1,
            borderpad=0.1,
            handlelength=1.5,
            handletextpad=0.5,
            columnspacing=1.0,
        )


def _say(ax: Axes, note: str) -> None:
    """An empty panel that says why it is."""
    _title(ax, "not judged")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.text(0.5, 0.5, note, ha="center", va="center", color=MUTED, transform=ax.transAxes)
