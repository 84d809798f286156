"""Mutation testing of the mathematics: which single changes of the source no test notices.

    python benchmarks/mutation.py [--least SHARE]

mutmut changes one operator, number or name at a time in `equations.py`, `learning.py` and `fit.py`
and runs the tests of these files. It does so in a copy below build/, in which the functions are
plain Python: compiled code is cached and would not change. Prints the changes that survive and the
share killed; exits with 1 where less than 95 % are. `[tool.mutmut]` of pyproject.toml says what is
run.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
COPY = ROOT / "build" / "mutation"
MUTMUT = Path(sys.executable).with_name("mutmut")
DECORATOR = "@step_function\n"


def interpreted_copy() -> None:
    """Copy what the tests need, without the decorators that compile."""
    shutil.rmtree(COPY, ignore_errors=True)
    for name in ("resonance_mj", "mjcf", "runs", "tests"):
        ignored = shutil.ignore_patterns("__pycache__", *([] if name != "runs" else ["*.nc"]))
        shutil.copytree(ROOT / name, COPY / name, ignore=ignored)
    shutil.copy(ROOT / "pyproject.toml", COPY)
    for path in (COPY / "resonance_mj").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace(DECORATOR, ""), encoding="utf-8")


def mutmut(*arguments: str) -> str:
    """What a command of mutmut prints."""
    command = [MUTMUT, *arguments]
    process = subprocess.run(command, cwd=COPY, capture_output=True, text=True)
    if process.returncode:
        sys.exit(f"mutmut {' '.join(arguments)}: {process.stdout[-2000:]}{process.stderr[-2000:]}")
    return process.stdout


def main() -> int:
    """Run mutmut and print what survived."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--least", type=float, default=0.95, help="share that must be killed")
    least = parser.parse_args().least
    interpreted_copy()
    mutmut("run")
    lines = mutmut("results", "--all", "true").splitlines()
    status = dict(line.strip().split(": ") for line in lines if ": " in line)
    survived = [name for name, end in status.items() if end not in ("killed", "timeout")]
    for name in survived:
        change = [
            line
            for line in mutmut("show", name).splitlines()
            if line.startswith(("-", "+")) and not line.startswith(("---", "+++"))
        ]
        print(f"{name}: {status[name]}", *change, sep="\n")
    share = 1 - len(survived) / len(status)
    print(f"{len(status) - len(survived)} of {len(status)} killed: {share:.1%}")
    return int(share < least)


if __name__ == "__main__":
    sys.exit(main())
