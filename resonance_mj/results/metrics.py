"""How good a run is: torque against the optimum, tracking, cycles until the optimum is reached."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

OPTIMUM_BAND = 0.05
"""Relative distance from the optimal torque² within which a cycle counts as at the optimum."""


def cycles_to_optimum(torque_squared: np.ndarray, optimal: float) -> int | None:
    """First cycle, counted from 1, from which torque² stays within 5 % of the optimum's.

    A cycle below the band counts as outside: it needs less torque because it does not track yet.

    Args:
        torque_squared: per cycle of one motion (cycles,) [N² m²].
        optimal: of the optimum [N² m²].

    Returns:
        The cycle, or None if the last cycle is outside.
    """
    outside = np.flatnonzero(~(np.abs(torque_squared / optimal - 1.0) <= OPTIMUM_BAND))
    first = int(outside[-1]) + 1 if outside.size else 0
    return first + 1 if first < len(torque_squared) else None


def segments(data: xr.Dataset) -> list[dict[str, Any]]:
    """Per motion of a run, the figures of its last whole cycle beside the optimum's.

    Args:
        data: `Run.data`.

    Returns:
        For each motion a dict: start_s, end_s, cycles (simulated whole), torque_reduction,
        torque_reduction_optimal, torque_squared, torque_squared_without_springs,
        torque_squared_optimal [N² m²], tracking_rms [m], stiffness, stiffness_optimal [N m/rad],
        offset, offset_optimal [N m], cycles_to_optimum. What a run that ended early did not reach
        is None.
    """
    return [_segment(data.sel(segment=number)) for number in data["segment"].values]


def _segment(data: xr.Dataset) -> dict[str, Any]:
    mine = data.sel(cycle=data["segment_of_cycle"] == data["segment"])
    cycles = mine.sizes["cycle"]
    without = float(data["torque_squared_without_springs"])
    optimal = float(data["torque_squared_optimal"])

    def last(name: str) -> Any:
        return mine[name].values[-1].tolist() if cycles else None

    torque_squared = last("torque_squared")
    return {
        "start_s": float(data["start"]),
        "end_s": float(data["end"]),
        "cycles": cycles,
        "torque_reduction": 1 - torque_squared / without if cycles else None,
        "torque_reduction_optimal": 1 - optimal / without,
        "torque_squared": torque_squared,
        "torque_squared_without_springs": without,
        "torque_squared_optimal": optimal,
        "tracking_rms": last("tracking_rms"),
        **({"rotation_rms": last("rotation_rms")} if "rotation_rms" in mine else {}),
        "stiffness": last("stiffness_per_cycle"),
        "stiffness_optimal": data["stiffness_optimal"].values.tolist(),
        "offset": last("offset_per_cycle"),
        "offset_optimal": data["offset_optimal"].values.tolist(),
        "cycles_to_optimum": cycles_to_optimum(mine["torque_squared"].values, optimal),
    }
