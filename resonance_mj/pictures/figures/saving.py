"""Writing figures as files, each complete before it takes its name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from ...files import replacing
from ...forking import meanwhile
from .sizes import DPI, FORMATS
from .style import STYLE


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
        dpi: pixels per inch of a PNG.

    Returns:
        The files, in the order of `formats`.

    Raises:
        OutputError: a file cannot be written.
    """
    paths = {kind: folder / f"{name}.{kind}" for kind in formats}
    work = {kind: _writer(kind, drawn, path, dpi) for kind, path in paths.items()}
    png = work.pop("png", None)
    if png and work:
        with meanwhile(png) as done:
            for write in work.values():
                write()
        if not done():
            png()
    else:
        for write in filter(None, (png, *work.values())):
            write()
    return list(paths.values())


def _writer(kind: str, drawn: Figure, path: Path, dpi: float) -> Callable[[], None]:
    # Each canvas is told to print itself: Figure.savefig draws everything twice.
    def write() -> None:
        with matplotlib.rc_context(STYLE), replacing(path) as beside:
            if kind == "svg":
                FigureCanvasSVG(drawn).print_svg(beside, metadata={"Date": None})
            elif kind == "pdf":
                from matplotlib.backends.backend_pdf import FigureCanvasPdf

                FigureCanvasPdf(drawn).print_pdf(beside, metadata={"CreationDate": None})
            else:
                drawn.set_dpi(dpi)
                FigureCanvasAgg(drawn).print_png(beside, pil_kwargs={"compress_level": 6})

    return write
