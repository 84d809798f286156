"""Runs beside each other: which saves most, and in what their experiments differ, key by key."""

from __future__ import annotations

from collections.abc import Sequence

from ...results.run import Run
from ...text import flat, joined, percent, shown
from .content import Content


def best(contents: Sequence[Content]) -> str:
    """Which run saves the most motor torque in each motion, in a sentence."""
    found: dict[str, list[str]] = {}
    for motions in zip(*(each.motions for each in contents), strict=False):
        shares = [motion.last["torque_reduction"] for motion in motions]
        if None not in shares:
            leader = max(range(len(shares)), key=shares.__getitem__)
            place = f"{percent(shares[leader])} in motion {motions[0].number}"
            found.setdefault(contents[leader].label, []).append(place)
    if not found:
        return f"{len(contents)} runs, which have no reduction of torque in common to compare."
    said = "; ".join(f"{leader}, {joined(where)}" for leader, where in found.items())
    return f"The greatest reduction of motor torque² against no springs: {said}."


def differences(runs: Sequence[Run]) -> dict[str, list[str]]:
    """The keys in which the experiments differ, besides their names and what is expected.

    Returns:
        By key the value in each run; empty where the key is not given.
    """
    tables = [flat(run.experiment.model_dump()) for run in runs]
    keys = dict.fromkeys(key for table in tables for key in table)
    rows = {key: [_text(table.get(key)) for table in tables] for key in keys}
    return {key: values for key, values in rows.items() if len(set(values)) > 1}


def _text(value: object) -> str:
    return "" if value is None else shown(value, 200).replace("'", "")
