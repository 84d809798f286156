"""How far long work is: a bar in a terminal or a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console

Progress = Callable[..., None]
"""Called with the number of parts that are done, that of all, and perhaps that of bad ones."""

Asked = Progress | Literal[False] | None
"""What a caller wants: to be called, nothing, or a bar where there is someone to see it."""

_ONE = Lock()
"""A terminal shows one bar: what other threads do meanwhile has none."""


@contextmanager
def progressing(asked: Asked, what: str, unit: str) -> Iterator[Progress]:
    """What to call as work goes on.

    Args:
        asked: by the caller of the work; if nothing, there is a bar on the standard error where
            that is a terminal, or in the notebook. It goes when the work is done.
        what: is being done.
        unit: that is counted.
    """
    notebook = _notebook()
    if asked is not None or not (notebook or sys.stderr.isatty()):
        yield asked or _nothing
    elif not _ONE.acquire(blocking=False):
        yield _nothing
    else:
        try:
            if notebook:
                with _in_a_notebook(what, unit) as show:
                    yield show
            else:
                from rich.console import Console

                with bar(what, unit, Console(stderr=True), transient=True) as show:
                    yield show
        finally:
            _ONE.release()


@contextmanager
def bar(
    first: str,
    unit: str,
    console: Console,
    total: int | None = None,
    then: str | None = None,
    *,
    transient: bool = False,
) -> Iterator[Progress]:
    """A progress bar on a console, as a function of what is done and what there is in all.

    Args:
        first: what it says, until the first progress if there is a `then`.
        unit: in which progress is counted.
        console: where it is shown.
        total: what there is in all, where that is known before.
        then: what it says from the first progress on.
        transient: whether it goes when the work is done.
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
        transient=transient,
    ) as bars:
        task = bars.add_task(first, total=total)

        def show(done: int, of: int, bad: int = 0) -> None:
            said = (then or first) + (f", {bad} not ok" if bad else "")
            bars.update(task, completed=done, total=of, description=said)

        yield show


def _notebook() -> bool:
    """Whether this is the kernel of a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", _nothing)()
    return hasattr(shell, "kernel")


@contextmanager
def _in_a_notebook(what: str, unit: str) -> Iterator[Progress]:
    """A bar in the output of a notebook's cell, drawn again a few times in a second."""
    import html
    import time

    from IPython.display import HTML, display

    shown = display(HTML(""), display_id=True)
    last = 0.0

    def show(done: int, of: int, bad: int = 0) -> None:
        nonlocal last
        if done < of and time.monotonic() < last + 0.2:
            return
        last = time.monotonic()
        said = html.escape(f"{what}: {done} of {of} {unit}" + (f", {bad} not ok" if bad else ""))
        shown.update(HTML(f"<progress value='{done}' max='{of}'></progress> {said}"))

    try:
        yield show
    finally:
        shown.update(HTML(""))


def _nothing(*_: int) -> None:
    """Show nothing."""
