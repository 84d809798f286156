"""What of a run is filmed: the samples of a span of time, and which of them each frame shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...errors import PictureError
from ...experiments.sections import Robot
from ...springs import spring as springs
from ...springs.cost import KINDS

if TYPE_CHECKING:
    from ...experiments.experiment import Experiment
    from ...plan.plan import Plan
    from ...results.run import Run

SLACK = 1e-6
"""Share of a sample's distance by which a time may miss the ends of a span."""


@dataclass(frozen=True)
class FrameData:
    """A span of a run as plain arrays: what the processes that draw it are sent.

    Attributes:
        label: what the picture calls the run.
        robot: which arm, as in the experiment.
        joints: names of the joints (n).
        slides: 1 for each slide joint (n,).
        axes: which of x, y, z `x_desired` has (m).
        sample: index of each frame's sample (F,).
        time: of each sample (N,) [s].
        cycle: number of each sample's cycle, from 1 (N,).
        period: samples in a whole cycle at each sample (N,).
        q: joint angles (N, n) [rad].
        x: position of the tool (N, m) [m].
        x_desired: desired position of the tool (N, m) [m].
        stiffness: k (N, n) [N m/rad].
        offset: q̄_e (N, n) [N m].
        center: q_c (N, n) [rad].
        tau: torque of the motors (N, n) [N m].
        elastic: torque of elements besides the joints' springs (N, n) [N m].
        cost: what the springs leave the least of.
        reduction: cost less than without springs in the last whole cycle that tracks; NaN
            before the motion has one (N,).
        best: the same with optimal springs (N,).
    """

    label: str
    robot: Robot
    joints: tuple[str, ...]
    slides: np.ndarray
    axes: tuple[int, ...]
    sample: np.ndarray
    time: np.ndarray
    cycle: np.ndarray
    period: np.ndarray
    q: np.ndarray
    x: np.ndarray
    x_desired: np.ndarray
    stiffness: np.ndarray
    offset: np.ndarray
    center: np.ndarray
    tau: np.ndarray
    elastic: np.ndarray
    cost: str
    reduction: np.ndarray
    best: np.ndarray

    def error(self, sample: int) -> float:
        """Distance between the tool and its desired position at a sample [m]."""
        return float(np.linalg.norm(self.x[sample] - self.x_desired[sample]))

    def equilibrium(self, sample: int) -> np.ndarray:
        """Equilibrium angles q_e at a sample (n,) [rad]."""
        at = self.stiffness[sample], self.offset[sample], self.center[sample]
        return springs.equilibrium_angles(*at)

    def spring(self, samples: int | slice = slice(None)) -> np.ndarray:
        """Torque of the springs at a sample (n,), or at all of them (N, n) [N m]."""
        k, offset = self.stiffness[samples], self.offset[samples]
        own = springs.torque(k, offset, self.q[samples], self.center[samples])
        return own + self.elastic[samples]


class Scale(NamedTuple):
    """What full thickness, colour and length of the overlays stand for at each joint (n,).

    It is the same for all joints that turn, and for all that slide.
    """

    stiffness: np.ndarray
    """Of the arm's stiffest spring [N m/rad]."""
    torque: np.ndarray
    """The greatest that one of the motors would need without springs [N m]."""


def scale_of(stiffness: np.ndarray, torque: np.ndarray, slides: np.ndarray) -> Scale:
    """The scale of an arm.

    Args:
        stiffness: greatest of each joint (n,) [N m/rad].
        torque: greatest of motor and spring together (n,) [N m].
        slides: which joints slide (n,).
    """
    slide, each = np.asarray(slides, bool), (stiffness, torque)
    return Scale(*(np.where(slide, (v * slide).max(), (v * ~slide).max()) + 1e-9 for v in each))


def scale(taken: Sequence[FrameData]) -> Scale:
    """The scale of what is shown, one for all; a rare peak does not count."""
    each = [(one.stiffness, one.tau + one.spring()) for one in taken]
    most = np.max([[np.quantile(np.abs(v), 0.98, axis=0) for v in of] for of in each], axis=0)
    return scale_of(most[0], most[1], taken[0].slides)


def scales(taken: Sequence[FrameData]) -> tuple[Scale, ...]:
    """The scale of each run of a picture: one for all if they have the same joints."""
    if len({one.joints for one in taken}) == 1:
        return (scale(taken),) * len(taken)
    return tuple(scale([one]) for one in taken)


def common_span(
    runs: Sequence[Run], start: float | str | None, stop: float | str | None
) -> tuple[float, float]:
    """First and last time [s] that `span` finds in every run."""
    spans = [span(run, start, stop) for run in runs]
    return max(low for low, _ in spans), min(high for _, high in spans)


def span(run: Run, start: float | str | None, stop: float | str | None) -> tuple[float, float]:
    """A span of a run [s].

    Args:
        run: with samples.
        start: seconds, or a cycle as in "8c", which begins with the 8th; the run's start if None.
        stop: seconds, or a cycle as in "10c", with whose end it ends; the run's end if None.

    Raises:
        PictureError: it is no span, or not in the run.
    """
    name, dt = run.experiment.name, run.experiment.simulation.timestep
    ends, time = cycle_ends(run.experiment), run.data["time"].values
    if not len(time):
        raise PictureError(f"{name}: the run has no samples to show")
    last = float(time[-1]) + dt
    low = 0.0 if start is None else _seconds(start, name, np.append(0.0, ends[:-1]))
    high = last if stop is None else _seconds(stop, name, ends)
    if not (-SLACK * dt <= low and high <= last + SLACK * dt):
        raise PictureError(
            f"{name}: from {low:g} s to {high:g} s is not within the run, which lasts from 0 to "
            f"{last:g} s (cycles 1c to {len(ends)}c)"
        )
    if high <= low:
        raise PictureError(f"{name}: the span from {low:g} s to {high:g} s is empty")
    return low, high


def times(runs: tuple[Run, ...], low: float, high: float, step: float, given: bool) -> np.ndarray:
    """Times of the frames [s]: a frame each `step` seconds.

    Args:
        runs: what is shown; all of them have samples at the times returned.
        low: start of the span [s].
        high: its end [s].
        step: seconds of the run between frames.
        given: whether the span was asked for. Then every frame must have samples; if not, the
            frames in cycles that were not kept are left out.

    Raises:
        PictureError: there are no samples for some of what was asked for.
    """
    wanted = low + step * np.arange(max(1, round((high - low) / step)))
    for run in runs:
        time, dt = run.data["time"].values, run.experiment.simulation.timestep
        at = _last_before(wanted, time, dt)
        there = (at >= 0) & (wanted - time[at] < (1 - SLACK) * dt)
        if given and not there.all():
            raise PictureError(
                f"{run.experiment.name}: no samples were kept at {wanted[~there][0]:g} s; the run "
                f"is thinned (simulation.samples = {run.experiment.simulation.samples}), and whole "
                f"are the cycles {_listed(np.unique(run.data['cycle_of_sample'].values))}"
            )
        wanted = wanted[there]
    if not len(wanted):
        raise PictureError("the runs have no kept cycle in common")
    return wanted


def of_run(run: Run, wanted: np.ndarray, label: str) -> FrameData:
    """What is filmed of a run.

    Args:
        run: the run.
        wanted: times of the frames (F,) [s], as from `times`.
        label: what the picture calls it.
    """
    data, dt = run.data, run.experiment.simulation.timestep
    longest = float(data["period"].max())
    part = data.sel(time=slice(wanted[0] - longest, wanted[-1] + longest))
    time, cycle = part["time"].values, part["cycle_of_sample"].values
    position = [i for i, axis in enumerate(part["axis"].values) if axis in "xyz"]
    segment = part["segment_of_sample"].values - 1
    found = (np.where(one.tracks, one.reduction, np.nan) for one in run.motions)
    reduction = np.concatenate([[np.nan], *found])
    # A cycle of the motion before says nothing beside this one's optimum.
    of = np.concatenate([[0], data["segment_of_cycle"].values])
    last = np.clip(cycle - 1, 0, len(reduction) - 1)
    best = np.array([motion.reduction_optimal for motion in run.motions])
    return FrameData(
        label=label,
        robot=run.experiment.robot,
        joints=tuple(str(name) for name in data["joint"].values),
        slides=data["slides"].values,
        axes=tuple("xyz".index(str(data["axis"].values[i])) for i in position),
        sample=_last_before(wanted, time, dt),
        time=time,
        cycle=cycle,
        period=np.round(data["period"].values[segment] / dt).astype(int),
        x=part["x"].values[:, position],
        x_desired=part["x_desired"].values[:, position],
        **{name: part[name].values for name in ("q", "stiffness", "offset", "center", "tau")},
        elastic=run.elastic_torque(part),
        reduction=np.where(of[last] == segment + 1, reduction[last], np.nan),
        best=best[segment],
        cost=run.cost.name,
    )


def planned(one: Plan, cycle: int) -> FrameData:
    """A cycle of the run, counted from 0, as it should be: the desired motion, and no torque."""
    segment = one.schedule[cycle]
    steps, dt = one.steps(segment), one.experiment.simulation.timestep
    axes = tuple("xyz".index(axis) for axis in one.robot.position_axes)
    none = np.zeros((5, steps, one.robot.n))
    x = one.desired(cycle).x[:, : len(axes)]
    return FrameData(
        label=one.experiment.name,
        robot=one.experiment.robot,
        joints=one.robot.joints,
        slides=one.robot.slides,
        axes=axes,
        sample=np.arange(steps),
        time=(sum(map(one.steps, one.schedule[:cycle])) + np.arange(steps)) * dt,
        cycle=np.full(steps, cycle + 1),
        period=np.full(steps, steps),
        q=one.joints[segment].q.copy(),
        x=x.copy(),
        x_desired=x.copy(),
        stiffness=none[0],
        offset=none[1],
        center=none[2],
        tau=none[3],
        elastic=none[4],
        reduction=np.full(steps, np.nan),
        best=np.full(steps, one.optima[segment].reduction),
        cost=KINDS[one.experiment.springs.cost].name,
    )


def cycle_ends(experiment: Experiment) -> np.ndarray:
    """When each cycle of an experiment ends (C,) [s]."""
    begins = np.cumsum([0.0, *(motion.duration for motion in experiment.motion)])
    cycles = (one.period * np.arange(1, one.cycles + 1) for one in experiment.motion)
    return np.concatenate([begin + each for begin, each in zip(begins, cycles, strict=False)])


def _seconds(value: float | str, name: str, cycles: np.ndarray) -> float:
    """A time of the run of this name [s]; that of a cycle is in `cycles`."""
    try:
        if not (isinstance(value, str) and value.endswith("c")):
            if np.isfinite(seconds := float(value)):
                return seconds
        elif 1 <= (number := int(value[:-1])) <= len(cycles):
            return float(cycles[number - 1])
        else:
            raise PictureError(
                f"{name}: there is no cycle {number}: the run's cycles are 1c to {len(cycles)}c"
            )
    except ValueError:
        pass
    raise PictureError(f"{value!r} is no time: give seconds, such as 8, or a cycle, such as 8c")


def _last_before(wanted: np.ndarray, time: np.ndarray, dt: float) -> np.ndarray:
    """Index of the last sample at or before each of some times; -1 for none."""
    return np.searchsorted(time, wanted + SLACK * dt, side="right") - 1


def _listed(cycles: np.ndarray) -> str:
    """Numbers as ranges, at most a dozen of them."""
    groups = np.split(cycles, np.flatnonzero(np.diff(cycles) > 1) + 1)
    words = [f"{g[0]}" if len(g) == 1 else f"{g[0]}-{g[-1]}" for g in groups]
    return ", ".join(words[:12]) + (f", ... {words[-1]}" if len(words) > 12 else "")
