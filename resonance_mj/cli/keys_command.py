"""`resonance-mj keys`: every key of an experiment file."""

from __future__ import annotations

import argparse

from .console import DONE, console

HELP = "every key of an experiment, with unit and default"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The command has none."""


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from rich.table import Table

    from ..experiments.keys import describe

    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("key", "default", "meaning"):
        table.add_column(heading)
    for key, default, meaning in describe():
        table.add_row(key, default, meaning)
    console().print(table)
    return DONE
