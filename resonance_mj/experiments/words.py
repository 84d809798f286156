"""Values and names as messages show them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from enum import StrEnum
from typing import Any


def shown(value: Any) -> str:
    """A value as a message shows it: lists as in a file, cut where they are long."""
    if isinstance(value, StrEnum):
        value = str(value)
    text = repr(list(value) if isinstance(value, tuple) else value)
    return text if len(text) <= 80 else text[:77] + "..."


def listed(names: Iterable[str]) -> str:
    """Names in a row."""
    return ", ".join(names)


def nearest(name: str, names: Iterable[str]) -> str:
    """A hint at the name that was likely meant, to be put behind a message; empty for none."""
    close = difflib.get_close_matches(name, list(names), n=1)
    return f" (did you mean {close[0]!r}?)" if close else ""
