"""Each command that README and docs/ show is run, in the order of its page: `make test-docs`."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from test_docs import PAGES, ROOT, commands

ENDS = {
    "run paper-transpose": 1,
    "run paper-centered --law.beta 3 --certify": 1,
    "run paper-centered --motion.0.duration 300 --motion.1.duration 1 --certify": 1,
    "run --robot menagerie:NAME": 2,  # NAME stands for one of many, which the error lists
    "check arm.toml --law.eta 0.1": 1,
}
"""Exit status of commands of which their page says that they do not end well, or stand for many."""

NEEDS = {"path/to/arm.xml": "arm.xml", "arms/one.toml": "arm.toml", "two.toml": "arm.toml"}
"""Files that stand for a user's own, and what they are here."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with what the pages take for granted: an arm, an experiment of it, saved runs."""
    folder = tmp_path_factory.mktemp("docs")
    shutil.copy(ROOT / "mjcf" / "scara.xml", folder / "arm.xml")
    for page, kind, name in (
        ("custom-law", "python", "my_law.py"),
        ("testing", "toml", "arm.toml"),
        ("tuning", "toml", "tuning.toml"),
    ):
        text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
        (folder / name).write_text(re.search(rf"```{kind}\n(.*?)```", text, re.DOTALL)[1])
    for name, of in NEEDS.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / of, folder / name)
    shutil.copy(folder / "arm.xml", folder / "arms" / "arm.xml")
    for name, out in (("two-link-transfer", "a"), ("paper", "b"), ("six-joint-pose", ""),
                      ("paper", ""), ("paper-centered", ""), ("seven-joint", ""),
                      ("two-link-transfer", "")):  # fmt: skip
        run(folder, "run", name, *(["--out", f"runs/{out}"] if out else []))
    return folder


def run(folder, *line):
    return subprocess.run(
        [sys.executable, "-P", "-m", "resonance_mj.cli", *line],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=900,
        env=os.environ | {"COLUMNS": "100"},
    )


@pytest.mark.docs
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_commands_of_a_page_end_as_it_says(page, folder):
    wrong, said = [], ""
    shutil.rmtree(folder / "paper", ignore_errors=True)  # figures of another page, not the run
    for line in {" ".join(line): line for line in commands(page)}.values():
        if line[0] == "view":  # windows are opened by tests/test_view.py
            continue
        ended = run(folder, *line)
        shown = " ".join(line)
        said += ended.stdout
        if ended.returncode != ENDS.get(shown, 0) or "Traceback" in ended.stderr:
            wrong.append(f"{shown}: {ended.returncode} {ended.stderr.strip()[-200:]}")
    assert wrong == []
    shown = re.findall(r"prints\n\n```\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    printed = {" ".join(line.split()) for line in said.splitlines()}
    lines = {" ".join(line.split()) for text in shown for line in text.splitlines()}
    assert {line for line in lines if not set(line) <= set("─ ")} <= printed
