"""The paper's Fig. 4 (a)-(h) for any number of joints, and torque² per cycle below."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ...results.run import Run
from ...text import minus, of_joint
from .. import stiffnesses
from ..spans import spans
from .cycles import cost
from .sheet import Row, Sheet, abscissa_of_the_panel_below, fitting, heading, width_of
from .style import LABEL_BOX, LINES, enlarged, remark, small
from .ticks import breadth, even
from .time_axes import Piece, timed

TITLES = {
    "equilibrium": ("equilibrium angle qₑ of {} [rad]", "qₑ of {} [rad]", "qₑ {} [rad]"),
    "x": ("tool position {} [m]", "tool {} [m]", "{} [m]"),
    "rotation": ("tool rotation {} [rad]", "tool {} [rad]", "{} [rad]"),
    "stiffness": ("stiffness k of {} [N m/rad]", "k of {} [N m/rad]", "k {} [N m/rad]"),
    "element": ("stiffness k of {} [N m/rad]", "k of {} [N m/rad]", "k {} [N m/rad]"),
    "offset": ("offset torque q̄ₑ of {} [N m]", "q̄ₑ of {} [N m]", "q̄ₑ {} [N m]"),
    "tau": ("motor torque τ of {} [N m]", "τ of {} [N m]", "τ {} [N m]"),
}
"""Wordings from long to short."""

ADAPTED = ("stiffness", "offset", "equilibrium")
"""What is drawn beside its optimum over the whole run."""

HONEST = 0.02
"""Least height of a panel as a share of the highest of its kind: below it all is noise."""

WEAK, TURN = 1e-3, 4.0
"""Stiffness as a share of the stiffest spring's below which a spring has no equilibrium to speak
of; and how far from the optimum's an equilibrium is drawn, as a multiple of the joint's travel."""

BESIDE = {"x": ("x_desired", "desired"), "tau": ("tau_optimal", "with optimal springs")}
"""What is drawn beside a signal, and as which line."""

SIDE_BY_SIDE = 1.5
"""Width below which panels are not drawn three in a row [in]."""


def draw(run: Run, width: float) -> Figure:
    """Tool position, stiffness, offset torque, motor torque and torque², beside the optimum.

    Signals that repeat with the motion are shown where something happens: at the start, around
    each change of motion and at the end.
    """
    data = run.data
    axes, joints = data["axis"].values.tolist(), data["joint"].values.tolist()
    elements = stiffnesses.elements(run)
    own = stiffnesses.joints(run)
    places, rows, columns = _places(len(axes), len(joints), own, len(elements), width)
    sheet = Sheet(width, rows, columns, heading=heading(run), legend=LINES)
    windows = Windows(run)
    heights = _heights(run)
    for (name, i), (row, column) in places.items():
        names = {"x": axes, "element": [one.name for one in elements]}.get(name, joints)
        slides = name not in ("x", "element") and bool(data["slides"].values[i])
        slides |= name == "element" and elements[i].metric
        kind = "rotation" if name == "x" and names[i].startswith("r") else name
        wordings = (of_joint(one, slides) for one in sheet.alike(TITLES[kind], names))
        ax = sheet.panel(row, column, *wordings, name=names[i])
        if name == "element":
            ax.plot(elements[i].time, elements[i].k, drawstyle="steps-pre", **LINES["measured"])
            _beside_optimum(ax, run, elements[i].best)
        elif name in ADAPTED:
            _against_optimum(ax, run, name, i)
        else:
            beside, line = BESIDE[name]
            windows.plot(ax, data[name].values[:, i], **LINES["measured"])
            windows.plot(ax, data[beside].values[:, i], **LINES[line])
            windows.label(ax)
        if name == "tau":
            _steady_limits(ax, run, i, of_joint("N m", slides))
        even(ax, least=HONEST * heights[kind])
        if rows[row].below < Row(0).below:
            abscissa_of_the_panel_below(ax)
    cost(sheet, len(rows) - 1, run, span=columns)
    return sheet.figure


def _places(
    axes: int, joints: int, own: list[int], elements: int, width: float
) -> tuple[dict[tuple[str, int], tuple[int, int]], list[Row], int]:
    """Row and column of each panel, the rows, the last of which is torque², and the columns.

    Two joints stand side by side as in the paper, more of them below each other with a column each
    for k, q̄_e, q_e and τ; where that is too narrow, in two columns. Elements stand above.
    """
    per_joint = (*ADAPTED, "tau")
    if joints > 2 and width / 4 > enlarged() * SIDE_BY_SIDE:
        columns, above = 4, -(-axes // 4)
        places = {("x", i): divmod(i, columns) for i in range(axes)}
        places |= {("element", i): (above + i // columns, i % columns) for i in range(elements)}
        above += -(-elements // columns)
        for column, name in enumerate(per_joint):
            if name == "tau" or own:
                places |= {(name, j): (above + j, column) for j in range(joints)}
        tall = 0.75 if joints <= 4 else 0.54
        rows = [Row(0.8)] * above + [Row(tall, 0.06)] * (joints - 1) + [Row(tall)]
    else:
        columns = min(2, max(axes, joints))
        places, rows = {}, []
        counts = {"x": axes, "element": elements, "tau": joints}
        for name in ("x", "element", *per_joint):
            shown = [*range(counts[name])] if name in counts else own
            places |= {
                (name, i): (len(rows) + at // columns, at % columns) for at, i in enumerate(shown)
            }
            rows += [Row(1.0 if name in ("x", "tau") else 0.8)] * -(-len(shown) // columns)
    return places, [*rows, Row(1.1)], columns


def _heights(run: Run) -> dict[str, float]:
    """Of each kind of panel how much its signals vary, the one that varies most."""
    rotates = np.char.startswith(run.data["axis"].values.astype(str), "r")
    signals: dict[str, np.ndarray] = {
        name: run.data[name].values for name in ("tau", "stiffness", "offset")
    }
    signals |= {"x": run.data["x_desired"].values[:, ~rotates]}
    signals |= {"rotation": run.data["x_desired"].values[:, rotates]}
    signals |= {"equilibrium": run.data["q"].values, "element": np.zeros((1, 1))}
    return {name: float(np.ptp(part, axis=0).max(initial=0.0)) for name, part in signals.items()}


def _against_optimum(ax: Axes, run: Run, name: str, joint: int) -> None:
    """An adapted parameter over the whole run, with its optimum dashed."""
    data = run.data
    time, values = data["time"].values, data[name].values[:, joint]
    best = data[f"{name}_optimal"].values[:, joint]
    if name == "equilibrium":
        least = WEAK * np.abs(data["stiffness"].values).max()
        values = np.where(np.abs(data["stiffness"].values[:, joint]) > least, values, np.nan)
        best = np.where(np.abs(data["stiffness_optimal"].values[:, joint]) > least, best, np.nan)
        reach = TURN * max(float(np.ptp(data["q"].values[:, joint])), 1e-6)
        known = best[np.isfinite(best)] if np.isfinite(best).any() else data["q"].values[:, joint]
        near = (values >= known.min() - reach) & (values <= known.max() + reach)
        values = np.where(near, values, np.nan)  # a weak spring's is anywhere
    keep = slice(None, None, max(1, time.size // 1000))
    ax.plot(time[keep], values[keep], **LINES["measured"])
    _beside_optimum(ax, run, best)


def _beside_optimum(ax: Axes, run: Run, best: np.ndarray) -> None:
    """The optimum in each motion (motions,), dashed, and the time of the whole run."""
    starts, ends = run.data["start"].values, run.data["end"].values
    ax.hlines(best, starts, ends, **LINES["with optimal springs"])
    ax.set_xlim(0, ends[-1])
    ax.set_xlabel("time [s]")
    timed(ax, [Piece(0.0, ends[-1], 0.0, ends[-1])])


def _steady_limits(ax: Axes, run: Run, joint: int, unit: str) -> None:
    """Scale an axis to the motion's own torque; a peak at its start or change is said in words."""
    data, whole = run.data, run.data.sizes["cycle"]
    torque, best = data["tau"].values[:, joint], data["tau_optimal"].values[:, joint]
    begin = [number for motion in run.motions for number in motion.cycles[:2]]
    steady = ~np.isin(data["cycle_of_sample"], begin) & (data["cycle_of_sample"].values <= whole)
    if not steady.any():
        return
    usual = torque[steady], best[steady]
    low, high = float(np.min(usual)), float(np.max(usual))
    margin = 0.25 * max(high - low, 1e-9)
    ax.set_ylim(low - margin, high + margin)
    largest = int(np.argmax(np.abs(torque)))
    if not low - margin <= torque[largest] <= high + margin:
        said = minus(f"peak {torque[largest]:.3g} {unit}")
        when = f"{said} at {data['time'].values[largest]:.2f} s"
        remark(ax, fitting([when, said], small(), breadth(ax)), (0.01, 0.03), bbox=LABEL_BOX)


class Windows:
    """A time axis that shows where something happens in a run, and breaks in between.

    Args:
        run: with at least one sample.
    """

    def __init__(self, run: Run) -> None:
        self._time = run.data["time"].values
        self._step = float(np.diff(self._time[-2:]).sum())
        self._spans = spans(run, float(self._time[-1]) + self._step)
        self._gap = 0.06 * max(sum(high - low for low, high in self._spans), 1e-9)
        widths = [high - low + self._gap for low, high in self._spans]
        self._left = np.concatenate([[0.0], np.cumsum(widths)])

    def plot(self, ax: Axes, values: np.ndarray, **style: Any) -> None:
        """Draw a signal (N,), given at each sample, over the windows in a style."""
        for (low, high), left in zip(self._spans, self._left, strict=False):
            inside = np.flatnonzero((self._time >= low) & (self._time <= high))
            left_out = np.diff(self._time[inside]) > 1.5 * self._step
            for piece in np.split(inside, np.flatnonzero(left_out) + 1):
                if piece.size:
                    at = piece[:: max(1, inside.size // 800)]
                    ax.plot(self._time[at] - low + left, values[at], **style)

    def label(self, ax: Axes) -> None:
        """Put the times on the axis, and mark where it breaks."""
        end = max(self._left[-1] - self._gap, 1e-3)
        room = breadth(ax) / end  # inches per second
        ticks: dict[float, str] = {}
        taken = -np.inf
        for (low, high), left in zip(self._spans, self._left, strict=False):
            if left:
                ax.axvspan(left - self._gap, left, color="0.93", linewidth=0, zorder=3)
            bins = max(1, min(4, int((high - low) * room / 0.25)))
            whole = high - low >= 1
            locator = MaxNLocator(bins, steps=[1, 2, 5, 10], integer=whole, min_n_ticks=1)
            for tick in locator.tick_values(low, high):
                place, half = tick - low + left, width_of(f"{tick:g}", small()) / 2 / room
                if low - 1e-9 <= tick <= high + 1e-9 and place - half > taken + 0.04 / room:
                    ticks[place] = f"{tick:g}"
                    taken = place + half
        ax.set_xticks([*ticks], [*ticks.values()])
        ax.set_xlim(0, end)
        ax.set_xlabel("time [s]")
        shown = zip(self._spans, self._left, strict=False)
        timed(ax, [Piece(low, high, left, left + high - low) for (low, high), left in shown])
