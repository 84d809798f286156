"""`resonance-mj version`: versions, for a report of a result or a problem."""

from __future__ import annotations

import argparse

from .console import DONE

HELP = "versions of this program and what it uses"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The command has none."""


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from ..results.run import versions

    for name, number in versions().items():
        print(f"{name} {number}")
    return DONE
