"""`resonance-mj` and `python -m resonance_mj.cli`: a process that ends with its command."""

from __future__ import annotations

import gc
import signal
import sys
import threading
from typing import NoReturn

from ..pictures.film import gl
from .entry import main


def script() -> NoReturn:
    """Run the command line and end the process with its exit status."""
    for name in ("SIGTERM", "SIGHUP"):
        # What is ignored from outside, as by nohup, stays so.
        if signal.getsignal(number := getattr(signal, name, signal.SIGINT)) is signal.SIG_DFL:
            signal.signal(number, _interrupt)
    sys.unraisablehook = _again
    gl.set_aside()
    status = main()
    # The process ends: to look for garbage first would take a third of a second.
    gc.freeze()
    sys.exit(status)


def _interrupt(number: int, _: object) -> NoReturn:
    """End a command as Ctrl+C does, so that it takes with it what it has begun."""
    raise KeyboardInterrupt(number)


def _again(lost: sys.UnraisableHookArgs) -> None:
    """Let an interrupt that fell into a callback, which no exception leaves, come again."""
    if isinstance(lost.exc_value, KeyboardInterrupt):
        number = lost.exc_value.args[0] if lost.exc_value.args else signal.SIGINT
        threading.Timer(0.01, signal.raise_signal, [number]).start()
    else:
        sys.__unraisablehook__(lost)


if __name__ == "__main__":
    script()
