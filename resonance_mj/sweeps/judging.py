"""How good a trial is: its figure, and how far it is beyond the constraints."""

import math
from collections.abc import Mapping
from typing import Any

from ..experiments.tuning import Tuning
from .dataset import Outcome

OF_RUN = ("torque_share", "cost_share")
"""Figures besides those of summary.json: of the possible reduction."""

NO_FIGURE = 1e30
"""What a run without the figure counts as; such a run is no best."""


def _figure(name: str, motion: Mapping[str, Any], *, cycles: int) -> float:
    """A figure of a motion; NaN where it has none."""
    if name in OF_RUN:
        of = name.removesuffix("_share")
        part, best = motion[f"{of}_reduction"], motion[f"{of}_reduction_optimal"]
        return math.nan if part is None or not best else part / best
    value = motion[name]
    if name == "cycles_to_optimum" and value is None:
        return cycles + 1.0  # it has not come there yet
    return math.nan if value is None else float(value)


def _worst(name: str, outcome: Outcome, *, least: bool) -> float:
    """A figure of a run: of its motions the least or the greatest, NaN if one has none."""
    cycles = len(outcome.cycles["torque_squared"])
    values = [_figure(name, motion, cycles=cycles) for motion in outcome.motions]
    if not values or any(map(math.isnan, values)):
        return math.nan
    return min(values) if least else max(values)


def objective(settings: Tuning, outcome: Outcome) -> float:
    """The figure that is to be best, of a run; `NO_FIGURE`, of either sign, where it has none."""
    value = _worst(settings.figure, outcome, least=settings.maximize is not None)
    if math.isnan(value):
        return NO_FIGURE if settings.minimize else -NO_FIGURE
    return value


def beyond(settings: Tuning, outcome: Outcome) -> dict[str, float]:
    """How far an outcome is beyond each constraint, and 1 for a run that is not ok."""
    missing = abs(objective(settings, outcome)) >= NO_FIGURE
    found = {"status": float(outcome.status != "ok" or missing)}
    for name, ends in settings.constraints.items():
        values = _worst(name, outcome, least=True), _worst(name, outcome, least=False)
        found[name] = NO_FIGURE if any(map(math.isnan, values)) else max(map(ends.excess, values))
    return found
