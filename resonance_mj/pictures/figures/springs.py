"""What each spring took from its motor: torque over joint angle, and the spring's line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...results.cycles import Cycle, kept
from ...results.run import Run
from ...springs import spring as law
from ..palette import MOTOR, MUTED, OPTIMAL, SPRING_NEGATIVE, SPRING_POSITIVE
from .naming import heading, letters, of_joint
from .sheet import Row, Sheet
from .sizes import PAGE
from .style import STYLE, abscissa, like, plain
from .text import naming

NARROW = 1.5
"""Width of the narrowest panel [in]."""

LEFT = 0.62
"""What numbers and label of an ordinate take [in]."""

POSITIVE, NEGATIVE = "spring and line fitted to it", "the same, k < 0"
LEGEND = {
    "needed without springs": Line2D([], [], color=MUTED, linestyle=":", linewidth=1.2),
    POSITIVE: Line2D([], [], color=SPRING_POSITIVE, linewidth=1.8),
    NEGATIVE: Line2D([], [], color=SPRING_NEGATIVE, linewidth=1.8),
    "optimal spring": Line2D([], [], color=OPTIMAL, linestyle="--", linewidth=1.0),
    "left to the motor": Line2D([], [], color=MOTOR, linewidth=1.0),
}


def draw(runs: Sequence[Run], width: float = PAGE) -> Figure:
    """A panel per joint for the last whole cycle of each motion whose samples were kept.

    What the motion needs without springs is what spring and motor exerted together.

    Args:
        runs: one run with a whole cycle whose samples were kept.
        width: of the figure [in].
    """
    (run,) = runs
    data, joints = run.data, run.data["joint"].values.tolist()
    last = {cycle.motion: cycle for cycle in kept(run)}
    found = {i: [exerted_in(cycle, j) for j in range(len(joints))] for i, cycle in last.items()}
    unseen = NEGATIVE if all(one.stiffness >= 0 for each in found.values() for one in each) else ""
    legend = {name: line for name, line in LEGEND.items() if name != unseen}
    most = max(1, int(width / (NARROW + LEFT)))
    each = -(-len(joints) // most)  # rows that a motion takes
    columns = -(-len(joints) // each)
    with matplotlib.rc_context(STYLE):
        rows = [Row(1.25, 0.34, 0.48)] * (each * len(last))
        sheet = Sheet(width, rows, columns, heading=heading(run), legend=legend, left=LEFT)
        names = letters()
        for index, cycle in enumerate(last.values()):
            for j, joint in enumerate(joints):
                row, column = divmod(j, columns)
                ax = sheet.panel(index * each + row, column)
                slides = bool(data["slides"].values[j])
                exerted = found[cycle.motion][j]
                letter = next(names)
                sheet.title(
                    ax,
                    *naming(
                        (
                            f"({letter}) {{}}, motion {cycle.motion + 1}, cycle {cycle.number}",
                            f"({letter}) {{}}, cycle {cycle.number}",
                        ),
                        joint,
                    ),
                    notes=list(_found(exerted, slides)),
                )
                _loops(ax, exerted, data.isel(joint=j, segment=cycle.motion))
                ax.set_xlabel("joint position q [m]" if slides else "joint angle q [rad]")
                ax.set_ylabel("force [N]" if slides else "torque [N m]")
    return sheet.figure


class Exerted(NamedTuple):
    """What spring and motor of a joint exerted in a cycle."""

    q: np.ndarray
    """Joint angle (N,) [rad]."""
    spring: np.ndarray
    """Torque of the spring (N,) [N m]."""
    motor: np.ndarray
    """Torque of the motor (N,) [N m]."""
    stiffness: float
    """Of the line fitted to the spring's torque over the angle [N m/rad]."""
    equilibrium: float
    """Where this line is zero [rad]; not finite where it is level."""

    @property
    def still(self) -> bool:
        """Whether the joint does not move, so that its spring has no stiffness to speak of."""
        return float(self.q.var()) <= law.STILL

    @property
    def needed(self) -> np.ndarray:
        """What the motion needs in all (N,) [N m]."""
        return self.spring + self.motor


def exerted_in(cycle: Cycle, joint: int) -> Exerted:
    """What spring and motor of a joint exerted in a cycle, and the line through the spring's part.

    Args:
        cycle: from `kept`.
        joint: index of the joint.
    """
    q = cycle.q[:, joint]
    k, offset = cycle.stiffness[:, joint], cycle.offset[:, joint]
    spring = law.torque(k, offset, q, cycle.center[joint])
    z, level = q - q.mean(), spring.mean()
    variance = float((z**2).mean())
    stiffness = -float((z * spring).mean()) / variance if variance > law.STILL else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        equilibrium = float(q.mean() + level / np.float64(stiffness))
    return Exerted(q, spring, cycle.tau[:, joint], stiffness, equilibrium)


def _found(exerted: Exerted, slides: bool) -> Iterator[str]:
    """The spring, and what it took from the motor, in words."""
    if exerted.still:
        spring = f"stands still, spring {exerted.spring.mean():.3g} N m"
    else:
        angle = exerted.equilibrium
        where = f"{round(angle, 3) + 0.0:.3f}" if abs(angle) < 1000 else f"{angle:.2g}"
        spring = f"k {exerted.stiffness:.3g} N m/rad, qₑ {where} rad"
    yield of_joint(spring, slides).replace("-", "−")
    left, needed = (exerted.motor**2).mean(), (exerted.needed**2).mean()
    share = left / needed if needed else 1.0
    what = "force²" if slides else "torque²"
    yield f"{abs(1 - share):.1%} {'less' if share <= 1.0005 else 'more'} {what}"


def _loops(ax: Axes, exerted: Exerted, best: xr.Dataset) -> None:
    """Torque over angle of all, closed, with the lines across the whole panel."""
    q = exerted.q
    reach = max(1.12 * float(np.ptp(q)), 10 * law.STILL**0.5) / 2
    across = (q.min() + q.max()) / 2 + np.array([-reach, reach])
    k, angle = float(best["stiffness_optimal"]), float(best["equilibrium_optimal"])
    optimal = k * (angle - across) if k else np.full(2, float(best["offset_optimal"]))
    spring = like(LEGEND[NEGATIVE if exerted.stiffness < 0 else POSITIVE])
    at = np.append(np.arange(len(q)), 0)  # closed
    ax.axhline(0.0, color="black", linewidth=0.4)
    ax.plot(q[at], exerted.motor[at], **like(LEGEND["left to the motor"]))
    ax.plot(across, line(across, exerted), **{**spring, "linewidth": 0.6})
    ax.plot(q[at], exerted.spring[at], **spring)
    ax.plot(q[at], exerted.needed[at], **like(LEGEND["needed without springs"]))
    ax.plot(across, optimal, **like(LEGEND["optimal spring"]))
    ax.set_xlim(*across)
    # A law that jumps where a cycle begins leaves the panel there.
    usual = [np.quantile(part, (0.01, 0.99)) for part in (exerted.motor, exerted.needed)]
    values = np.concatenate([[0.0], exerted.spring, *usual])
    margin = 0.1 * max(float(np.ptp(values)), 1e-12)
    ax.set_ylim(values.min() - margin, values.max() + margin)
    abscissa(ax)
    plain(ax, 5)


def line(q: np.ndarray, exerted: Exerted) -> np.ndarray:
    """The line fitted to the spring's torque [N m], at angles (·,) [rad]."""
    return exerted.spring.mean() - exerted.stiffness * (q - exerted.q.mean())
