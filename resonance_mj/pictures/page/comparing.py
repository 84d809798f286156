"""Runs beside each other: which saves most, and in what their experiments differ, key by key."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from ...results.run import Run
from .content import Content
from .wording import listed


class Difference(NamedTuple):
    """A key of the experiments that has not the same value in all of them."""

    key: str
    values: tuple[str, ...]
    """Of each run; empty where the key is not given."""


def best(contents: Sequence[Content]) -> str:
    """Which run saves the most motor torque in each motion, in a sentence."""
    found: dict[str, list[str]] = {}
    for number in range(1, max(len(each.motions) for each in contents) + 1):
        shares = {
            each.label: each.motions[number - 1].reduction.found
            for each in contents
            if len(each.motions) >= number and each.motions[number - 1].cycles
        }
        if len(shares) == len(contents):
            leader = max(shares, key=lambda label: shares[label].value or 0.0)
            found.setdefault(leader, []).append(f"{shares[leader].text} in motion {number}")
    if not found:
        return f"{len(contents)} runs, which have no whole cycle of a motion in common."
    said = "; ".join(f"{leader}, {listed(where)}" for leader, where in found.items())
    return f"The greatest reduction of motor torque² against no springs: {said}."


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
