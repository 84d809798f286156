"""What each spring took from its motor: torque over joint angle, and the spring's line."""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...results.cycles import Cycle, kept
from ...results.motions import MotionOfRun
from ...results.run import Run
from ...springs import spring as law
from ...springs.elements import Elements
from ...springs.material import Material
from ...text import minus, of_joint
from ..palette import DESIRED, MOTOR, MUTED, OPTIMAL, SPRING_NEGATIVE, SPRING_POSITIVE
from .sheet import Row, Sheet, heading
from .style import Line, enlarged
from .ticks import abscissa, even

NARROW = 1.5
"""Width of the narrowest panel [in]."""

LEFT = 0.62
"""What numbers and label of an ordinate take [in]."""

POSITIVE, NEGATIVE = "spring and line fitted to it", "the same, k < 0"
LEGEND: dict[str, Line] = {
    "needed without springs": {"color": MUTED, "linestyle": ":", "linewidth": 1.2},
    POSITIVE: {"color": SPRING_POSITIVE, "linewidth": 1.8},
    NEGATIVE: {"color": SPRING_NEGATIVE, "linewidth": 1.8},
    "optimal spring": {"color": OPTIMAL, "linestyle": "--"},
    "left to the motor": {"color": MOTOR},
}


def draw(run: Run, width: float) -> Figure:
    """A panel per joint for the last whole cycle of each motion whose samples were kept.

    What the motion needs without springs is what spring and motor exerted together.
    """
    joints = run.data["joint"].values.tolist()
    last = {cycle.motion: cycle for cycle in kept(run)}
    found = [
        (one, j, _exerted_in(one, run.elements(one.parameters), j, run.material))
        for one in last.values()
        for j in range(len(joints))
    ]
    unseen = NEGATIVE if all(one.stiffness >= 0 for _, _, one in found) else ""
    most = max(1, int(width / enlarged() / (NARROW + LEFT)))
    each = -(-len(joints) // most)  # rows that a motion takes
    columns = -(-len(joints) // each)
    sheet = Sheet(
        width,
        [Row(1.25, 0.34, 0.48)] * (each * len(last)),
        columns,
        heading=heading(run),
        legend={name: line for name, line in LEGEND.items() if name != unseen},
        left=LEFT,
    )
    for i, (cycle, j, exerted) in enumerate(found):
        row, column = divmod(j, columns)
        slides = bool(run.data["slides"].values[j])
        ax = sheet.panel(
            i // len(joints) * each + row,
            column,
            f"{{}}, motion {cycle.motion + 1}, cycle {cycle.number}",
            f"{{}}, cycle {cycle.number}",
            name=joints[j],
            notes=(spring_in_words(exerted, slides), saved_in_words(exerted, slides)),
        )
        motion = run.motions[cycle.motion]
        beside = _beside_lines(run, cycle, motion)
        _loops(ax, exerted, motion, j, None if beside is None else beside[:, j])
        ax.set_xlabel("joint position q [m]" if slides else "joint angle q [rad]")
        ax.set_ylabel("force [N]" if slides else "torque [N m]")
    return sheet.figure


class Exerted(NamedTuple):
    """What spring and motor of a joint exerted in a cycle of N samples.

    Attributes:
        q: joint angle (N,) [rad].
        spring: its torque (N,) [N m].
        motor: its torque (N,) [N m].
        stiffness: of the line fitted to the spring's torque over the angle [N m/rad]; 0 if it
            stands still.
    """

    q: np.ndarray
    spring: np.ndarray
    motor: np.ndarray
    stiffness: float

    @property
    def still(self) -> bool:
        """Whether the joint does not move, so that its spring has no stiffness to speak of."""
        return float(self.q.var()) <= law.STILL

    @property
    def needed(self) -> np.ndarray:
        """What the motion needs in all (N,) [N m]."""
        return self.spring + self.motor


def _beside_lines(run: Run, cycle: Cycle, motion: MotionOfRun) -> np.ndarray | None:
    """Torque (N, n) of the optimum beside that of linear springs of the joints; None for none."""
    best = run.elements(np.array(list(motion.parameters_optimal.values())))
    if run.material is not None:
        k, q_e = motion.stiffness_optimal, motion.equilibrium_optimal
        own = run.material.torque(k, np.zeros_like(k), q_e, cycle.q, cycle.dq)
        return own - law.torque(k, np.zeros_like(k), cycle.q, q_e)
    return best.torque(cycle.q) if best.elements else None


def _exerted_in(
    cycle: Cycle, others: Elements, joint: int, material: Material | None = None
) -> Exerted:
    """What springs, elements and motor exerted in a cycle, and the line through the springs'."""
    q = cycle.q[:, joint]
    spring = law.torque(cycle.stiffness[:, joint], cycle.offset[:, joint], q, cycle.center[joint])
    if material is not None:
        springs = cycle.stiffness, cycle.offset, cycle.center
        spring = material.torque(*springs, cycle.q, cycle.dq)[:, joint]
    if others.elements:
        spring = spring + others.torque(cycle.q)[:, joint]
    z, variance = q - q.mean(), float(q.var())
    stiffness = -float((z * spring).mean()) / variance if variance > law.STILL else 0.0
    return Exerted(q, spring, cycle.tau[:, joint], stiffness)


def spring_in_words(exerted: Exerted, slides: bool) -> str:
    """What spring it is."""
    level = exerted.spring.mean()
    if exerted.still or not exerted.stiffness:
        what = "stands still, spring" if exerted.still else "no stiffness, spring"
        return minus(of_joint(f"{what} {level:.3g} N m", slides))
    angle = float(exerted.q.mean() + level / exerted.stiffness)
    where = f"{round(angle, 3) + 0.0:.3f}" if abs(angle) < 1000 else f"{angle:.2g}"
    return minus(of_joint(f"k {exerted.stiffness:.3g} N m/rad, qₑ {where} rad", slides))


def saved_in_words(exerted: Exerted, slides: bool) -> str:
    """What the spring took from the motor."""
    left, needed = (exerted.motor**2).mean(), (exerted.needed**2).mean()
    what = "force²" if slides else "torque²"
    if not needed:
        return f"needs no {what.removesuffix('²')}" if not left else f"all {what} is the spring's"
    share = left / needed
    if share > 10:
        return f"{share:.3g} times the {what}"
    return f"{abs(1 - share):.1%} {'less' if share <= 1.0005 else 'more'} {what}"


def _loops(
    ax: Axes, exerted: Exerted, motion: MotionOfRun, joint: int, others: np.ndarray | None
) -> None:
    """Torque over angle of all, closed, with the lines across the whole panel.

    `others`: torque (N,) of the optimum beside that of the joint's linear spring, if there is any.
    """
    q = exerted.q
    reach = max(1.12 * float(np.ptp(q)), 1e-3 * max(1.0, float(np.abs(q).max()))) / 2
    across = (q.min() + q.max()) / 2 + np.array([-reach, reach])
    k, angle = motion.stiffness_optimal[joint], motion.equilibrium_optimal[joint]
    places = across if others is None else q
    best = k * (angle - places) if k else np.full(len(places), motion.offset_optimal[joint])
    best = best if others is None else best + others
    fitted = exerted.spring.mean() - exerted.stiffness * (across - q.mean())
    spring = LEGEND[NEGATIVE if exerted.stiffness < 0 else POSITIVE]
    at = np.append(np.arange(len(q)), 0)  # closed
    ax.axhline(0.0, color=DESIRED, linewidth=0.4)
    ax.plot(q[at], exerted.motor[at], **LEGEND["left to the motor"])
    ax.plot(across, fitted, **{**spring, "linewidth": 0.6})
    ax.plot(q[at], exerted.spring[at], **spring)
    ax.plot(q[at], exerted.needed[at], **LEGEND["needed without springs"])
    ax.plot(places, best, **LEGEND["optimal spring"])
    ax.set_xlim(*across)
    # A law that jumps where a cycle begins leaves the panel there.
    usual = [np.quantile(part, (0.01, 0.99)) for part in (exerted.motor, exerted.needed)]
    values = np.concatenate([[0.0], exerted.spring, *usual])
    margin = 0.1 * max(float(np.ptp(values)), 1e-12)
    ax.set_ylim(values.min() - margin, values.max() + margin)
    abscissa(ax)
    even(ax, 5)
