"""What a command is: a function that does it, and the arguments that it takes."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from typing import Any, NamedTuple

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
