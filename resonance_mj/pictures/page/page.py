"""The page itself: a template filled, with style, script, film and figures inside it."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import dataclass

import jinja2
from markupsafe import Markup

from ...results.run import Run, finite
from ..figures.catalogue import Entry
from ..figures.sizes import COLUMN, PAGE
from . import drawings
from .comparing import Difference, best
from .content import Content
from .drawings import Drawing
from .film import Film


@dataclass(frozen=True)
class Figure:
    """A figure of the catalogue, drawn in two widths."""

    entry: Entry
    wide: Drawing
    narrow: Drawing
    """As wide as a phone."""


@dataclass(frozen=True)
class Page:
    """All that a page shows.

    Attributes:
        title: of the page.
        contents: of each run.
        figures: of each run.
        shared: figures that show all runs.
        differences: between the runs' experiments.
        film: None without.
        film_note: why there is no film, or what it leaves out; empty if nothing is to be said.
        version: of this program.
    """

    title: str
    contents: tuple[Content, ...]
    figures: tuple[tuple[Figure, ...], ...]
    shared: tuple[Figure, ...]
    differences: tuple[Difference, ...]
    film: Film | None
    film_note: str
    version: str

    @property
    def headline(self) -> str:
        """What a comparison comes to, in a sentence."""
        return best(self.contents)

    def html(self) -> str:
        """The page as text."""
        environment = jinja2.Environment(
            loader=jinja2.PackageLoader(__package__, "templates"),
            autoescape=True,
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        environment.filters["data_uri"] = _data_uri
        environment.filters["json"] = lambda value: json.dumps(finite(value), indent=2)

        def asset(name: str) -> Markup:
            assert environment.loader is not None
            return Markup(environment.loader.get_source(environment, name)[0])

        drawn = [figure for group in (self.shared, *self.figures) for figure in group]
        every = [drawing for figure in drawn for drawing in (figure.wide, figure.narrow)]
        return environment.get_template("page.html").render(
            page=self, dark=drawings.style(every), asset=asset
        )


def _data_uri(text: str, kind: str) -> str:
    """A text as an address that holds it."""
    return f"data:{kind};base64,{base64.b64encode(text.encode()).decode('ascii')}"


def figures(
    entries: list[Entry], runs: list[Run], anchor: str, done: Callable[[], None]
) -> tuple[Figure, ...]:
    """Draw figures for a page.

    Args:
        entries: which.
        runs: of which runs.
        anchor: begins their ids.
        done: is called after each.
    """
    drawn = []
    for entry in entries:
        wide, narrow = (
            drawings.inline(
                entry.draw(runs, width), f"{anchor}-{entry.name}-{width:.0f}", entry.title
            )
            for width in (PAGE, COLUMN)
        )
        drawn.append(Figure(entry, wide, narrow))
        done()
    return tuple(drawn)
