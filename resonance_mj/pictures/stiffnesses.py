"""Which springs of a run there is something to draw of: joints' own, and elastic elements."""

from typing import NamedTuple

import numpy as np

from ..results.run import Run


class ElementStiffness(NamedTuple):
    """The stiffness of an elastic element over a run."""

    name: str
    metric: bool
    """Whether it is in N/m, along a length in metres, or else in N m/rad."""
    time: np.ndarray
    """When it began, and when each cycle ended (cycles + 1,) [s]."""
    k: np.ndarray
    """What it is until then (cycles + 1,)."""
    best: np.ndarray
    """Of the optimum, in each motion."""


def elements(run: Run) -> list[ElementStiffness]:
    """Those of a run, cycle by cycle."""
    data = run.data
    if "parameter" not in data:
        return []
    period = np.array([motion.period for motion in run.experiment.motion])
    ends = np.cumsum(period[data["segment_of_cycle"].values - 1])
    names, found = data["parameter"].values.tolist(), []
    for one in run.plan.robot.elements:
        at = names.index(f"{one.name}.stiffness")
        k, best = (data[f"parameters_{of}"].values[:, at] for of in ("per_cycle", "optimal"))
        metric = bool(set(np.abs(one.radii)) - {0.0, 1.0})
        time, acts = np.append(0.0, ends), np.append(k[:1], k)
        found.append(ElementStiffness(one.name, metric, time, acts, best))
    return found


def joints(run: Run) -> list[int]:
    """Joints whose own spring is more than none; all where there are no elements instead."""
    names = ("stiffness", "stiffness_optimal", "offset", "offset_optimal")
    own = np.any([(run.data[name].values != 0).any(axis=0) for name in names], axis=0)
    return np.flatnonzero(own | ("parameter" not in run.data)).tolist()
