"""Files of users, read with care, and files written so that nothing is ever left half-written."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import ExperimentError, OutputError, ResonanceError
from .text import cut

LARGEST = 4_000_000
"""Bytes that a text file of a user may have."""


def read_text(
    path: str | os.PathLike[str],
    where: str = "",
    needed: str = "",
    error: type[ResonanceError] = ExperimentError,
    limit: int = LARGEST,
) -> str:
    """The text of a file that a user named: a regular file in UTF-8, and not a huge one.

    Args:
        path: of the file.
        where: how the error names it; its path if not given.
        needed: what the error says would be valid.
        error: the error to raise.
        limit: bytes that it may have.

    Raises:
        ResonanceError: the file is missing, not regular, too long, not UTF-8 or may not be read.
    """
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                reason = "is a device or a pipe, not a file"
            elif len(content := file.read(limit + 1)) > limit:
                reason = f"is longer than {limit / 1e6:g} MB"
            else:
                return content.decode("utf-8-sig")
    except FileNotFoundError:
        reason = "does not exist"
    except IsADirectoryError:
        reason = "is a folder"
    except UnicodeDecodeError as found:
        reason = f"byte {found.start + 1} is not UTF-8: save it in UTF-8"
    except (OSError, ValueError) as found:
        reason = f"cannot be read: {getattr(found, 'strerror', None) or found}"
    raise error("; ".join(filter(None, (f"{where or cut(str(path), 200)}: {reason}", needed))))


def is_file(path: str | os.PathLike[str]) -> bool:
    """Whether a regular file is there; not if its name is one that no file can have."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def _without_waiting(path: str, flags: int) -> int:
    """Open a file; a pipe that nobody writes to is opened too, and not waited for."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


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
