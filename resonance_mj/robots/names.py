"""Names of joints, bodies and other elements of an MJCF file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

UNNAMED = "unnamed_"
"""What the names of joints and bodies begin with that have none in the file."""


def name_all(elements: list[Any], kind: str) -> None:
    """Give a name to each element that has none."""
    taken = {element.name: element for element in elements}
    for number, element in enumerate(elements, 1):
        if not element.name:
            element.name = free(f"{UNNAMED}{kind}{number}", taken.get)
            taken[element.name] = element


def free(name: str, find: Callable[[str], Any]) -> str:
    """A name with as many underscores behind it as it takes for `find` to find nothing."""
    while find(name) is not None:
        name += "_"
    return name
