"""Tests that draw are skipped where this machine has no OpenGL that draws without a display.

Tests that record a row of a table as a property, by the table's heads, have the tables printed.
"""

import os
import subprocess
import sys
from functools import cache

import pytest

from resonance_mj.pictures.film import gl

DRAWS = """
import mujoco
arm = mujoco.MjModel.from_xml_string("<mujoco/>")
with mujoco.Renderer(arm, 8, 8) as renderer:
    renderer.render()
"""


@cache
def lacking():
    """Why nothing can be drawn here; None where something can."""
    tried = {}
    for backend in gl.backends():
        environment = os.environ | ({"MUJOCO_GL": backend} if backend else {})
        process = subprocess.run(
            [sys.executable, "-c", DRAWS], env=environment, capture_output=True, text=True
        )
        if process.returncode == 0:
            return None
        tried[backend or "default"] = process.stderr.strip().rpartition("\n")[2]
    return gl.missing(tried)


def pytest_runtest_setup(item):
    if item.get_closest_marker("opengl") and lacking():
        pytest.skip(lacking())


def pytest_terminal_summary(terminalreporter):
    tables = {}
    for outcome in ("passed", "failed"):
        for report in terminalreporter.stats.get(outcome, []):
            for heads, row in report.user_properties:
                if heads.startswith("| "):
                    tables.setdefault(heads, []).append(row)
    for heads, rows in tables.items():
        terminalreporter.write_line("\n".join((heads, "|---" * (heads.count("|") - 1) + "|")))
        terminalreporter.write_line("\n".join(sorted(rows)))
