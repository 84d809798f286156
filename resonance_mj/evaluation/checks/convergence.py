"""How a figure that missed its expectation went from cycle to cycle: in words and as a plot."""

import math
from collections.abc import Mapping

import numpy as np

from ...results.metrics import OPTIMUM_BAND
from ...results.run import Run
from .check import Band, Judgement

WIDTH, HEIGHT = 60, 8
"""Of the plot's area, in characters."""

PACE = 5
"""Cycles over which the pace of convergence is measured."""


def explain(missed: Judgement) -> str:
    """What was found, how far off it is, in which cycle it would have passed, and a plot."""
    band, course = missed.band, missed.history
    where = f"motion {missed.motion}, " if missed.motion else ""
    within = f" ± {tolerance(band)}" if tolerance(band) else ""
    found = f"found {number(missed.found, band)}, expected {expected(band)}{within}"
    lines = [f"{where}{figure(missed)}: {found}"]
    if missed.why:
        lines[0] += f": {missed.why}"
    if missed.figure == "cycles_to_optimum":
        band = Band(1.0, True, 1 - OPTIMUM_BAND, 1 + OPTIMUM_BAND)
        lines[0] += "; as a multiple of the optimum's, in each cycle:"
    elif isinstance(missed.found, float):
        lines[0] += f": {distance(missed.found, band)}"
        lines.append(f"  {when(course, band)}")
    if np.isfinite(course).any():
        lines += [f"  {line}" for line in plot(course, band)]
    return "\n".join(lines)


def report(run: Run, judgements: list[Judgement]) -> str:
    """All that a run missed, why it ended early, and where its numbers came from; empty if none."""
    missed = [one for one in judgements if not one.passed]
    if not missed:
        return ""
    name = run.experiment.name
    lines = [f"{name}: {len(missed)} of {len(judgements)} expectations missed"]
    if run.message:
        lines.append(f"{name}: {run.status}: {run.message}")
    if run.experiment.expect.versions and any(is_number(one) for one in missed):
        lines.append(f"{name}: {provenance(run.experiment.expect.versions, run.versions)}")
    return "\n".join([*lines, *map(explain, missed)])


def is_number(judgement: Judgement) -> bool:
    """Whether what is expected is a number with a tolerance, kept from an earlier run."""
    return isinstance(judgement.band.expected, float) and not judgement.band.optimal


def provenance(versions: Mapping[str, str], present: Mapping[str, str]) -> str:
    """Which versions the expected numbers came from, and which the run is of."""
    then = ", ".join(f"{name} {version}" for name, version in versions.items())
    now = ", ".join(f"{name} {present[name]}" for name in versions if name in present)
    return f"the numbers expected came from {then}; this run is of " + (
        "the same" if now == then else now
    )


def figure(judgement: Judgement) -> str:
    """Which figure it is, of which joint, with its unit."""
    unit = f"[{judgement.unit}]" if judgement.unit else ""
    return " ".join(filter(None, (judgement.figure, judgement.joint, unit)))


def expected(band: Band) -> str:
    """The expected value alone, or the bounds."""
    if isinstance(band.expected, str):
        return band.expected
    if band.expected is None:
        ends = ((band.low, "at least"), (band.high, "at most"))
        return " and ".join(f"{words} {end:g}" for end, words in ends if math.isfinite(end))
    return ("optimal " if band.optimal else "") + number(band.expected, band)


def tolerance(band: Band) -> str:
    """How far from the expected value passes; empty for bounds and words."""
    if not isinstance(band.expected, float) or math.isnan(band.expected):
        return ""
    width = (band.high - band.low) / 2
    return f"{width:.2g}" if math.isfinite(width) else "any"


def number(value: float | str | None, band: Band) -> str:
    """A value with as many decimals as the tolerance has two digits for."""
    if isinstance(value, str | int):
        return str(value)
    if value is None or math.isnan(value):
        return "none"
    width = (band.high - band.low) / 2
    decimals = max(0, 1 - math.floor(math.log10(width))) if 0 < width < math.inf else math.inf
    if decimals > 9:
        return f"{value or 0.0:.6g}"
    text = f"{value:.{decimals}f}"
    return text if float(text) else text.removeprefix("-")


def distance(found: float, band: Band) -> str:
    """By how much a value is off: from the expected one, or from the bound."""
    reference = band.expected
    if not isinstance(reference, float):
        reference = band.low if found < band.low else band.high
    miss = found - reference
    percent = 100 * abs(miss / reference) if reference else math.nan
    share = f" ({percent:.{0 if percent >= 10 else 1}f} % of it)" if reference else ""
    return f"{abs(miss):.3g} too {'low' if miss < 0 else 'high'}{share}"


def when(course: np.ndarray, band: Band) -> str:
    """In which cycles of a motion the figure was within its band, or would be by its pace.

    Args:
        course: the figure in each cycle (cycles,); NaN where it was not kept.
        band: what passes.
    """
    inside = np.flatnonzero((course >= band.low) & (course <= band.high)) + 1
    if inside.size:
        first, last = int(inside[0]), int(inside[-1])
        between = "" if inside.size == last - first + 1 else "some of "
        cycles = f"cycle {first}" if first == last else f"{between}cycles {first} to {last}"
        return f"it would have passed in {cycles} of {len(course)}"
    off = np.maximum(band.low - course, course - band.high)
    if not np.isfinite(off).any():
        return f"it would have passed in none of the {len(course)} cycles"
    nearest = int(np.nanargmin(off)) + 1
    text = f"it would have passed in none of the {len(course)} cycles, nearest in cycle {nearest}"
    if not isinstance(band.expected, float) or len(course) <= PACE:
        return text
    # A figure that nears its value geometrically goes on at the pace of its last cycles.
    before, now = (abs(float(course[at]) - band.expected) for at in (-1 - PACE, -1))
    width = band.high - band.expected
    if not (0 < width < now < before):
        return text
    later = len(course) + PACE * math.log(width / now) / math.log(now / before)
    if later >= 10 * len(course):
        return text
    return f"{text}; by the pace of its last cycles it will in about cycle {math.ceil(later)}"


def plot(course: np.ndarray, band: Band) -> list[str]:
    """A figure from cycle to cycle: `*` in a cycle, `-` at the ends of the band that passes.

    Args:
        course: the figure in each cycle (cycles,); NaN where it was not kept.
        band: what passes; drawn as far as it is finite.

    Returns:
        Lines. What lies far beyond most of the cycles, as a first one may, is drawn as `^` or `v`.
    """
    values = course[np.isfinite(course)]
    ends = [end for end in (band.low, band.high) if math.isfinite(end)]
    usual = [*np.quantile(values, (0.1, 0.9)), values[-1], *ends]
    low, high = min(usual), max(usual)
    if low == high:
        low, high = low - 1, high + 1

    def row(value: float) -> int:
        return round((high - value) / (high - low) * (HEIGHT - 1))

    columns = min(WIDTH, len(course))
    grid = [[" "] * columns for _ in range(HEIGHT)]
    for end in ends:
        grid[row(end)] = ["-"] * columns
    for column in range(columns):
        # Of the cycles that share a column the last is drawn.
        value = course[(column + 1) * len(course) // columns - 1]
        if not math.isnan(value):
            mark = "^" if value > high else "v" if value < low else "*"
            grid[row(min(max(value, low), high))][column] = mark
    labels = {row(end): f"{end:.4g}" for end in (low, high, *ends)}
    margin = max(map(len, labels.values()))
    lines = [f"{labels.get(i, ''):>{margin}} |{''.join(grid[i])}" for i in range(HEIGHT)]
    last = str(len(course))
    return [*lines, " " * (margin + 2) + "1" + last.rjust(columns - 1) * (columns > 1) + "  cycle"]
