"""What a command is, and what all have in common: arguments, exit statuses, where they print."""

from __future__ import annotations

import json
import signal
import sys
import textwrap
import threading
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

from ..text import Caution

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


EXPLAIN = flag("--explain", "say the whole of each note and warning, not its first line")
QUIET = flag("--quiet", "print nothing but what goes wrong")
JSON = flag("--json", "print the figures as JSON and nothing else")


def command(
    *arguments: Argument, keys: bool = False, figures: bool = False, more: str = ""
) -> Callable[[Callable[[Namespace], int | None]], Command]:
    """Make a command of a function of its options; see `Command`.

    Args:
        arguments: what it takes besides --quiet.
        keys: whether it takes the keys of an experiment.
        figures: whether it prints a table, and takes --json.
        more: what its help says below the options.
    """
    every = (*arguments, *([EXPLAIN] if keys else []), *([JSON] if figures else []), QUIET)
    return lambda execute: Command(execute, every, keys, more)


class Screen:
    """Where a command's tables, notes and progress go: nowhere with --quiet or --json.

    Args:
        options: of the command.

    Attributes:
        console: what they are printed on.
    """

    def __init__(self, options: Namespace) -> None:
        from rich.console import Console

        self._json = getattr(options, "json", False)
        self._explains, self._hinted = getattr(options, "explain", True), False
        quiet = self._json or getattr(options, "quiet", False)
        self.console = Console(markup=False, highlight=False, quiet=quiet)

    def table(self, data: Any, *tables: Any) -> None:
        """Print tables, or with --json the same figures as data."""
        if self._json:
            from ..results.run import finite

            print(json.dumps(finite(_plain(data)), indent=2, ensure_ascii=False))
        for table in tables:
            self.console.print(table)

    def line(self, text: object) -> None:
        """Print a line, which the terminal wraps."""
        self.console.print(str(text), soft_wrap=True)

    def note(self, text: str) -> None:
        """Print a note or a warning, in short if there is --explain to see the rest."""
        warns = isinstance(text, Caution)
        said = text if self._explains else getattr(text, "head", text)
        if said != text:
            said += " …" if self._hinted else " … (more: --explain)"
            self._hinted = True
        line = f"  {'warning' if warns else 'note'}: {said}"
        if self.console.is_terminal:
            line = textwrap.fill(line, self.console.width, subsequent_indent="    ")
        self.console.print(line, soft_wrap=True, style="yellow" if warns else None)


def _plain(value: Any) -> Any:
    """What JSON can hold of arrays, tuples and paths."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return value.tolist()
    return value if isinstance(value, str | int | float | None) else str(value)


@contextmanager
def stopping() -> Iterator[list[int]]:
    """Signals that ask the process to end, in a list in which they are put as they come.

    The first is left to what is running, to end where it can; the second ends it at once.
    """
    came: list[int] = []

    def asked(number: int, _: object) -> None:
        came.append(number)
        if len(came) > 1:
            raise KeyboardInterrupt(number)
        complain(f"{signal.Signals(number).name}: ends after this cycle; once more ends at once")

    names = [signal.SIGINT, signal.SIGTERM]
    if threading.current_thread() is not threading.main_thread():
        names = []
    before = {
        number: signal.signal(number, asked)
        for number in names
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def complain(line: str) -> None:
    """Say what did not go well."""
    print(f"resonance-mj: {line}", file=sys.stderr, flush=True)
