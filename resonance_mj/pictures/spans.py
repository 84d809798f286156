"""Where in a run something happens: what a time axis and a film show of it."""

from ..results.run import Run

CYCLES = 2
"""Cycles that are shown at the start, on either side of a change of motion, and at the end."""


def spans(run: Run, end: float) -> list[tuple[float, float]]:
    """The start, either side of each change of motion, and the last cycles before `end` [s].

    Returns:
        Begin and end of each span [s]; in order, and none touches another.
    """
    found: list[tuple[float, float]] = []
    for motion in run.motions:
        if motion.start >= end > 0:
            break
        stop, length = min(motion.end, end), CYCLES * motion.period
        for low, high in (
            (motion.start, min(motion.start + length, stop)),
            (max(motion.start, stop - length), stop),
        ):
            if found and low <= found[-1][1] + 1e-9:
                low, before = found.pop()
                high = max(high, before)
            found.append((low, high))
    return found
