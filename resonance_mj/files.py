"""Files of users, read with care, and files written so that nothing is ever left half-written."""

import errno
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO

from .errors import ExperimentError, OutputError, ResonanceError
from .text import cut

if sys.platform != "win32":
    import fcntl

LARGEST = 4_000_000
"""Bytes that a text file of a user may have."""

STAGING = ".resonance-mj-"
"""What the name of a folder begins with in which files are written before they take their place."""

LONGEST = 255
"""Bytes that a file system takes in a name."""


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
        with regular(path) as file:
            content = file.read(limit + 1)
        if len(content) <= limit:
            return content.decode("utf-8-sig")
        reason = f"is longer than {limit / 1e6:g} MB"
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


def is_folder(path: str | os.PathLike[str]) -> bool:
    """Whether a folder is there; not if its name is one that no folder can have."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


@contextmanager
def regular(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A file that is opened to be read: a regular one, as a device or a pipe may have no end.

    Raises:
        OSError: it does not exist, is not regular or may not be read.
    """
    # Without blocking: a pipe that nobody writes to is refused, not waited for.
    with os.fdopen(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(errno.EINVAL, "it is a device or a pipe, not a file")
        yield file


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
    except (OSError, ValueError) as error:
        raise unwritable(folder, error) from None
    return folder


def could_be_written(folder: str | os.PathLike[str]) -> Path:
    """See that a folder can be written or made, without making it: before long work.

    Raises:
        OutputError: it cannot.
    """
    folder = Path(folder)
    try:
        nearest = nearest_folder(folder)
    except (OSError, ValueError) as error:
        raise unwritable(folder, error) from None
    if not nearest.is_dir():
        raise unwritable(folder, f"{nearest} is not a folder")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise unwritable(folder, f"{nearest} may not be written")
    if any(len(os.fsencode(part)) > LONGEST for part in folder.parts):
        raise unwritable(folder, f"a name in it is longer than {LONGEST} bytes")
    return folder


def could_be_replaced(path: Path) -> Path:
    """See that a path is of a file that can be written anew, or of none yet: before long work.

    Raises:
        OutputError: it is not; a device or a pipe is never replaced.
    """
    could_be_written(path.parent)
    try:
        folder, other = path.is_dir(), path.exists() and not path.is_file()
    except (OSError, ValueError) as error:
        raise unwritable(path, error) from None
    if folder or other:
        what = "a folder; give the name of a file in it" if folder else "no regular file"
        raise OutputError(f"{path}: is {what}")
    return path


def nearest_folder(folder: Path) -> Path:
    """The folder, or the nearest of those that hold it which exists."""
    path = folder.absolute()
    while True:
        try:
            path.stat()
        except (FileNotFoundError, NotADirectoryError):
            if path.is_symlink():
                raise
            path = path.parent
        else:
            return path


def unwritable(path: Path, reason: str | Exception) -> OutputError:
    """The error of what cannot be written, for a reason."""
    why = getattr(reason, "strerror", None) or reason
    return OutputError(f"{path}: cannot be written: {why}; give a folder that can")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a path to write to; it takes the place of `path` if and only if the block succeeds.

    Raises:
        OutputError: the file cannot be written.
    """
    could_be_replaced(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with _staging(path.parent) as staging:
            yield staging / path.name
            (staging / path.name).replace(path)
    except OSError as error:
        raise unwritable(path, error) from None


def write(
    folder: str | os.PathLike[str], files: Mapping[str, bytes], replaces: Sequence[str] = ()
) -> Path:
    """Write files into a folder, which is made if needed: all of them, or none.

    They take their places in this order when all are complete, and not among those of another
    call. What a process that was killed left in the folder is removed.

    Args:
        folder: where they are written.
        files: their contents, by path within the folder; a folder in it whose name is taken is left
            as it is, so that its name must tell its contents.
        replaces: patterns of names that are removed unless they are among the files.

    Raises:
        OutputError: they cannot be written; what was there before is as it was.
    """
    folder = writable(folder)
    try:
        with _staging(folder) as staging:
            for name, content in files.items():
                (staging / name).parent.mkdir(parents=True, exist_ok=True)
                (staging / name).write_bytes(content)
            whole = list(dict.fromkeys(name.partition("/")[0] for name in files))
            for name in whole:
                if (staging / name).is_file() and (folder / name).is_dir():
                    raise IsADirectoryError(None, f"{name} is a folder")
            with _locked(folder):
                for name in whole:
                    if not (staging / name).is_dir() or not (folder / name).is_dir():
                        (staging / name).replace(folder / name)
                old = (path for pattern in replaces for path in folder.glob(pattern))
                for path in (path for path in old if path.name not in whole):
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
    except OSError as error:
        raise unwritable(folder, error) from None
    return folder


@contextmanager
def _staging(folder: Path) -> Iterator[Path]:
    """A new folder in `folder`, removed at the end, or by the next call if killed before."""
    with ExitStack() as stack:
        with _locked(folder) as alone:
            for left in folder.glob(f"{STAGING}*") if alone else ():
                with _locked(left, wait=False) as dead:
                    if dead:
                        shutil.rmtree(left, ignore_errors=True)
            staging = Path(tempfile.mkdtemp(prefix=STAGING, dir=folder))
            stack.callback(shutil.rmtree, staging, ignore_errors=True)
            stack.enter_context(_locked(staging))
        yield staging


@contextmanager
def _locked(folder: Path, wait: bool = True) -> Iterator[bool]:
    """Hold a folder's lock, which ends with its process; yields whether it could be had."""
    if sys.platform == "win32":
        yield False
        return
    with ExitStack() as stack:
        try:
            descriptor = os.open(folder, os.O_RDONLY)
            stack.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            held = True
        except OSError:  # another has it, or the file system has no locks
            held = False
        yield held
