"""What MuJoCo warns of is heard here, and neither written to MUJOCO_LOG.TXT nor to the screen."""

import re
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import mujoco

from ..text import Caution

_lock = threading.Lock()
_users = 0
_before: Any = None
_listeners = threading.local()


@contextmanager
def heard() -> Iterator[list[str]]:
    """What MuJoCo warns of meanwhile in this thread, each once, in a list that grows.

    Meanwhile MuJoCo writes no log file and nothing to the screen. Of threads in which nobody
    listens, such as those of a batch, nothing is kept: each mjData counts its own, see `counted`.
    """
    said: list[str] = []
    own = _own()
    own.append(said)
    _install(1)
    try:
        yield said
    finally:
        _install(-1)
        own.pop()


def hear(text: str) -> None:
    """Add a warning to what this thread hears. It never raises: MuJoCo would end the process."""
    for said in _own()[-1:]:
        if _note(text) not in said:
            said.append(_note(text))


def counted(warnings: Iterable[tuple[int, int]]) -> list[str]:
    """What an mjData has warned of since its reset.

    Args:
        warnings: of each kind of warning, in MuJoCo's order, what it was last about, and how often.
    """
    return [
        _note(mujoco.mju_warningText(kind, int(info)))
        for kind, (info, number) in enumerate(warnings)
        if number
    ]


def _own() -> list[list[str]]:
    """The lists of those who listen in this thread, the last on top."""
    if not hasattr(_listeners, "lists"):
        _listeners.lists = []
    own: list[list[str]] = _listeners.lists
    return own


def _install(users: int) -> None:
    """Put `hear` in the place of another handler for as long as somebody listens."""
    global _users, _before
    with _lock:
        if _users == 0:
            _before = mujoco.get_mju_user_warning()
            mujoco.set_mju_user_warning(hear)
        _users += users
        if _users == 0 and mujoco.get_mju_user_warning() is hear:
            mujoco.set_mju_user_warning(_before)


def _note(text: str) -> str:
    """A warning as a note: in one line, without the time at which it was given."""
    return Caution(f"MuJoCo warns: {re.sub(r' Time = .+$', '', ' '.join(text.split()))}")
