"""The motors of a plan: as the experiment gives them, and else as the arm's limits suggest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..experiments.experiment import Experiment
from ..robots.robot import Robot
from ..springs.cost import Drives
from ..text import Note

HEAT = 100.0
"""Heat in the windings at the rated torque of a motor whose constant is not given [W]."""

LEAST = 1e-3
"""Least rated torque of a motor of which nothing is known, of the largest."""


def drives(
    experiment: Experiment, robot: Robot, needed: Callable[[int], np.ndarray], notes: list[str]
) -> Drives:
    """The motors of an arm.

    Args:
        experiment: says what is known of them.
        robot: the arm.
        needed: gives the torque (N, n) [N m] that a motion needs without springs; asked for if a
            motor has neither a rated torque nor a limit.
        notes: get a line of what is taken for granted.
    """
    given, n = experiment.motors, robot.n
    rated = np.abs(robot.torque_limit).max(axis=1)
    if given.rated_torque is not None:
        rated = np.broadcast_to(given.rated_torque, n)
    elif not np.isfinite(rated).all():
        every = [np.abs(needed(index)).max(axis=0) for index in range(len(experiment.motion))]
        peak = np.max(every, axis=0)
        # A joint that needs next to nothing has a motor all the same.
        rated = np.where(np.isfinite(rated), rated, np.maximum(peak, LEAST * (peak.max() or 1.0)))
    ratio = np.broadcast_to(given.gear_ratio, n)
    k_m = rated / ratio / np.sqrt(HEAT) if given.k_m is None else np.broadcast_to(given.k_m, n)
    if given.k_m is None:
        notes.append(
            Note(
                f"motors.k_m: motors are taken to heat with {HEAT:g} W at their rated torque",
                f", {', '.join(f'{one:.4g}' for one in rated)} N m at the joints; "
                "motors.k_m, in N m per root of a watt, says what they are",
            )
        )
    return Drives(
        k_m=k_m,
        gear_ratio=ratio,
        gear_efficiency=np.broadcast_to(given.gear_efficiency, n),
        no_load_friction=np.broadcast_to(given.no_load_friction, n),
        regeneration=given.regeneration,
        rated_torque=rated,
    )
