"""A long run: is memory flat, is time per cycle flat, does it stay at the optimum?

    python benchmarks/soak.py [--cycles N]

The paper's first motion under the transfer law. Prints, for each tenth of the run, the process's
memory and the median time of a cycle, and at the end torque² beside the optimum; exits 1 where
memory grew by more than 5 % after the first hundredth, the time of a cycle from the first tenth to
the last by more than 10 %, or torque² is more than 1 % off.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

import resonance_mj as rmj


def memory() -> float:
    """Of this process, resident [MB]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


def main() -> int:
    """Run and judge."""
    options = argparse.ArgumentParser()
    options.add_argument("--cycles", type=int, default=100_000)
    cycles = options.parse_args().cycles
    paper = rmj.load("two-link-transfer")
    motion = paper.motion[0].model_copy(update={"duration": float(cycles)})
    asked = paper.replace({"motion": [motion.model_dump(exclude_none=True)]})
    times, before, first, last = np.empty(cycles), time.perf_counter(), 0.0, 0.0

    def progress(done: int, total: int) -> None:
        nonlocal before, first, last
        now = time.perf_counter()
        times[done - 1], before = now - before, now
        if done == cycles // 100:
            first = memory()
        if done == cycles:
            last = memory()
        if done % (cycles // 10) == 0:
            tenth = times[done - cycles // 10 : done]
            print(f"{done} cycles: {memory():.0f} MB, {1e3 * np.median(tenth):.3f} ms a cycle")

    run = rmj.simulate(asked, progress=progress)
    grown = last / first - 1
    tenth = cycles // 10
    slower = np.median(times[-tenth:]) / np.median(times[2:tenth]) - 1
    (ended,) = run.motions
    off = ended.torque_squared[-1] / ended.torque_squared_optimal - 1
    size = run.data.nbytes / 1e6
    print(
        f"{run.status}: memory {100 * grown:+.1f} %, time of a cycle {100 * slower:+.1f} %, "
        f"torque² {100 * off:+.3f} % of the optimum's, data {size:.0f} MB"
    )
    return int(grown > 0.05 or slower > 0.1 or abs(off) > 0.01)


if __name__ == "__main__":
    sys.exit(main())
