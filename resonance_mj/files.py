"""Writing files so that nothing half-written is ever left under its final name."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import OutputError


def writable(folder: str | os.PathLike[str]) -> Path:
    """Make a folder if needed, and see that files can be written in it.

    Raises:
        OutputError: it cannot be made or written.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _unwritable(folder, error.strerror or str(error)) from None
    return folder


def could_be_written(folder: str | os.PathLike[str]) -> Path:
    """See that a folder can be written or made, without making it: before long work.

    Raises:
        OutputError: it cannot.
    """
    folder = Path(folder)
    nearest = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not nearest.is_dir():
        raise _unwritable(folder, f"{nearest} is not a folder")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise _unwritable(folder, f"{nearest} may not be written")
    return folder


def _unwritable(folder: Path, reason: str) -> OutputError:
    return OutputError(f"{folder}: cannot be written: {reason}; give a folder that can")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a path to write beside `path`; it takes that name if and only if the block succeeds.

    Raises:
        OutputError: the file cannot be written.
    """
    beside = path.with_name(f".{os.getpid()}.{path.name}")
    try:
        yield beside
        beside.replace(path)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        beside.unlink(missing_ok=True)
