"""What differs between runs: their experiments, key by key."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from ..results.run import Run


class Difference(NamedTuple):
    """A key of the experiments that has not the same value in all of them."""

    key: str
    values: tuple[str, ...]
    """Of each run; empty where the key is not given."""


def differences(runs: Sequence[Run]) -> list[Difference]:
    """The keys in which the experiments differ, besides their names and what is expected."""
    tables = [dict(_flat(tomllib.loads(run.experiment.to_toml()))) for run in runs]
    keys = dict.fromkeys(key for table in tables for key in table)
    found = [Difference(key, tuple(table.get(key, "") for table in tables)) for key in keys]
    return [
        one
        for one in found
        if len(set(one.values)) > 1 and one.key != "name" and not one.key.startswith("expect.")
    ]


def _flat(table: Any, before: str = "") -> Iterator[tuple[str, str]]:
    """Dotted keys, as the command line takes them, and their values as text."""
    items = enumerate(table) if isinstance(table, list) else table.items()
    for key, value in items:
        of_tables = isinstance(value, list) and value and isinstance(value[0], dict)
        if isinstance(value, dict) or of_tables:
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", str(value).replace("'", "")
