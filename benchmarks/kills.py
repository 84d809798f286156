"""A run that is killed at random moments and resumed, again and again, against one left alone.

    python benchmarks/kills.py [--kills N] [--seed S]

Each time `run --checkpoint 2 --resume` is begun and killed with SIGKILL after up to six seconds;
what it left must be a whole run, and each run that comes to its end must have the bits of one that
was never killed. Prints how often it came to its end, and exits 1 where anything differed.
"""

import argparse
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from rich.progress import Progress

import resonance_mj as rmj

KEYS = {"simulation.timestep": 5e-4}


def main() -> int:
    """Kill and compare."""
    options = argparse.ArgumentParser()
    options.add_argument("--kills", type=int, default=50)
    options.add_argument("--seed", type=int, default=0)
    given = options.parse_args()
    chance = random.Random(given.seed)
    alone = rmj.simulate(rmj.load("two-link-transfer").replace(KEYS))
    kills = ends = bad = 0
    with tempfile.TemporaryDirectory() as name, Progress() as progress:
        task = progress.add_task("kills", total=given.kills)
        folder = Path(name) / "run"
        command = [sys.executable, "-P", "-m", "resonance_mj.cli", "run", "two-link-transfer"]
        command += [part for key, value in KEYS.items() for part in (f"--{key}", str(value))]
        command += ["--checkpoint", "2", "--resume", "--out", str(folder), "--quiet"]
        while kills < given.kills:
            process = subprocess.Popen(command)
            try:
                process.wait(timeout=chance.uniform(0.3, 6.0))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                kills += 1
                progress.update(task, completed=kills)
                if (folder / "run.nc").exists():
                    rmj.Run.load(folder)
                continue
            ends += 1
            run = rmj.Run.load(folder)
            differs = [
                name
                for name in alone.data.variables
                if not np.array_equal(alone.data[name], run.data[name])
            ]
            hidden = [path.name for path in folder.iterdir() if path.name.startswith(".")]
            if process.returncode or differs or hidden:
                bad += 1
                print(f"status {process.returncode}, differ: {differs}, left: {hidden}")
            for path in sorted(folder.rglob("*"), reverse=True):
                path.rmdir() if path.is_dir() else path.unlink()
    print(f"{kills} kills, {ends} runs came to their end, {bad} of them not as they should")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
