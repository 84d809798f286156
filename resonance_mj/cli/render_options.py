"""What a picture of a run shows and how, as options: what videos and windows have in common."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..pictures.film.options import RenderOptions

PARTS = {
    "path": "the desired path",
    "trail": "the tool's recent trail",
    "springs": "springs and equilibria",
    "motors": "the motors' torque",
    "plots": "the plots below",
    "head-up": "the line above",
    "legend": "what the overlays mean",
}
"""What can be left out, by the names of RenderOptions."""


def add_span(parser: argparse.ArgumentParser) -> None:
    """Let a parser take a span of a run, as `options.start` and `options.stop`."""
    add = parser.add_argument
    add("--from", dest="start", metavar="TIME", help="seconds, or a cycle: 8c begins with the 8th")
    add("--to", dest="stop", metavar="TIME", help="seconds, or a cycle: 10c ends with the 10th")


def add_options(
    parser: argparse.ArgumentParser, backgrounds: str, without: Sequence[str] = ()
) -> None:
    """Let a parser take what `chosen` reads.

    Args:
        parser: the parser.
        backgrounds: those there are, in words.
        without: parts of `PARTS` that the picture never has.
    """
    add = parser.add_argument
    add(
        "--camera",
        metavar="NAME|VIEW",
        help="of the model, or azimuth,elevation,distance as in --camera=120,-20,1.5; "
        "one that frames the motion",
    )
    add("--follow", action="store_true", help="go with the tool")
    add("--background", metavar="KIND", default="sky", help=f"{backgrounds}; sky")
    for part, meaning in PARTS.items():
        if part not in without:
            add(f"--no-{part}", action="store_true", help=f"leave out {meaning}")


def chosen(options: argparse.Namespace, **more: Any) -> RenderOptions:
    """What the options of `add_options` ask for, and `more`."""
    from ..pictures.film.options import RenderOptions

    names = (part.replace("-", "_") for part in PARTS)
    more.update({name: not getattr(options, f"no_{name}", False) for name in names})
    given = {name: getattr(options, name) for name in ("camera", "follow", "background")}
    return RenderOptions(**given, **more)
