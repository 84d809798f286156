"""Every figure that can be drawn of runs, in the order in which a report shows them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from ..results.run import Run
from . import figures


@dataclass(frozen=True)
class Entry:
    """A figure that can be drawn.

    Attributes:
        name: of its file, without ending.
        title: what it shows, in a few words.
        caption: how to read it.
        several: whether it shows several runs in one.
        draw: makes it from the runs.
    """

    name: str
    title: str
    caption: str
    several: bool
    draw: Callable[[Sequence[Run]], Figure]


ENTRIES = (
    Entry(
        "figure",
        "The run",
        "The desired and the measured motion of the tool, stiffness and offset torque of each "
        "joint, motor torque, and torque² in each cycle. Dashed orange: the optimum of constant "
        "springs, which the law does not know.",
        False,
        lambda runs: figures.figure(runs[0]),
    ),
)


def fitting(runs: Sequence[Run]) -> list[Entry]:
    """The figures that can be drawn of these runs, in order."""
    drawable = all(run.data.sizes["time"] for run in runs)
    return [entry for entry in ENTRIES if drawable and (len(runs) == 1 or entry.several)]
