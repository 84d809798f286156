"""Writing figures as files, each complete before it takes its name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from ...files import replacing
from .sizes import DPI, FORMATS
from .style import styled

MOST_PIXELS = 65000
"""Along a side of a PNG; matplotlib draws no more than 65 535."""


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
    for kind, path in paths.items():
        # Each canvas is told to print itself: Figure.savefig draws everything twice.
        with replacing(path) as beside:
            if kind == "svg":
                FigureCanvasSVG(drawn).print_svg(beside, metadata={"Date": None})
            elif kind == "pdf":
                from matplotlib.backends.backend_pdf import FigureCanvasPdf

                FigureCanvasPdf(drawn).print_pdf(beside, metadata={"CreationDate": None})
            else:
                drawn.set_dpi(min(dpi, MOST_PIXELS / max(drawn.get_size_inches())))
                FigureCanvasAgg(drawn).print_png(beside, pil_kwargs={"compress_level": 6})
    return list(paths.values())
