"""`resonance-mj list`: what comes with the program."""

from __future__ import annotations

import argparse

from .console import DONE, console

HELP = "the experiments and robots that come with the program"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The command has none."""


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from rich.table import Table

    from .. import library

    screen = console()
    for title, files in (("runs", library.experiments()), ("robots", library.robots())):
        table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
        table.add_column("name", no_wrap=True)
        table.add_column("what it is")
        for name, path in files.items():
            table.add_row(name, library.line(path))
        screen.print(table)
        screen.print()
    screen.print(f"robots are in {library.folder('mjcf')}, runs in {library.folder('runs')}")
    return DONE
