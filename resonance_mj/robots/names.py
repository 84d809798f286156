"""Names of joints, bodies and other elements of an MJCF file."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

UNNAMED = "unnamed_"
"""What the names of joints and bodies begin with that have none in the file."""


def name_all(elements: list[Any], kind: str) -> None:
    """Give a name to each element that has none."""
    taken = {element.name for element in elements}
    for number, element in enumerate(elements, 1):
        name = element.name or f"{UNNAMED}{kind}{number}"
        while not element.name and name in taken:
            name += "_"
        taken.add(name)
        element.name = name


def listed(names: Iterable[str]) -> str:
    """Names in a row, for a message."""
    return ", ".join(filter(None, names)) or "none with a name"
