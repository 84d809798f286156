"""A figure as a part of a page: its names are its own, its colours follow light and dark."""

from __future__ import annotations

import io
import math
import re
from dataclasses import dataclass

import matplotlib
from markupsafe import Markup, escape
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

DARK_PAPER, DARK_INK = 0x17, 0xEC
"""Greys of the page's dark paper and ink, from 0 to 255; --panel and --ink in style.css."""
CONTRAST = 3.0
"""What a coloured line has at least against the dark paper, as WCAG asks of graphics; more would
make the palette's blues alike."""
MANY = 24
"""Colours from which on a figure shows a colour map, whose order must not change."""


@dataclass(frozen=True)
class Drawing:
    """A figure as SVG for a page.

    Attributes:
        svg: the element.
        width: its own width [CSS pixels].
        dark: on dark paper: #rrggbb -> what it becomes.
    """

    svg: Markup
    width: int
    dark: dict[str, str]


def inline(drawn: Figure, name: str, title: str) -> Drawing:
    """Turn a figure into an SVG element.

    Args:
        drawn: the figure.
        name: begins every id in it: no other drawing of the page may have it.
        title: what the drawing is called where it cannot be seen.
    """
    file = io.StringIO()
    # The ids are found from the salt: the same figure gives the same page. Text stays text.
    with matplotlib.rc_context({"svg.hashsalt": name, "svg.fonttype": "none"}):
        FigureCanvasSVG(drawn).print_svg(file, metadata={"Date": None})
    text = file.getvalue()
    head, _, body = text[text.index("<svg") :].partition(">")
    view = re.search(r'viewBox="0 0 ([\d.]+) [\d.]+"', head)
    assert view is not None
    # Who made it is of no use here, and a style of `*` would hold for the whole page.
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", body, flags=re.DOTALL)
    body = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", body)
    body = body.replace(" \n", "\n")
    colours = set(re.findall(r"(?:fill|stroke): (#[0-9a-f]{6})", body))
    dark = _dark(colours)
    body = re.sub(
        r"(fill|stroke): #([0-9a-f]{6})",
        lambda found: (
            f"{found[1]}: var(--c{found[2]}, #{found[2]})" if f"#{found[2]}" in dark else found[0]
        ),
        body,
    )
    return Drawing(
        svg=Markup(
            f'<svg viewBox="{view[0][9:-1]}" role="img" aria-label="{escape(title)}">{body}'
        ),
        width=round(float(view[1]) * 4 / 3),
        dark=dark,
    )


def style(drawings: list[Drawing]) -> Markup:
    """What the colours of drawings become on dark paper, as declarations of CSS variables."""
    dark = {name: colour for drawing in drawings for name, colour in drawing.dark.items()}
    return Markup(" ".join(f"--c{name[1:]}: {dark[name]};" for name in sorted(dark)))


def _dark(colours: set[str]) -> dict[str, str]:
    """Greys are turned over between paper and ink; colours are lightened until they are seen."""
    found = {}
    for colour in colours:
        r, g, b = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
        if r == g == b:
            grey = round(DARK_INK + (DARK_PAPER - DARK_INK) * r / 255)
            found[colour] = f"#{grey:02x}{grey:02x}{grey:02x}"
    coloured = colours - set(found)
    if len(coloured) < MANY:
        found |= {colour: _lightened(colour) for colour in coloured}
    return found


def _lightened(colour: str) -> str:
    rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    paper = _luminance([DARK_PAPER] * 3) + 0.05
    while (_luminance(rgb) + 0.05) / paper < CONTRAST:
        rgb = [min(255, math.ceil(part + 0.05 * (255 - part))) for part in rgb]
    return "#" + "".join(f"{part:02x}" for part in rgb)


def _luminance(rgb: list[int]) -> float:
    """Relative luminance of WCAG 2."""
    linear = [
        part / 255 / 12.92 if part <= 10 else ((part / 255 + 0.055) / 1.055) ** 2.4 for part in rgb
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
