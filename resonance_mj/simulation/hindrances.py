"""What keeps an arm from a motion: contacts, ends of ranges, motors at limits, noise, slack."""

from typing import NamedTuple

import numpy as np

from ..laws.gains import HARMONICS
from ..laws.laws import listens
from ..laws.learning import low_pass
from ..plan.plan import Plan
from ..robots.motors import limits_along
from ..robots.touching import PASSING, touching
from ..springs.fit import LinearSprings
from ..text import joined, percent

LOOKED_AT = 250
"""Samples of a cycle at which it is seen what touches."""

NOISY, WORTH = 0.5, 0.01
"""Share of a cycle's torque² beyond its motion's harmonics from which on motors act on noise, and
the share of torque² without springs below which it is too little to matter."""

LOOSE = 0.01
"""Share of what its joint moves that a tendon may hang loose without a word."""

MOST = 3
"""Hindrances that a message names."""


class LastCycle(NamedTuple):
    """The last whole cycle of a motion."""

    q: np.ndarray
    """Joint angles (N, n) [rad]."""
    tau: np.ndarray
    """Motor torque (N, n) [N m]."""
    springs: LinearSprings
    """That acted, at each step."""
    dq: np.ndarray
    """Joint velocities (N, n) [rad/s]."""

    @property
    def total(self) -> np.ndarray:
        """Torque of motors and springs (N, n) [N m]."""
        return self.tau + self.springs.torque(self.q, self.dq)

    @property
    def center(self) -> np.ndarray:
        """Of the springs (n,) [rad]."""
        return self.springs.center


class Hindrance(NamedTuple):
    """What keeps an arm from a motion or acts on it besides motors, springs and gravity."""

    what: str
    cure: str
    bears: bool = True
    """Whether it exerts a force of its own."""
    is_noise: bool = False
    """Whether it is what the motors do besides the motion."""
    holds_back: bool = True
    """Whether it can keep the tool from its path."""


def hindrances(plan: Plan, index: int, cycle: LastCycle) -> list[Hindrance]:
    """What touches in a whole cycle of a motion, and what is at the end of what it can do."""
    of = (_contacts, _ranges, _motors, _noise, _slack)
    return [one for found in of for one in found(plan, index, cycle)]


def named(held: list[Hindrance]) -> str:
    """The first few of them in a row; a run's notes have all."""
    more = len(held) - MOST
    return joined([one.what for one in held[:MOST]] + ([f"{more} more"] if more > 0 else []))


def _contacts(plan: Plan, index: int, cycle: LastCycle) -> list[Hindrance]:
    """What touches, how deep and how long."""
    robot = plan.loaded[index].robot
    seen = cycle.q[:: max(1, len(cycle.q) // LOOKED_AT)]
    return [
        Hindrance(
            f"{touch}, for {_share(touch.share)} of it",
            f"another motion.{index}.center, size or robot.home, or {PASSING}",
        )
        for touch in touching(robot.model, robot.positions(seen))
    ]


def _ranges(plan: Plan, index: int, cycle: LastCycle) -> list[Hindrance]:
    """Which joints are at the ends of their ranges, and how long."""
    robot, found = plan.robot, []
    low, high = robot.model.jnt_range[robot.joint_id].T
    at_end = ((cycle.q <= low) | (cycle.q >= high)).mean(axis=0) * robot.limited
    for j in np.flatnonzero(at_end):
        cure = f"another motion.{index}.center, a smaller motion.{index}.size or another robot.home"
        found.append(
            Hindrance(
                f"{robot.joints[j]} is at the end of its range, {low[j]:.3g} to {high[j]:.3g}, for "
                f"{_share(at_end[j])} of it",
                cure,
            )
        )
    return found


def _motors(plan: Plan, index: int, cycle: LastCycle) -> list[Hindrance]:
    """Which motors are at their limits, and how long."""
    robot = plan.robot
    low, high = robot.torque_limit.T
    at_limit = ((cycle.tau <= low) | (cycle.tau >= high)).mean(axis=0)
    held_back = _held_back(plan, cycle.tau, cycle.dq)
    return [
        Hindrance(
            f"{robot.joints[j]}'s motor is at its limit, {low[j]:.3g} to {high[j]:.3g} "
            f"{'N' if robot.slides[j] else 'N m'}, for {_share(at_limit[j])} of it",
            f"a longer motion.{index}.period or a smaller motion.{index}.size",
            bears=False,
        )
        for j in np.flatnonzero(at_limit)
    ] + [
        Hindrance(
            f"{robot.joints[j]}'s motor gives less than it is asked for, by its rate or speed, for "
            f"{_share(held_back[j])} of it",
            f"a longer motion.{index}.period or a smaller motion.{index}.size",
            bears=False,
        )
        for j in np.flatnonzero(held_back > at_limit)
    ]


def _noise(plan: Plan, index: int, cycle: LastCycle) -> list[Hindrance]:
    """How much of the motors' torque is no part of the motion."""
    gains = plan.gains
    fast = cycle.tau - low_pass(cycle.tau, gains.harmonics or HARMONICS)
    power, noise = (float((tau**2).sum(axis=1).mean()) for tau in (cycle.tau, fast))
    without = plan.optima[index].torque_squared_without_springs
    if not without or noise <= max(NOISY * power, WORTH * without):
        return []
    cures = [f"a smaller law.omega (now {gains.omega:g} 1/s)"]
    if plan.law.listens and not listens(plan.experiment.law):
        cures.insert(0, "law.listens = true")
    reality = plan.experiment.reality
    cures += ["a smaller reality.encoder_noise"] if reality.encoder_noise else []
    return [
        Hindrance(
            f"{percent(noise / power, 0)} of the motors' torque² is faster than the motion's "
            f"harmonics: they act on noise, or the loop rings; it is {noise / without:.3g} times "
            "torque² without springs",
            " or ".join(cures),
            bears=False,
            is_noise=True,
        )
    ]


def _slack(plan: Plan, index: int, cycle: LastCycle) -> list[Hindrance]:
    """Which tendons of antagonistic pairs hang loose, and how long."""
    found = []
    for number, (element, p) in enumerate(cycle.springs.others.each()):
        if element.pair is None:
            continue
        lengths = cycle.q @ element.radii
        loose = element.pair.slack(lengths, element.pair.ends(*element.rests(p)))
        if loose.max() > LOOSE * np.ptp(lengths):
            found.append(
                Hindrance(
                    f"a tendon of {element.name} is slack for {_share((loose > 0).any(1).mean())} "
                    "of it",
                    f"a larger springs.element.{number}.pretension, or stiffness that may be more",
                    bears=False,
                    holds_back=False,
                )
            )
    return found


def limited(plan: Plan, tau: np.ndarray, dq: np.ndarray) -> float:
    """Share of a cycle, of all motors, in which they gave what they can.

    Args:
        plan: of the run.
        tau: motor torque (N, n) [N m].
        dq: joint velocities (N, n) [rad/s].
    """
    limit, reality = plan.robot.torque_limit, plan.experiment.reality
    share = 0.0
    if np.isfinite(limit).any():
        share = float(((tau <= limit[:, 0]) | (tau >= limit[:, 1])).mean())
    if reality.torque_rate is None and reality.motor_speed is None:
        return share
    return max(share, float(_held_back(plan, tau, dq).mean()))


def _held_back(plan: Plan, tau: np.ndarray, dq: np.ndarray) -> np.ndarray:
    """Share of a cycle in which each motor was as strong as it can be (n,)."""
    dt, limit = plan.experiment.simulation.timestep, plan.robot.torque_limit
    low, high = limits_along(limit, plan.experiment.reality, dt, tau, dq)
    return np.asarray(((tau <= low) | (tau >= high)).mean(axis=0))


def _share(share: float) -> str:
    return percent(share, 0) if share >= 0.01 else "less than 1 %"
