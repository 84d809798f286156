"""A folder for oneself: two runs, or two sweeps, do not write into one at the same time."""

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from .errors import OutputError
from .files import nearest_folder, unwritable, writable

if sys.platform != "win32":
    import fcntl

CLAIM = ".resonance_mj.lock"
"""Name of the file that is locked in the folder."""


@contextmanager
def claimed(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Have a folder for oneself while the `with` block runs; a process that is killed loses it.

    It is made if needed, and removed again if nothing was written into it.

    Raises:
        OutputError: another process, or another thread of this one, has it; or it cannot be made.
    """
    try:
        before = nearest_folder(Path(folder))
    except (OSError, ValueError) as error:
        raise unwritable(Path(folder), error) from None
    folder = writable(folder)
    with ExitStack() as stack:
        stack.callback(_remove_if_empty, folder.absolute(), before)
        while sys.platform != "win32" and not _locked(folder / CLAIM, stack):
            pass
        yield folder


def _locked(path: Path, stack: ExitStack) -> bool:
    """Lock a file until the stack is left; False if it was removed meanwhile by whoever had it."""
    with ExitStack() as opened:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
            opened.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            same = path.exists() and os.path.samestat(os.fstat(descriptor), path.stat())
        except BlockingIOError:
            raise OutputError(
                f"{path.parent}: another run is being written there; wait for its end, or give "
                "another folder"
            ) from None
        except OSError as error:
            if not path.exists():
                raise unwritable(path.parent, error) from None
            return True  # the file system has no locks
        if same:
            stack.enter_context(opened.pop_all())
            stack.callback(path.unlink, missing_ok=True)
        return same


def _remove_if_empty(folder: Path, before: Path) -> None:
    """Remove a folder and those that hold it, up to one that was there before."""
    with suppress(OSError):
        for made in (folder, *folder.parents):
            if made == before:
                break
            made.rmdir()
