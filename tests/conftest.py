"""Tests that draw are skipped where this machine has no OpenGL that draws without a display.

Tests that record a row of a table as a property, by the table's heads, have the tables printed.
"""

import os
import shutil
import subprocess
import sys
from functools import cache

import pytest

from resonance_mj.pictures.film import gl

# Each core has a worker: their linear algebra does not share them a second time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

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


BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="module")
def browser():
    """A headless Chromium that is installed on this machine."""
    sync_api = pytest.importorskip("playwright.sync_api")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip(f"no browser to open reports in: none of {', '.join(BROWSERS)} is on the PATH")
    with sync_api.sync_playwright() as playwright:
        software = ["--enable-unsafe-swiftshader", "--use-angle=swiftshader"]
        chromium = playwright.chromium.launch(
            executable_path=found, args=["--no-sandbox", *software]
        )
        yield chromium
        chromium.close()
