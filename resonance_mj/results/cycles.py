"""The whole cycles of a run whose samples were kept, one by one."""

from typing import NamedTuple

import numpy as np

from .run import Run


class Cycle(NamedTuple):
    """One whole cycle of a run: its N samples, and the springs at its end."""

    number: int
    """In the run, counted from 1."""
    motion: int
    """The motion that it repeats, counted from 0."""
    passage: bool
    """Whether it is part of the passage into its motion, which teaches nothing."""
    q: np.ndarray
    """Joint angles (N, n) [rad]."""
    dq: np.ndarray
    """Joint velocities (N, n) [rad/s]."""
    x: np.ndarray
    """Tool position (N, m) [m]."""
    x_desired: np.ndarray
    """Desired tool position (N, m) [m]."""
    y: np.ndarray
    """Error signal (8) (N, n) [rad/s]."""
    u: np.ndarray
    """Learned torque (9) (N, n) [N m]."""
    tau: np.ndarray
    """Motor torque (4) (N, n) [N m]."""
    stiffness: np.ndarray
    """Stiffness k (N, n) [N m/rad]."""
    offset: np.ndarray
    """Offset torque q̄_e about `center` (N, n) [N m]."""
    center: np.ndarray
    """Centre q_c (n,) [rad]."""
    last_stiffness: np.ndarray
    """k at the end, before anything is handed over (n,) [N m/rad]."""
    last_offset: np.ndarray
    """q̄_e at the end, likewise (n,) [N m]."""
    parameters: np.ndarray
    """Of elastic elements besides (P,)."""


SIGNALS = ("q", "dq", "x", "x_desired", "y", "u", "tau", "stiffness", "offset", "center")


def kept(run: Run) -> list[Cycle]:
    """The whole cycles of a run whose samples were kept, in order."""
    data = run.data
    signals = {name: data[name].values for name in SIGNALS}
    motion, passage = data["segment_of_cycle"].values - 1, data["passage"].values
    last = {f"last_{name}": data[f"{name}_per_cycle"].values for name in ("stiffness", "offset")}
    none = np.empty((len(motion), 0))
    last["parameters"] = data["parameters_per_cycle"].values if "parameter" in data else none
    numbers, first, count = np.unique(
        data["cycle_of_sample"].values, return_index=True, return_counts=True
    )
    found = []
    for number, begin, steps in zip(numbers.tolist(), first, count, strict=True):
        at = number - 1
        if at < len(motion):  # A run that diverged ends within a cycle.
            part = {name: values[begin : begin + steps] for name, values in signals.items()}
            part |= {name: values[at] for name, values in last.items()}
            part["center"] = part["center"][0]
            found.append(Cycle(number, int(motion[at]), bool(passage[at]), **part))
    return found
