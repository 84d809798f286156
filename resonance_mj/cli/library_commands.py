"""The commands about the program itself: what comes with it, and of which versions it is."""

import json
from argparse import Namespace

from .. import library
from ..errors import ExperimentError
from ..text import cut, nearest
from .command import Screen, argument, command


@command(figures=True)
def list_(options: Namespace) -> None:
    """The experiments, sweeps and robots that come with the program."""
    from rich.table import Table

    files = {
        "runs": library.experiments(),
        "validation": library.validation(),
        "sweeps": library.sweeps(),
        "robots": library.robots(),
    }
    found = {title: {n: library.line(p) for n, p in of.items()} for title, of in files.items()}
    tables = []
    for title, lines in found.items():
        table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
        table.add_column("name", no_wrap=True)
        table.add_column("what it is")
        for row in lines.items():
            table.add_row(*row)
        tables += [table, ""]
    screen = Screen(options)
    screen.table(found, *tables)
    screen.line(f"robots are in {library.folder('mjcf')}, runs in {library.folder('runs')}")


@command(
    argument("filter", "words that all are in the key or its meaning", metavar="WORD", nargs="*"),
    figures=True,
)
def keys(options: Namespace) -> None:
    """Every key of an experiment, with unit and default."""
    from rich.table import Table

    from ..experiments.experiment import describe

    words = [word.lower() for word in options.filter]
    every = describe()
    rows = [row for row in every if all(word in f"{row[0]} {row[2]}".lower() for word in words)]
    if not rows:
        text = cut(" ".join(options.filter))
        raise ExperimentError(f"no key has {text!r}{nearest(text, [row[0] for row in every])}")
    table = Table("key", "default", "meaning", box=None, padding=(0, 2, 0, 0))
    for row in rows:
        table.add_row(*row)
    names = ("key", "default", "meaning")
    Screen(options).table([dict(zip(names, row, strict=True)) for row in rows], table)


@command()
def schema(_: Namespace) -> None:
    """A JSON Schema of experiment files, with which editors complete and check them."""
    from ..experiments.experiment import Experiment
    from ..results.run import finite

    found = finite(Experiment.model_json_schema())
    found["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    print(json.dumps(found, indent=2, allow_nan=False))


@command(figures=True)
def version(options: Namespace) -> None:
    """Versions of this program and what it uses."""
    from ..results.run import versions

    found = versions()
    Screen(options).table(found, *(f"{name} {number}" for name, number in found.items()))


@command(argument("shell", "bash, zsh or tcsh", choices=("bash", "zsh", "tcsh")))
def completion(options: Namespace) -> None:
    """A script that completes commands and options in a shell; it says where to put it."""
    import shtab

    print(shtab.complete(options.program, options.shell))
