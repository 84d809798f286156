"""Frames a second of a report's scene in Chromium without a GPU, and of a page of viser.

    python benchmarks/browser.py runs/seven-joint [--viser PYTHON]

The report's scene plays; viser's page, if the path of a Python that has viser is given, shows eight
boxes that move. Both in a window of 1280 x 720, in turn, three times; frames are those that the
browser gives the page in five seconds.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, sync_playwright

import resonance_mj as rmj

SOFTWARE = ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"]
PORT = 8099
VISER = f"""
import time, numpy, viser
server = viser.ViserServer(host="127.0.0.1", port={PORT}, verbose=False)
server.scene.add_grid("/grid", width=4, height=4)
boxes = [server.scene.add_box(f"/box{{i}}", dimensions=(.1, .1, .3)) for i in range(8)]
while True:
    for i, box in enumerate(boxes):
        box.position = (.12 * i, .1 * numpy.sin(3 * time.time() + i), .2)
    time.sleep(1 / 30)
"""
FRAMES = """() => new Promise((done) => {
  let frames = 0; const began = performance.now();
  const next = (now) => now - began > 5000
    ? done(1000 * frames / (now - began)) : (frames++, requestAnimationFrame(next));
  requestAnimationFrame(next);
})"""


def frames(browser: Browser, url: str, before: str) -> float:
    """Frames a second of a page, after `before` was done in it."""
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.goto(url)
    page.wait_for_timeout(4000)
    page.evaluate(before)
    found: float = page.evaluate(FRAMES)
    page.close()
    return found


def main() -> None:
    """Measure and print a line for each turn."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", help="a run's folder")
    parser.add_argument("--viser", help="a Python that has viser")
    parser.add_argument("--browser", default="chromium", help="an executable")
    options = parser.parse_args()
    server: Any = None
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page = rmj.report(options.run, Path(folder) / "report.html", video=False)
        there = {page.as_uri(): "document.querySelector('#scene').scrollIntoView()"}
        if options.viser:
            server = subprocess.Popen([options.viser, "-c", VISER], stdout=subprocess.DEVNULL)
            there[f"http://127.0.0.1:{PORT}/"] = "0"
            time.sleep(6)
        path = subprocess.check_output(["which", options.browser], text=True).strip()
        browser = playwright.chromium.launch(executable_path=path, args=SOFTWARE)
        try:
            for _ in range(3):
                found = [frames(browser, *each) for each in there.items()]
                print("frames/s:", ", ".join(f"{one:.1f}" for one in found), flush=True)
        finally:
            browser.close()
            if server:
                server.kill()


if __name__ == "__main__":
    main()
