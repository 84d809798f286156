"""What a picture of a run shows and how, as options: what videos and windows have in common."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..pictures.film.look import Look

PARTS = {
    "path": "the desired path",
    "trail": "the tool's recent trail",
    "springs": "springs and equilibria",
    "motors": "the motors' torque",
    "strip": "the plots below",
    "head-up": "the line above",
    "legend": "what the overlays mean",
}
"""What can be left out, by the names of Look."""


def add_span(parser: argparse.ArgumentParser) -> None:
    """Let a parser take a span of a run, as `options.start` and `options.stop`."""
    add = parser.add_argument
    add("--from", dest="start", metavar="TIME", help="seconds, or a cycle: 8c begins with the 8th")
    add("--to", dest="stop", metavar="TIME", help="seconds, or a cycle: 10c ends with the 10th")


def add_look(
    parser: argparse.ArgumentParser, backgrounds: str, without: Sequence[str] = ()
) -> None:
    """Let a parser take what `look` reads.

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


def look(options: argparse.Namespace, **more: Any) -> Look:
    """The look that the options of `add_look` ask for, and `more` of it."""
    from ..pictures.film.look import Look

    names = (part.replace("-", "_") for part in PARTS)
    more.update({name: not getattr(options, f"no_{name}", False) for name in names})
    return Look(camera=options.camera, follow=options.follow, background=options.background, **more)
