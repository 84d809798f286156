"""How a run ended that did not diverge: does each tool follow its path, held back by what."""

from typing import NamedTuple

import numpy as np

from ..plan.plan import Plan
from ..results.metrics import TRACKING
from ..results.motions import MotionOfRun
from ..status import Status
from ..text import Caution, angle, length, percent
from .hindrances import Hindrance, LastCycle, hindrances, named

GROWN, FLOOR = 2.0, 0.01
"""How many times its least an error is that grows, and the share of what tracks below which none
does."""

RISING = 4
"""Cycles in a row that each exceed the one before where learning diverges."""

LEAST_RISE = 1.05
"""Factor by which they exceed it together."""

WORTH = 0.01
"""Share of torque² without springs below which growth of torque² is none."""


class Ending(NamedTuple):
    """How a run ended, why and what to try, and what is worth knowing of it."""

    status: Status
    message: str
    notes: tuple[str, ...]


def ending(
    plan: Plan, motions: tuple[MotionOfRun, ...], hindered: dict[int, list[Hindrance]]
) -> Ending:
    """Judge the last whole cycle of each motion as one who watches it would.

    Args:
        plan: that was simulated.
        motions: of the run.
        hindered: `hindrances` of the last whole cycle of each that has one, by its number from 0.
    """
    lost, growing, touched, noisy, notes = [], [], [], [], []
    for index, held in hindered.items():
        motion, name = motions[index], f"motion {index + 1}"
        bearing = [one for one in held if one.bears]
        noise = [one for one in held if one.is_noise]
        notes += [Caution(f"in the last cycle of {name} {one.what}") for one in held]
        if not motion.tracks[-1]:
            lost.append(_lost(plan, index, motion, [one for one in held if one.holds_back]))
        elif bearing:
            touched.append(
                f"in the last cycle of {name} {named(bearing)}, and the "
                f"springs bear on that too; try {bearing[0].cure}"
            )
        else:
            for growth, of in (
                (_harder(motion), motion.torque_squared),
                (_growth(motion, GROWN), motion.tracking_rms),
            ):
                what = "torque²" if of is motion.torque_squared else "the RMS error"
                if growth and _faster(of):
                    growing.append(
                        f"{what} of {name} has {growth}, ever faster; try {calmer(plan)}"
                    )
                elif growth:
                    notes.append(Caution(f"{what} of {name} has {growth}"))
            noisy += [f"in the last cycle of {name} {each.what}; try {each.cure}" for each in noise]
    found = {
        Status.NOT_TRACKING: lost,
        Status.DIVERGING: growing,
        Status.IN_CONTACT: touched,
        Status.NOISY: noisy,
        Status.OK: [""],
    }
    status = next(status for status, why in found.items() if why)
    return Ending(status, "; ".join(found[status]), tuple(notes))


def calmer(plan: Plan) -> str:
    """What to try where learning diverges."""
    law = plan.experiment.law
    key, now = ("eta", law.learned_share) if law.beta is None else ("beta", law.beta)
    lead = "law.lead = 1, " if plan.gains.lead == 0 else ""
    timestep = plan.experiment.simulation.timestep
    if plan.experiment.reality.sensed:
        return f"a smaller law.omega (now {plan.gains.omega:g} 1/s): the loop is noisy or late"
    return (
        f"{lead}a smaller law.{key} (now {now:g}) or a shorter simulation.timestep "
        f"(now {timestep:g} s)"
    )


def _lost(plan: Plan, index: int, motion: MotionOfRun, held: list[Hindrance]) -> str:
    """That a tool does not follow its path, why, and what to try."""
    errors, rotation = motion.tracking_rms, motion.rotation_rms
    if motion.joint_rms is not None:
        miss = f"{angle(motion.joint_rms[-1])} of the joints, which swing by {angle(motion.swing)}"
    elif rotation is None or errors[-1] > TRACKING * motion.size:
        share = percent(errors[-1] / motion.size, 0)
        miss = f"{length(errors[-1])}, {share} of the path's size of {length(motion.size)}"
    else:
        miss = f"{length(errors[-1])} and {angle(rotation[-1])}"
    law, falls = plan.experiment.law, len(errors) > 1 and errors[-1] < 0.9 * errors[-2]
    if growth := _growth(motion, 1.2):
        miss += f", {growth}"
    cures = list(dict.fromkeys(one.cure for one in held))
    late = plan.experiment.reality.measurement_delay
    last = plan.schedule.index(index) + plan.experiment.motion[index].cycles - 1
    velocity = plan.desired(last).dx[:, : len(plan.robot.position_axes)]
    speed = np.sqrt((velocity**2).sum(axis=1).mean())
    if not cures and late and errors[-1] < 2 * late * speed:
        cures = [
            f"a smaller reality.measurement_delay (now {late:g} s): the tool is where it should be "
            "by what was measured, which is so much older"
        ]
    if not cures and (reality := plan.experiment.reality).misjudged:
        off = plan.kinematics.misjudged(plan.joints[index].q, reality)
        away = float(np.sqrt((off**2).sum(axis=1).mean()))
        if 0.5 * away < errors[-1] < 2 * away:
            cures = [
                "smaller reality.tool_offset and link_error: by its own dimensions the controller "
                f"takes the tool to be on its path, {length(away)} from where it is"
            ]
    if not cures and law.kind == "feedback":
        cures = ['law.kind = "transfer", which learns']
    elif not cures and growth:
        cures = [calmer(plan)]
    elif not cures and (falls or len(errors) < 3):
        cures = [f"more cycles, a longer motion.{index}.duration: the error still falls"]
    elif not cures:
        omega = f"a larger law.omega (now {plan.gains.omega:g} 1/s)"
        cures = [omega if law.k_v is None else "larger law.k_v and law.k_p"]
        cures.append(f"a longer motion.{index}.period")
    if (
        growth and held and plan.experiment.reality.sensed
    ):  # what it runs into comes of what it does not see in time
        cures = [calmer(plan), *cures]
    why = f": {named(held)}" if held else ""
    return (
        f"the tool does not follow motion {index + 1}: in its last cycle the RMS error is {miss}"
        f"{why}; try {' or '.join(cures)}{plan.robot.hint}"
    )


def _growth(motion: MotionOfRun, factor: float) -> str:
    """From where the tracking error has grown so many times; empty if it has not."""
    errors = np.where(motion.passage, np.inf, motion.tracking_rms)
    lowest = int(np.argmin(errors))
    floor = max(errors[lowest], FLOOR * TRACKING * motion.size)
    if errors[-1] <= factor * floor:
        return ""
    return f"grown from {length(errors[lowest])} in its cycle {lowest + 1}"


def _harder(motion: MotionOfRun) -> str:
    """From where torque² has grown, beyond what the optimum needs; empty if it does not."""
    torque = motion.torque_squared[motion.passage == 0]
    worth = WORTH * motion.torque_squared_without_springs
    least = max(torque.min(initial=np.inf), motion.torque_squared_optimal, worth)
    if not torque.size or not 0 < GROWN * least < torque[-1]:
        return ""
    return f"grown to {torque[-1] / least:.2g} times its least"


def _faster(values: np.ndarray) -> bool:
    """Whether the last few cycles each exceed the one before, by no less than those before them.

    What diverges grows by a factor; springs of the law as printed, which drift, by less and less.
    """
    if len(values) <= 2 * RISING:
        return False
    first, middle, last = values[[-1 - 2 * RISING, -1 - RISING, -1]].tolist()
    rises = bool((np.diff(values[-1 - RISING :]) > 0).all())
    return rises and last >= LEAST_RISE * middle and last * first >= middle * middle


def diverging(plan: Plan, cycle: int, failed: int, why: str, before: LastCycle | None) -> str:
    """Which motion diverged, in which cycle of the run (from 0), when and why, and what to try.

    `failed`: control step in which it failed, from 1, or 0; `before`: its last whole cycle, if any.
    """
    law, segment, dt = (
        plan.experiment.law,
        plan.schedule[cycle],
        plan.experiment.simulation.timestep,
    )
    where = f"motion {segment + 1} diverged in cycle {cycle + 1} of the run"
    if failed:
        where += f", {(failed - 1) * dt:.3f} s into it"
    if cycle == 0:
        by_hand = law.k_v is not None or law.k_p is not None
        omega = f"a smaller law.omega (now {plan.gains.omega:g} 1/s)"
        smaller = "smaller law.k_v and law.k_p" if by_hand else omega
        tries = f"{smaller} or a shorter simulation.timestep (now {dt:g} s)"
    else:
        tries = calmer(plan)
    held = hindrances(plan, segment, before) if before else []
    if held:
        why += f"; in the last whole cycle {named(held)}"
        tries = " or ".join(dict.fromkeys([*(one.cure for one in held), tries]))
    return f"{where}: {why}; try {tries}"
