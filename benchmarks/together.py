"""Runs at once, in processes and in threads: nothing lost, nothing different, nothing left behind.

    python benchmarks/together.py [--processes 8] [--threads 8]

Processes begin together with an empty cache of compiled laws, each into a folder of its own, and
then all into one folder; threads simulate in one process. Each run must have the bits of one that
was made alone, one process must have the one folder and the others be told so, and no temporary
file may be left. Exits 1 where anything is otherwise.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import resonance_mj as rmj

NAME = "two-link-transfer"


def same(run: rmj.Run, alone: rmj.Run) -> bool:
    """Whether two runs have the same signals, to the last bit."""
    return all(np.array_equal(alone.data[name], run.data[name]) for name in alone.data.variables)


def started(folder: Path, cache: Path) -> subprocess.Popen:
    """A process that simulates into a folder."""
    command = [sys.executable, "-P", "-m", "resonance_mj.cli", "run", NAME, "--quiet"]
    return subprocess.Popen(
        [*command, "--out", str(folder)],
        env=os.environ | {"XDG_CACHE_HOME": str(cache)},
        stderr=subprocess.PIPE,
        text=True,
    )


def main() -> int:
    """Run and count."""
    options = argparse.ArgumentParser()
    options.add_argument("--processes", type=int, default=8)
    options.add_argument("--threads", type=int, default=8)
    given = options.parse_args()
    alone, wrong = rmj.simulate(rmj.load(NAME)), 0
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        for folders in ([root / str(i) for i in range(given.processes)], [root / "one"]):
            cache, began = root / f"cache-{len(folders)}", time.perf_counter()
            many = [started(folders[i % len(folders)], cache) for i in range(given.processes)]
            ended = [(process.communicate()[1], process.returncode) for process in many]
            told = sum("another run is being written there" in said for said, _ in ended)
            done = sum(status == 0 for _, status in ended)
            differ = sum(not same(rmj.Run.load(folder), alone) for folder in folders)
            left = [path.name for folder in folders for path in folder.glob(".*")]
            kept = len(list(cache.rglob("control-*.o")))
            bad = done + told != given.processes or done < len(folders) or differ or left
            wrong += bool(bad) or kept != 1
            print(
                f"{given.processes} processes, {len(folders)} folder(s): {done} done, {told} told "
                f"that another has it, {differ} differ, {len(left)} files left behind, {kept} "
                f"compiled law(s), {time.perf_counter() - began:.0f} s"
            )
    began = time.perf_counter()
    with ThreadPoolExecutor(given.threads) as pool:
        runs = list(pool.map(lambda _: rmj.simulate(rmj.load(NAME)), range(2 * given.threads)))
    differ = sum(not same(run, alone) for run in runs)
    print(
        f"{given.threads} threads: {len(runs)} runs, {differ} differ, "
        f"{time.perf_counter() - began:.0f} s"
    )
    return int(bool(wrong or differ))


if __name__ == "__main__":
    sys.exit(main())
