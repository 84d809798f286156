"""What the commands have in common: exit statuses, where words go, progress bars."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

DONE, NOT_WELL, BAD_INPUT, ENDED_BY_SIGNAL = 0, 1, 2, 128
"""Exit statuses; to the last the number of the signal is added."""


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
