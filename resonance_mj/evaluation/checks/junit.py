"""Judgements as JUnit XML, which continuous integration services read."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from ...files import replacing, writable
from ...results.run import Run
from .check import Judgement
from .convergence import explain, title


def write(path: Path, runs: Sequence[Run], judgements: Sequence[list[Judgement]]) -> None:
    """Write a test suite for each run, with a test case for each judgement.

    Raises:
        OutputError: the file, or its folder, cannot be written.
    """
    suites = ElementTree.Element("testsuites", name="resonance-mj check")
    for run, found in zip(runs, judgements, strict=True):
        missed = [one for one in found if not one.passed]
        suite = ElementTree.SubElement(
            suites,
            "testsuite",
            name=run.experiment.name,
            tests=str(len(found)),
            failures=str(len(missed)),
            errors="0",
            skipped="0",
            time=f"{run.simulation_wall_s:.3f}",
        )
        properties = ElementTree.SubElement(suite, "properties")
        for name, version in run.versions.items():
            ElementTree.SubElement(properties, "property", name=name, value=version)
        for one in found:
            case = ElementTree.SubElement(
                suite,
                "testcase",
                classname=run.experiment.name,
                name=_valid(f"{one.key}: {title(one)}"),
                time="0",
            )
            if not one.passed:
                text = explain(one) + (f"\n{run.message}" if run.message else "")
                failure = ElementTree.SubElement(
                    case, "failure", type="missed", message=_valid(text.splitlines()[0])
                )
                failure.text = _valid(text)
    for count in ("tests", "failures", "errors"):
        suites.set(count, str(sum(int(suite.get(count, "0")) for suite in suites)))
    ElementTree.indent(suites)
    writable(path.parent)
    with replacing(path) as beside:
        ElementTree.ElementTree(suites).write(beside, encoding="utf-8", xml_declaration=True)


def _valid(text: str) -> str:
    """Text without the control characters that XML cannot hold."""
    return re.sub(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "?", text)
