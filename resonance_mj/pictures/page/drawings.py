"""Figures as parts of a page: drawn once, for every screen, and their names are their own."""

import io
import re
from collections.abc import Callable, Sequence

from markupsafe import Markup, escape
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from ...results.run import Run
from ..figures.catalogue import Entry
from ..figures.style import STYLE, styled

WIDTH = 4.8
"""Of a figure [in]: its letters can be read on a phone, which shrinks it by a third, and on a desk,
which enlarges it by half. In the dark the page's style turns light and dark over."""


Figures = list[tuple[Entry, Markup]]
"""Figures of the catalogue, each as a part of the page."""


def figures(
    entries: Sequence[Entry], runs: Sequence[Run], anchor: str, done: Callable[[], None]
) -> Figures:
    """Draw figures for a page.

    Args:
        entries: which.
        runs: of which runs.
        anchor: begins their ids.
        done: is called after each.
    """
    drawn = []
    for entry in entries:
        figure = entry.draw(runs, WIDTH)
        drawn.append((entry, _inline(figure, f"{anchor}-{entry.name}", entry.title)))
        done()
    return drawn


def _inline(drawn: Figure, name: str, title: str) -> Markup:
    """An SVG element, in which every id begins with a name that no other of the page has."""
    file = io.StringIO()
    # The ids are found from the salt: the same figure gives the same page.
    with styled({**STYLE, "svg.hashsalt": name}):
        FigureCanvasSVG(drawn).print_svg(file, metadata={"Date": None})
    text = file.getvalue()
    head, _, body = text[text.index("<svg") :].partition(">")
    view = re.search(r'viewBox="[\d. ]+"', head)
    assert view is not None
    # Who made it is of no use here, and a style of `*` would hold for the whole page.
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", body, flags=re.DOTALL)
    body = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", body)
    body = body.replace(" \n", "\n")
    return Markup(f'<svg {view[0]} role="img" aria-label="{escape(title)}">{body}')
