"""Draw figures of runs and write them as files, each complete before it takes its name."""

import os
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from ...errors import PictureError
from ...files import replacing, writable
from ...results.run import Run
from ...text import shown
from . import catalogue
from .catalogue import COLUMN, DPI, FORMATS, PAGE
from .style import styled

NARROWEST, WIDEST = 3.0, 20.0
"""Widths of a figure [in]."""

COARSEST, FINEST = 50, 1200
"""Pixels per inch of a PNG."""

KINDS = {"svg": {"Date": None}, "png": {}, "pdf": {"CreationDate": None}}
"""As what a figure can be written, and what its file says of itself: not when it was made."""

MOST_PIXELS = 65000
"""Along a side of a PNG; matplotlib draws no more than 65 535."""


def plot(
    runs: Run | Sequence[Run],
    folder: str | os.PathLike[str],
    *,
    figures: Sequence[str] | None = None,
    formats: Sequence[str] = FORMATS,
    width: str | float = "page",
    dpi: float = DPI,
) -> list[Path]:
    """Draw figures of a run, or several runs in one figure, and write them as files.

    Nothing is written unless all can be drawn.

    Args:
        runs: one run, or several that are compared.
        folder: where to write; made if needed.
        figures: names from the catalogue: overview, cycles, springs, path of one run, convergence
            of several; all that can be drawn of these runs if None.
        formats: any of svg, png and pdf.
        width: column (3.5 in), page (7.16 in), or inches.
        dpi: pixels per inch of a PNG; fewer where it would have more than 65 000 along a side.

    Returns:
        The files that were written.

    Raises:
        PictureError: a figure, format, width or resolution is not valid, or a run lacks what a
            figure shows.
        OutputError: the folder cannot be written.
    """
    several = [runs] if isinstance(runs, Run) else list(runs)
    wide = _inches(width)
    _check(formats, dpi)
    names = list(dict.fromkeys(figures or []))
    chosen = [catalogue.named(name) for name in names] or catalogue.fitting(several)
    if not chosen:
        reasons = "; ".join(f"{one.name} {one.lacks(several)}" for one in catalogue.FIGURES)
        raise PictureError(f"no figure can be drawn: {reasons}")
    drawn = [(entry.stem or entry.name, entry.draw(several, wide)) for entry in chosen]
    folder = writable(folder)
    return [path for stem, each in drawn for path in save(each, folder, stem, formats, dpi)]


@styled()
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
    paths = {kind: folder / f"{name}.{kind}" for kind in formats}
    dpi = min(dpi, MOST_PIXELS / max(drawn.get_size_inches()))
    for kind, path in paths.items():
        with replacing(path) as beside:
            drawn.savefig(beside, format=kind, dpi=dpi, metadata=KINDS[kind])
    return list(paths.values())


def _inches(width: str | float) -> float:
    """A width that a user gave [in]."""
    try:
        found = float({"column": COLUMN, "page": PAGE}.get(str(width), width))
    except (TypeError, ValueError):
        found = float("nan")
    if not NARROWEST <= found <= WIDEST:
        raise PictureError(
            f"width {shown(width)}: give column, page, or inches from {NARROWEST:g} to {WIDEST:g}"
        )
    return found


def _check(formats: Sequence[str], dpi: float) -> None:
    unknown = [kind for kind in formats if kind not in KINDS]
    if unknown or not formats:
        what = f"format {shown(unknown[0])} is unknown" if unknown else "no format is given"
        raise PictureError(f"{what}; there are {', '.join(KINDS)}")
    if not COARSEST <= dpi <= FINEST:
        raise PictureError(f"dpi {dpi:g}: give pixels per inch from {COARSEST} to {FINEST}")
