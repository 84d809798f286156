"""The figures that can be drawn of runs: what each shows, what it needs; drawn, and written.

Nothing is imported to draw with until a figure is drawn.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, cast

from ...errors import PictureError
from ...files import replacing, writable
from ...text import nearest, shown
from .asked import PAGE, inches, look

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from ...results.run import Run
    from .style import Look

FORMATS = ("svg", "png")
"""As what a figure is written if nothing else is asked for."""

DPI, DRAFT = 300.0, 170.0
"""Pixels per inch of a PNG, and of the one that each run leaves: in print, and on a screen."""

COARSEST, FINEST = 50, 1200
"""Pixels per inch of a PNG."""

KINDS: Mapping[str, Mapping[str, None]] = {
    "svg": {"Date": None},
    "png": {},
    "pdf": {"CreationDate": None},
}
"""As what a figure can be written, and what its file says of itself: not when it was made."""

MOST_PIXELS = 65000
"""Along a side of a PNG; matplotlib draws no more than 65 535."""

SAMPLES, CYCLE, RECORDED_CYCLE = "samples in time", "a whole cycle", "a whole cycle with samples"
"""What a run may be needed to have."""

LINEAR = "linear springs, and of each motion a last cycle with samples that follows its path"
"""The same, of springs to build or buy."""


@dataclass(frozen=True)
class Entry:
    """A figure of the catalogue.

    Attributes:
        name: how it is asked for: its module in this package, and the value of `--figure`.
        title: what it is, in a few words.
        caption: what is shown and how to read it.
        needs: what each run must have: `SAMPLES`, `CYCLE`, `RECORDED_CYCLE` or `LINEAR`.
        several: whether it draws several runs in one figure; if not, it draws one.
        stem: of the files that it is saved as; `name` if empty.
    """

    name: str
    title: str
    caption: str
    needs: str
    several: bool = False
    stem: str = ""

    def lacks(self, runs: Sequence[Run]) -> str:
        """Why it cannot be drawn of some runs, in words; empty if it can."""
        if self.several and len(runs) < 2:
            return f"shows several runs, and {len(runs)} was given"
        if not self.several and len(runs) != 1:
            return f"shows one run, and {len(runs)} were given"
        for run in runs:
            if not _has(run, self.needs):
                return f"needs {self.needs}, and the run {run.experiment.name} has none"
        return ""

    def draw(self, runs: Sequence[Run], width: float = PAGE, asked: Look | None = None) -> Figure:
        """Draw it.

        Args:
            runs: one run, or several where the figure shows several.
            width: of the figure [in].
            asked: what else is asked of it.

        Returns:
            The figure, `width` wide and as high as it must be, or as is asked.

        Raises:
            PictureError: it cannot be drawn of these runs.
        """
        from .style import styled

        lacks = self.lacks(runs)
        if lacks:
            raise PictureError(f"figure {self.name}: {lacks}")
        module = import_module(f".{self.name}", __package__)
        with styled(asked=asked):
            drawn: Figure = module.draw(runs if self.several else runs[0], width)
        return drawn


FIGURES = (
    Entry(
        name="overview",
        title="Motion, springs and motor torque over time",
        caption="The layout of the paper's Fig. 4: tool position with its reference, stiffness and "
        "offset torque with their optimum, motor torque with the optimum's, and torque² per cycle. "
        "Grey bands leave out cycles in which little happens.",
        needs=SAMPLES,
        stem="figure",
    ),
    Entry(
        name="cycles",
        title="Torque² and tracking per cycle",
        caption="Mean of τᵀτ over each cycle between that without springs and that of the optimal "
        "constant springs, on a logarithmic scale, and the root mean square of the tracking error. "
        "Vertical lines mark changes of motion, grey bands the passage into one; a diamond marks "
        "the cycle from which torque² stays within 5 % of the optimum's.",
        needs=CYCLE,
    ),
    Entry(
        name="springs",
        title="Torque over joint angle: what the springs took from the motors",
        caption="Last recorded cycle of each motion. The loop is the torque that the motion needs, "
        "spring and motor together; the line is the spring's share, k and the equilibrium angle qₑ "
        "those of the line fitted to it, and the rest is left to the motor. Brief jumps of torque "
        "may leave a panel.",
        needs=RECORDED_CYCLE,
    ),
    Entry(
        name="path",
        title="Path of the tool",
        caption="Desired path and where the tool went in the first cycle after the passage into "
        "the motion and in the last recorded one, in the plane of the motion; beside it how far "
        "the tool was from where it should be, and its rotation vector, over the cycle.",
        needs=RECORDED_CYCLE,
    ),
    Entry(
        name="parts",
        title="Springs to build or buy",
        caption="The best stiffness of each spring along each motion as it was made last, and "
        "those that cost at most 1 % and 5 % of what it costs without springs more, each with "
        "its best rest angle. Below, of several motions, the cost over all of them without "
        "springs, with the best springs that are the same in all, and with the best of each.",
        needs=LINEAR,
    ),
    Entry(
        name="convergence",
        title="Convergence of several runs",
        caption="Mean of τᵀτ over each cycle as a multiple of that of each run's own optimum, and "
        "the root mean square of the tracking error. The band is within 5 % of the optimum; a "
        "cross marks where a run diverged.",
        needs=CYCLE,
        several=True,
    ),
)
"""In the order in which they are shown."""


def fitting(runs: Sequence[Run]) -> list[Entry]:
    """The figures that can be drawn of some runs, in order.

    Args:
        runs: one run, or several that are compared.
    """
    return [entry for entry in FIGURES if not entry.lacks(runs)]


def named(name: str) -> Entry:
    """The figure of a name.

    Raises:
        PictureError: there is none.
    """
    found = {entry.name: entry for entry in FIGURES}
    if name not in found:
        there = f"{nearest(name, [*found])}; there are {', '.join(found)}"
        raise PictureError(f"figure {shown(name)} is unknown{there}")
    return found[name]


def plot(
    runs: Run | Sequence[Run] | xr.Dataset,
    folder: str | os.PathLike[str],
    *,
    figures: Sequence[str] | None = None,
    formats: Sequence[str] = FORMATS,
    width: str | float = "page",
    dpi: float = DPI,
    height: float | None = None,
    title: bool = False,
    font: str | None = None,
    font_size: float = 8.0,
) -> list[Path]:
    """Draw figures of a run, or several runs in one figure, and write them as files.

    Nothing is written unless all can be drawn.

    Args:
        runs: one run, several that are compared, or the dataset of a sweep.
        folder: where to write; made if needed.
        figures: names from the catalogue: overview, cycles, springs, path of one run, convergence
            of several; of a sweep figures per motion as in its dataset, or torque_share. All that
            can be drawn of these runs if None, of a sweep torque_share and cycles_to_optimum.
        formats: any of svg, png and pdf.
        width: column (3.5 in), page (7.16 in), or inches.
        dpi: pixels per inch of a PNG; fewer where it would have more than 65 000 along a side.
        height: of a figure [in]; what its panels need if None.
        title: whether what was run stands above a figure. How a run ended that is not ok does so
            in any case.
        font: family of the letters, one that is installed, or serif, sans-serif or monospace;
            matplotlib's own if None.
        font_size: of titles and labels [pt]; numbers and the heading follow.

    Returns:
        The files that were written.

    Raises:
        PictureError: a figure, format, width, height, font or resolution is not valid, or a run
            lacks what a figure shows.
        OutputError: the folder cannot be written.
    """
    wide, asked = inches(width), look(height, title, font, font_size)
    unknown = [kind for kind in formats if kind not in KINDS]
    if unknown or not formats:
        what = f"format {shown(unknown[0])} is unknown" if unknown else "no format is given"
        raise PictureError(f"{what}; there are {', '.join(KINDS)}")
    if not COARSEST <= dpi <= FINEST:
        raise PictureError(f"dpi {dpi:g}: give pixels per inch from {COARSEST} to {FINEST}")
    if hasattr(runs, "data_vars"):
        from . import sweep_figure

        metrics = figures or ("torque_share", "cycles_to_optimum")
        data = cast("xr.Dataset", runs)
        drawn = [(one, sweep_figure.figure(data, one, wide, asked)) for one in metrics]
    else:
        several = list(cast("Iterable[Run]", runs)) if isinstance(runs, Iterable) else [runs]
        chosen = [named(name) for name in dict.fromkeys(figures or [])] or fitting(several)
        if not chosen:
            reasons = "; ".join(f"{one.name} {one.lacks(several)}" for one in FIGURES)
            raise PictureError(f"no figure can be drawn: {reasons}")
        drawn = [(entry.stem or entry.name, entry.draw(several, wide, asked)) for entry in chosen]
    folder = writable(folder)
    return [path for stem, each in drawn for path in save(each, folder, stem, formats, dpi)]


def save(
    drawn: Figure,
    folder: Path,
    name: str,
    formats: Sequence[str] = FORMATS,
    dpi: float = DPI,
) -> list[Path]:
    """Write a figure into `folder`.

    Args:
        drawn: the figure.
        folder: that exists.
        name: of the files, without their suffix.
        formats: any of svg, png and pdf.
        dpi: pixels per inch of a PNG; fewer where it would have more than matplotlib draws.

    Returns:
        The files, in the order of `formats`.

    Raises:
        OutputError: a file cannot be written.
    """
    from .style import styled

    paths = {kind: folder / f"{name}.{kind}" for kind in formats}
    dpi = min(dpi, MOST_PIXELS / max(drawn.get_size_inches()))
    for kind, path in paths.items():
        with replacing(path) as beside, styled():
            drawn.savefig(beside, format=kind, dpi=dpi, metadata=KINDS[kind])
    return list(paths.values())


def _has(run: Run, needs: str) -> bool:
    data, whole = run.data, run.data.sizes.get("cycle", 0)
    if needs == CYCLE:
        return bool(whole)
    if not data.sizes.get("time", 0) or "q" not in data:
        return False
    if needs == LINEAR:
        of_samples = set(data["cycle_of_sample"].values.tolist())
        of_cycle = data["segment_of_cycle"].values.tolist()
        seen = {of_cycle[cycle - 1] for cycle in of_samples if cycle <= whole}
        tracks = all(len(one.cycles) and one.tracks[-1] for one in run.motions)
        return tracks and run.material is None and len(seen) == len(run.motions)
    # A run that diverged ends within a cycle.
    return needs == SAMPLES or bool((data["cycle_of_sample"] <= whole).any())
