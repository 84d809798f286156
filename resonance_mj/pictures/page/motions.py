"""The last whole cycle of each motion: its numbers beside those of the optimum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from ...results.run import Run
from ...springs import spring as springs
from .wording import Number, angle, length, percent, plain, seconds


class Beside(NamedTuple):
    """A number of the run beside that of the optimum."""

    found: Number
    optimal: Number


class Joint(NamedTuple):
    """The spring of a joint in a motion's last whole cycle."""

    name: str
    slides: bool
    stiffness: Beside
    offset: Beside
    equilibrium: Beside


@dataclass(frozen=True)
class Motion:
    """The last whole cycle of a motion.

    Attributes:
        number: from 1.
        about: shape, period and cycles in words.
        cycles: simulated whole, of so many.
        of: cycles of the experiment.
        reduction: torque reduction.
        torque: mean torque² [N² m²].
        without: the same without springs.
        tracking: RMS of the tool's position error.
        rotation: RMS of its rotation error; None where the task has none.
        reached: first cycle at the optimum.
        joints: their springs.
    """

    number: int
    about: str
    cycles: int
    of: int
    reduction: Beside
    torque: Beside
    without: Number
    tracking: Number
    rotation: Number | None
    reached: Number
    joints: tuple[Joint, ...]

    @property
    def against(self) -> tuple[str, str]:
        """Torque² against that without springs: how much, and whether less, more or times it."""
        share = self.reduction.found.value
        if share is None:
            return self.reduction.found.text, ""
        if share > -9.995:
            return percent(abs(share)).text, "less" if share >= 0 else "more"
        return f"{1 - share:,.0f}" if share > -1e9 else f"{1 - share:.3g}", "times the"


def motions(run: Run) -> tuple[Motion, ...]:
    """The last whole cycle of each motion of a run."""
    return tuple(_motion(run, i, segment) for i, segment in enumerate(run.summary()["segments"]))


def _motion(run: Run, index: int, segment: dict[str, Any]) -> Motion:
    of = run.experiment.motion[index]
    data = run.data.sel(segment=index + 1)

    def beside(name: str, j: int) -> Beside:
        found = segment[name][j] if segment[name] else None
        return Beside(plain(found), plain(segment[f"{name}_optimal"][j]))

    joints = tuple(
        Joint(
            str(name),
            bool(run.data["slides"].values[j]),
            beside("stiffness", j),
            beside("offset", j),
            Beside(_equilibrium(run, index, j), plain(float(data["equilibrium_optimal"][j]))),
        )
        for j, name in enumerate(run.data["joint"].values)
    )
    return Motion(
        number=index + 1,
        about=f"{of.shape}, {of.cycles} cycles of {seconds(of.period)}"
        + (f", payload {of.payload:g} kg" if of.payload else ""),
        cycles=segment["cycles"],
        of=of.cycles,
        reduction=Beside(
            percent(segment["torque_reduction"]), percent(segment["torque_reduction_optimal"])
        ),
        torque=Beside(
            plain(segment["torque_squared"], 2), plain(segment["torque_squared_optimal"], 2)
        ),
        without=plain(segment["torque_squared_without_springs"], 2),
        tracking=length(segment["tracking_rms"]),
        rotation=angle(segment["rotation_rms"]) if "rotation_rms" in segment else None,
        reached=_reached(segment),
        joints=joints,
    )


def _reached(segment: dict[str, Any]) -> Number:
    """First cycle at the optimum; a motion without a whole cycle cannot tell."""
    cycle = segment["cycles_to_optimum"]
    if cycle is None:
        return Number(None, "never" if segment["cycles"] else "–")
    return Number(cycle, str(cycle))


def _equilibrium(run: Run, index: int, j: int) -> Number:
    """Where a joint's spring is at rest at the end of a motion; a joint without one has none."""
    data = run.data
    cycles = data["cycle"].values[data["segment_of_cycle"].values == index + 1]
    samples = data["cycle_of_sample"].values
    if not cycles.size or cycles[-1] not in samples:
        return plain(None)
    k = float(data["stiffness_per_cycle"].values[cycles[-1] - 1, j])
    offset = float(data["offset_per_cycle"].values[cycles[-1] - 1, j])
    if k == 0.0:
        return plain(None)
    center = float(data["center"].values[samples == cycles[-1]][-1, j])
    return plain(springs.equilibrium(k, offset, center)[1])
