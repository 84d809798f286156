"""A figure as a part of a page: drawn once, for every screen, and its names are its own."""

from __future__ import annotations

import io
import re

from markupsafe import Markup, escape
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from ..figures.style import STYLE, styled

WIDTH = 4.8
"""Of a figure [in]: its letters can be read on a phone, which shrinks it by a third, and on a desk,
which enlarges it by half. In the dark the page's style turns light and dark over."""


def inline(drawn: Figure, name: str, title: str) -> Markup:
    """Turn a figure into an SVG element.

    Args:
        drawn: the figure.
        name: begins every id in it: no other drawing of the page may have it.
        title: what the drawing is called where it cannot be seen.
    """
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
