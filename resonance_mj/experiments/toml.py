"""Tables as TOML: in linear time, which tomlkit is not, and a list on a line, unlike tomli-w."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

DEEPEST = 100
"""Dots in a key from which on it is too deep: a parser takes as long as their square."""


def parsed(text: str) -> dict[str, Any]:
    """The values of a file.

    Raises:
        ValueError: it is not TOML.
        RecursionError: something in it is nested too deeply.
    """
    for line in text.splitlines():
        key = line.partition("=")[0]
        if key.count(".") > DEEPEST and re.fullmatch(r"[\w\s.-]*", key):
            raise RecursionError
    return tomllib.loads(text)


def document(tables: Mapping[str, Any]) -> str:
    """A whole file: what is None is left out, as TOML has no word for it."""
    return "\n".join(_lines(tables, "")).lstrip("\n") + "\n"


def value(item: Any) -> str:
    """A string, number or list as it stands behind a key."""
    if isinstance(item, bool):
        return str(item).lower()
    if isinstance(item, str):
        return f'"{re.sub(_TO_ESCAPE, _escaped, item)}"'
    if isinstance(item, list | tuple):
        return f"[{', '.join(map(value, item))}]"
    return repr(item)


def _lines(table: Mapping[str, Any], name: str) -> Iterator[str]:
    """The lines of a table, its own values before the tables inside it."""
    inside: list[tuple[str, Mapping[str, Any]]] = []
    for key, item in table.items():
        word = key if re.fullmatch(r"[\w-]+", key, re.ASCII) else value(key)
        whole = f"{name}.{word}".removeprefix(".")
        if isinstance(item, Mapping):
            inside.append((f"[{whole}]", item))
        elif isinstance(item, list | tuple) and item and isinstance(item[0], Mapping):
            inside += [(f"[[{whole}]]", one) for one in item]
        elif item is not None:
            yield f"{word} = {value(item)}"
    for header, one in inside:
        yield from ("", header, *_lines(one, header.strip("[]")))


_TO_ESCAPE = r'[\x00-\x1f\x7f"\\]'


def _escaped(found: re.Match[str]) -> str:
    letter = found[0]
    return f"\\{letter}" if letter in '"\\' else f"\\u{ord(letter):04x}"
