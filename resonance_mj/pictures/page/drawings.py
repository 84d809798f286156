"""Figures as parts of a page: drawn once, for every screen, and their names are their own."""

import io
import re
from collections.abc import Sequence

from markupsafe import Markup, escape

from ...results.run import Run
from ..figures.catalogue import Entry
from ..figures.style import STYLE, styled

WIDTH = 4.8
"""Of a figure [in]: its letters can be read on a phone, which shrinks it by a third, and on a desk,
which enlarges it by half. In the dark the page's style turns light and dark over."""


def inline(entry: Entry, runs: Sequence[Run], anchor: str) -> Markup:
    """A figure of runs as an SVG element, whose ids begin with `anchor` and the figure's name."""
    name, file = f"{anchor}-{entry.name}", io.StringIO()
    drawn = entry.draw(runs, WIDTH)
    # The ids are found from the salt: the same figure gives the same page.
    with styled({**STYLE, "svg.hashsalt": name}):
        drawn.savefig(file, format="svg", metadata={"Date": None})
    text = file.getvalue()
    head, _, body = text[text.index("<svg") :].partition(">")
    view = re.search(r'viewBox="[\d. ]+"', head)
    assert view is not None
    # Who made it is of no use here, and a style of `*` would hold for the whole page.
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", body, flags=re.DOTALL)
    body = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", body)
    body = body.replace(" \n", "\n")
    return Markup(f'<svg {view[0]} role="img" aria-label="{escape(entry.title)}">{body}')
