"""Files from strangers: mutated copies of what the project ships are taken, or refused."""

import subprocess
import sys
from pathlib import Path

import pytest

FUZZ = Path(__file__).parent.parent / "benchmarks" / "fuzz.py"


@pytest.mark.slow
def test_two_hundred_mutated_files_are_taken_or_refused_in_one_line():
    done = subprocess.run(
        [sys.executable, FUZZ, "--cases", "200", "--seed", "50000"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout[-3000:]
    assert "200 cases, 0 failed" in done.stdout


def test_a_case_that_fails_is_seen(tmp_path):
    """The judge is proved on an error that is not the program's own."""
    script = tmp_path / "broken.py"
    script.write_text(
        f"import sys; sys.path.insert(0, {str(FUZZ.parent)!r}); sys.argv = ['fuzz']\n"
        "import fuzz\n"
        "fuzz.plan_for = lambda experiment: 1 / 0\n"
        "sys.exit(fuzz.batch('robot', 0, 5) == 0)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert "ZeroDivisionError" in done.stdout
