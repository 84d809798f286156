"""Rewrite the numbers that a file expects and its run misses, and nothing else of the file."""

import difflib
import math
import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit

from ...errors import ExperimentError, OutputError
from ...files import replacing
from ...results.run import Run
from .check import Band, Judgement
from .convergence import is_number, number

RECORDED = ("resonance-mj", "mujoco")
"""Packages whose versions are written beside the numbers that came from them."""


class Update:
    """The new text of an experiment file, to be looked at and then written.

    What is "optimal" stays so, and bounds are requirements: only numbers with a tolerance change,
    and only where the run misses them. Comments and layout stay as they are.

    Raises:
        ExperimentError: a number that is expected does not exist, or is not one for all motions.
    """

    def __init__(self, path: Path, run: Run, judgements: list[Judgement]) -> None:
        self.path = path.resolve()
        self.before = path.read_bytes().decode("utf-8")
        document = tomlkit.parse(self.before)
        numbers: dict[str, list[Judgement]] = {}
        for one in filter(is_number, judgements):
            numbers.setdefault(one.key, []).append(one)
        missed = {k: found for k, found in numbers.items() if not all(o.passed for o in found)}
        for key, found in missed.items():
            parent: Any = document
            for part in key.split("."):
                parent = parent[int(part) if part.isdigit() else part]
            _rewrite(parent, found, f"{path}: {key}")
        self.after = _with_versions(document, run.versions) if missed else self.before

    def differences(self) -> list[str]:
        """The lines that change, as a unified diff; none if nothing does."""
        texts, name = (self.before.splitlines(), self.after.splitlines()), str(self.path)
        return list(difflib.unified_diff(*texts, name, f"{name} (updated)", lineterm="", n=1))

    def write(self) -> None:
        """Replace the file, if anything changes; its owner and mode stay.

        Raises:
            OutputError: it cannot be written.
        """
        if self.after == self.before:
            return
        if not os.access(self.path, os.W_OK):
            raise OutputError(f"{self.path}: may not be written: its mode forbids it")
        with replacing(self.path) as path:
            path.write_bytes(self.after.encode("utf-8"))
            was, now = self.path.stat(), path.stat()
            if (was.st_uid, was.st_gid) != (now.st_uid, now.st_gid):
                os.chown(path, was.st_uid, was.st_gid)
            shutil.copymode(self.path, path)


def _with_versions(document: tomlkit.TOMLDocument, versions: Mapping[str, str]) -> str:
    """The text, with the versions that its numbers come from in [expect]."""
    recorded = tomlkit.inline_table()
    recorded.update({name: versions[name] for name in RECORDED})
    expect: Any = document["expect"]
    text = tomlkit.dumps(document)
    header = re.search(r"^[ \t]*\[expect\].*?(\r?\n)", text, re.MULTILINE)
    if header is None or "versions" in expect:
        expect["versions"] = recorded
        return tomlkit.dumps(document)
    # Below the header: tomlkit would put it behind the comments of the table that follows.
    end = header.end()
    return f"{text[:end]}versions = {recorded.as_string()}{header[1]}{text[end:]}"


def _rewrite(table: Any, found: list[Judgement], where: str) -> None:
    """Write what was found into a table { value, abs, rel }."""
    of_joints: dict[str, list[float]] = {}
    for one in found:
        if not isinstance(one.found, int | float) or not math.isfinite(one.found):
            raise ExperimentError(f"{where}: motion {one.motion} has no such number: {one.why}")
        of_joints.setdefault(one.joint, []).append(one.found)
    new = [_one_for_all(table, values, where) for values in of_joints.values()]
    old = table["value"]
    if isinstance(old, list):
        for index, value in enumerate(new):
            if old[index] != value:
                old[index] = value
    elif any(value != old for value in new):
        table["value"] = new[0] if len(set(new)) == 1 else new


def _one_for_all(table: Any, values: list[float], where: str) -> float | int:
    """The number found, with the digits that its tolerance is worth."""
    middle = (min(values) + max(values)) / 2
    width = max(table.get("abs", 0.0), table.get("rel", 0.0) * abs(middle))
    if max(values) - middle > width:
        each = ", ".join(f"{value:.6g}" for value in values)
        raise ExperimentError(
            f"{where}: its motions found {each}, farther apart than its tolerance: expect the "
            "number of each in a table [[expect.motion]]"
        )
    if all(isinstance(value, int) for value in values):
        return round(middle)
    value = values[0] if len(values) == 1 else middle
    return float(number(float(value), Band(value, False, value - width, value + width)))
