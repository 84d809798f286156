"""The page itself: a template filled, with style, script, film and figures inside it."""

import base64
import io
import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from ... import text
from ...evaluation.checks import convergence
from ...results.run import Run, finite, versions
from ..figures.catalogue import KINDS, Entry
from ..figures.curves import curves
from ..figures.style import STYLE, styled
from ..figures.time_axes import times
from .content import best
from .scene import BUNDLE

TEMPLATES = Path(__file__).parent / "templates"

WIDTH = 4.8
"""Of a figure [in]: its letters can be read on a phone, which shrinks it by a third, and on a desk,
which enlarges it by half. In the dark the page's style turns light and dark over."""


def live(label: str, scene: str) -> str:
    """The page of a run that is watched: its scene, which draws frames as they come.

    Args:
        label: what the page is called.
        scene: what does not change, as JSON.
    """
    return _environment().get_template("live.html").render(label=label, scene=scene)


def html(template: str = "page.html", **page: Any) -> str:
    """The page as text.

    Args:
        template: page.html, of runs, or sweep.html.
        page: what the template shows, of runs: `title`; `contents` of each run; `shared`, the
            figures that show all runs; `differences` between the runs' experiments; `film` or None,
            and `film_note`, why there is none or what it leaves out; `scene` or None. Of a sweep
            what `sweep_page` gives.
    """
    environment = _environment()
    environment.globals["judged"] = convergence
    environment.filters |= {
        "minus": text.minus,
        "number": _data(text.number),
        "percent": _data(text.percent),
        "metres": _data(text.length),
        "radians": _data(text.angle),
        "json": lambda value: json.dumps(finite(value), indent=2),
    }
    return environment.get_template(template).render(
        page=page, best=best, version=versions()["resonance-mj"]
    )


def _environment() -> jinja2.Environment:
    """Templates with what all pages have: style, script, and the script that draws a scene."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_placeless,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {
        "asset": lambda name: Markup((TEMPLATES / name).read_text(encoding="utf-8")),
        "bundle": Markup(BUNDLE.read_text(encoding="utf-8")),
    }
    environment.filters["data_uri"] = _data_uri
    return environment


def inline(entry: Entry, runs: Sequence[Run], anchor: str) -> Markup:
    """A figure of runs as an SVG element, whose ids begin with `anchor` and the figure's name."""
    return element(entry.draw(runs, WIDTH), f"{anchor}-{entry.name}", entry.title)


def element(drawn: Figure, name: str, title: str) -> Markup:
    """A figure as an SVG element of a title, whose ids begin with `name`."""
    file = io.StringIO()
    panels = curves(drawn)
    # The ids are found from the salt: the same figure gives the same page.
    with styled({**STYLE, "svg.hashsalt": name}):
        drawn.savefig(file, format="svg", metadata=KINDS["svg"])
    text = file.getvalue()
    head, _, body = text[text.index("<svg") :].partition(">")
    view = re.search(r'viewBox="[\d. ]+"', head)
    assert view is not None
    # Who made it is of no use here, and a style of `*` would hold for the whole page.
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", body, flags=re.DOTALL)
    body = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", body)
    body = body.replace(" \n", "\n")
    label = f'role="img" aria-label="{escape(title)}"'
    if moments := times(drawn):
        label += f' data-time="{escape(json.dumps(moments))}"'
    for panel in panels:
        panel["curves"] = {f"{name}-{one}": words for one, words in panel["curves"].items()}
    label += f' data-panels="{escape(json.dumps(panels))}"'
    return Markup(f"<svg {view[0]} {label}>{body}")


def _data(written: Callable[..., str]) -> Callable[..., Markup]:
    """A number as it is read, with all its digits for programs."""

    def as_data(value: float | None, *digits: int) -> Markup:
        shown = text.minus(written(value, *digits))
        if shown == text.NOTHING:
            return Markup(shown)
        return Markup('<data value="{}">{}</data>').format(value, shown)

    return as_data


def _data_uri(content: str | bytes, kind: str) -> Markup:
    """A text or a file as an address that holds it."""
    data = content if isinstance(content, bytes) else _placeless(content).encode()
    return Markup(f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}")


def _placeless(value: Any) -> Any:
    """A text without the folders of absolute paths: a page is sent, and they are its sender's."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    return FOLDERS.sub("", value)


FOLDERS = re.compile(
    r"""
    (?<=["'])(?:/|[A-Za-z]:[\\/])[^"'\n]*[\\/](?=[^"'\\/\n]*["'])  # in quotes, with spaces
    | (?<![\w.:/<~])/(?:[^\s/"'<>:;,]+/)+                        # /home/user/
    | (?<!\w)[A-Za-z]:[\\/]+(?:[^\s\\/"'<>:;,]+[\\/]+)+            # C:\\Users\\user\\
    """,
    re.VERBOSE,
)
"""What stands before the name of a file in an absolute path."""
