"""The commands about the program itself: what comes with it, and of which versions it is."""

from argparse import Namespace

from .. import library
from .command import command, console


@command()
def list_(_: Namespace) -> None:
    """The experiments and robots that come with the program."""
    from rich.table import Table

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


@command()
def keys(_: Namespace) -> None:
    """Every key of an experiment, with unit and default."""
    from rich.table import Table

    from ..experiments.keys import describe

    table = Table("key", "default", "meaning", box=None, padding=(0, 2, 0, 0))
    for row in describe():
        table.add_row(*row)
    console().print(table)


@command()
def version(_: Namespace) -> None:
    """Versions of this program and what it uses."""
    from ..results.run import versions

    for name, number in versions().items():
        print(f"{name} {number}")
