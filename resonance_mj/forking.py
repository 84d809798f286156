"""Work that a copy of this process does meanwhile, on another core."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def meanwhile(work: Callable[[], None]) -> Iterator[Callable[[], bool]]:
    """Let a copy of this process do some work while the `with` block runs.

    Args:
        work: writes files; it may use neither locks of other threads nor a device that does not
            survive a fork. What it changes in memory is not seen here.

    Yields:
        Waits for the work, and says whether it was done: False where it failed, where the system
        has no safe fork (all but Linux), or only one core. Do it here then, which also says why.
    """
    if sys.platform != "linux" or cores() < 2:
        yield lambda: False
        return
    with warnings.catch_warnings():
        # Python >= 3.12 warns of locks that other threads may hold; see `work`.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        status = 1
        try:
            work()
            status = 0
        finally:
            os._exit(status)
    try:
        yield lambda: os.waitpid(child, 0)[1] == 0
    except BaseException:
        os.waitpid(child, 0)
        raise
