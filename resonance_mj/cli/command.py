"""What a command is, and what all have in common: arguments, exit statuses, progress bars."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from rich.console import Console

DONE, NOT_WELL, BAD_INPUT, ENDED_BY_SIGNAL = 0, 1, 2, 128
"""Exit statuses; to the last the number of the signal is added."""

Argument = tuple[tuple[str, ...], dict[str, Any]]
"""What `ArgumentParser.add_argument` takes."""


class Command(NamedTuple):
    """A command of `resonance-mj`."""

    execute: Callable[[Namespace], int | None]
    """Does it; returns the exit status, or None where it is done. Its docstring is the help."""
    arguments: tuple[Argument, ...]
    """What it takes."""
    takes_keys: bool
    """Whether the keys of an experiment are among its options, as `options.changes`."""
    more: str
    """What its help says below the options, before the keys."""


def argument(names: str, meaning: str, **settings: Any) -> Argument:
    """An argument, of one name or several, with settings as for `ArgumentParser.add_argument`."""
    return tuple(names.split()), {"help": meaning, **settings}


def flag(name: str, meaning: str) -> Argument:
    """An option without a value."""
    return argument(name, meaning, action="store_true")


def command(
    *arguments: Argument, keys: bool = False, more: str = ""
) -> Callable[[Callable[[Namespace], int | None]], Command]:
    """Make a command of a function of its options; see `Command`."""
    return lambda execute: Command(execute, arguments, keys, more)


def console() -> Console:
    """Where tables and progress go."""
    from rich.console import Console

    return Console(markup=False, highlight=False)


def complain(line: str) -> None:
    """Say what did not go well."""
    print(f"resonance-mj: {line}", file=sys.stderr, flush=True)


@contextmanager
def bar(
    first: str, unit: str, console: Console, total: int | None = None, then: str | None = None
) -> Iterator[Callable[[int, int], None]]:
    """A progress bar, as a function of what is done and what there is in all, counted in `unit`.

    It says `first`, and from the first progress on `then`, if that is given.
    """
    from rich import progress

    with progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TextColumn(unit),
        progress.TimeElapsedColumn(),
        progress.TextColumn("left"),
        progress.TimeRemainingColumn(),
        console=console,
    ) as bars:
        task = bars.add_task(first, total=total)
        yield lambda done, of: bars.update(
            task, completed=done, total=of, description=then or first
        )
