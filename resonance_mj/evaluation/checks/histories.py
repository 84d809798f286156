"""The figures of a motion from cycle to cycle, the last of which is what a run is judged by."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ...experiments.expectations import PER_JOINT
from ...springs import spring as springs


def of_motion(data: xr.Dataset, motion: int) -> dict[str, np.ndarray]:
    """Figures of each whole cycle of a motion.

    Args:
        data: `Run.data`.
        motion: number of the motion, from 1.

    Returns:
        stiffness, offset, equilibrium (cycles, n); torque_reduction, torque_share, tracking_rms
        (cycles,); torque_squared_of_optimum (cycles,), torque² as a multiple of the optimum's; in
        the units of `Run.data`. Equilibrium is NaN in cycles whose samples were not kept.
    """
    mine = data.sel(cycle=data["segment_of_cycle"] == motion)
    segment = data.sel(segment=motion)
    without = float(segment["torque_squared_without_springs"])
    best = float(segment["torque_squared_optimal"])
    squared = mine["torque_squared"].values
    reduction = 1 - squared / without
    k, offset = mine["stiffness_per_cycle"].values, mine["offset_per_cycle"].values
    return {
        "stiffness": k,
        "offset": offset,
        "equilibrium": _equilibrium(data, mine["cycle"].values, k, offset),
        "torque_reduction": reduction,
        "torque_share": reduction / (1 - best / without),
        "tracking_rms": mine["tracking_rms"].values,
        "torque_squared_of_optimum": squared / best,
    }


def optimum(data: xr.Dataset, motion: int) -> dict[str, np.ndarray]:
    """Stiffness, offset, equilibrium (n,) and torque_reduction () of a motion's optimum."""
    segment = data.sel(segment=motion)
    left = segment["torque_squared_optimal"] / segment["torque_squared_without_springs"]
    of_joints = {name: segment[f"{name}_optimal"].values for name in PER_JOINT}
    return {**of_joints, "torque_reduction": np.asarray(1 - left.values)}


def swing(data: xr.Dataset, motion: int) -> np.ndarray:
    """Standard deviation of the joint angles in a motion's last kept cycle (n,) [rad]."""
    cycles = data["cycle"].values[data["segment_of_cycle"].values == motion]
    kept = data["cycle_of_sample"].values
    last = max(set(cycles.tolist()) & set(np.unique(kept).tolist()), default=0)
    q = data["q"].values[kept == last]
    return q.std(axis=0) if len(q) else np.full(data.sizes["joint"], np.nan)


def _equilibrium(
    data: xr.Dataset, cycles: np.ndarray, k: np.ndarray, offset: np.ndarray
) -> np.ndarray:
    """Equilibrium angle of the springs at the end of cycles (cycles, n) [rad]."""
    angle = np.full_like(k, np.nan)
    kept = data["cycle_of_sample"].values
    for row, cycle in enumerate(cycles):
        sample = int(np.searchsorted(kept, cycle, side="right")) - 1
        if sample >= 0 and kept[sample] == cycle:
            center = data["center"].values[sample]
            for j in range(k.shape[1]):
                angle[row, j] = springs.equilibrium(k[row, j], offset[row, j], center[j])[1]
    return angle
