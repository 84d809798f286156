"""The notebook runs from its first cell to its last, and the API pages hold what is public."""

import subprocess
import sys
from pathlib import Path

import pytest

import resonance_mj as rmj

ROOT = Path(__file__).parents[1]


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::RuntimeWarning")
@pytest.mark.slow
def test_the_notebook_runs_and_shows_what_it_speaks_of(tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(ROOT / "examples" / "springs_for_an_arm.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "outputs are not committed"
    client = nbclient.NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": tmp_path}}
    )
    client.execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    kinds = {kind for output in shown for kind in output.get("data", {})}
    assert {"text/html", "image/svg+xml"} <= kinds
    said = "".join(output.get("text", "") for output in shown)
    share = next(line for line in said.splitlines() if line.endswith("%']")).split("'")[-2]
    assert float(share.removesuffix(" %")) < 60
    assert not [output for output in shown if output.output_type == "error"]
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_api_pages_hold_every_public_name_with_its_arguments(tmp_path):
    pytest.importorskip("pdoc")
    made = subprocess.run(
        [sys.executable, ROOT / "docs" / "api.py", tmp_path], capture_output=True, text=True
    )
    assert (made.returncode, made.stderr) == (0, "")
    page = (tmp_path / "resonance_mj.html").read_text()
    for name in rmj.__all__:
        assert f'id="{name}"' in page, name
    assert "run the law as plain Python in the callback" in page
    assert "assert_converged" in (tmp_path / "resonance_mj" / "testing.html").read_text()
