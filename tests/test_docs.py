"""What README and docs/ show: their commands are valid, their tables and programs come out so."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.cli import keys_as_options
from resonance_mj.cli.entry import parser
from resonance_mj.experiments.loading import for_robot

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")])


def commands(page):
    """Lines of code that call the program, without what stands after #."""
    fences = re.findall(r"```sh\n(.*?)```", page.read_text(), re.DOTALL)
    inline = re.findall(r"`(resonance-mj [^`]+)`", page.read_text())
    lines = [line for text in fences for line in text.splitlines() if "resonance-mj" in line]
    inline = [line for line in inline if line.count(" ") > 1]
    found = [shlex.split(line, comments=True) for line in (*lines, *inline)]
    found = [line[line.index("resonance-mj") + 1 :] for line in found if "resonance-mj" in line]
    return [line for line in found if line and "..." not in line and "RUN" not in line]


SHOWN = [
    pytest.param(line, id=f"{page.stem}: {' '.join(line)}")
    for page in PAGES
    for line in {" ".join(line): line for line in commands(page)}.values()
]


def test_the_pages_show_commands():
    assert len(SHOWN) > 60


@pytest.mark.parametrize("line", SHOWN)
def test_a_command_that_a_page_shows_is_one(line):
    changes, rest = keys_as_options.split(line)
    options = parser().parse_args(rest)
    assert not changes or options.command.takes_keys
    named = getattr(options, "experiment", None)
    files = {"law.kind"} & set(changes)
    if named in library.experiments():
        rmj.load(named).replace(changes)
    elif changes and getattr(options, "robot", None):
        for_robot(options.robot).replace({k: v for k, v in changes.items() if k not in files})


def table_rows():
    rows = re.findall(
        r"^\| .*?`resonance-mj (\w+) ([\w-]+)`\)? \| (.*) \|$",
        (ROOT / "README.md").read_text(),
        re.MULTILINE,
    )
    return [pytest.param(what, name, cells, id=name) for what, name, cells in rows]


@pytest.mark.parametrize(("what", "name", "cells"), table_rows())
def test_the_table_of_readme_is_what_comes_out(what, name, cells):
    reductions, stiffness = np.split(np.array(cells.split(" | ")), 2)
    if what == "optimum":
        found = [(best.torque_reduction, best.stiffness) for best in rmj.optimum(rmj.load(name))]
    else:
        motions = rmj.simulate(rmj.load(name)).motions
        found = [(motion.torque_reduction[-1], motion.stiffness[-1]) for motion in motions]
    assert [f"{100 * reduction:.1f} %" for reduction, _ in found] == reductions.tolist()
    assert [", ".join(f"{k:.2f}" for k in best) for _, best in found] == stiffness.tolist()


def test_the_program_of_readme_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (program,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    names = {}
    exec(program, names)
    assert names["run"].status is rmj.Status.OK
    assert len(names["best"]) == len(names["runs"]) == 2
