"""A long run: is memory flat, is time per cycle flat, does it stay at the optimum?

    python benchmarks/soak.py [--cycles N]

The paper's first motion under the transfer law. Prints, for each tenth of the run, the process's
memory, the median CPU time of a cycle and how many times that of the same steps of a bare arm it
is, which are timed in turn with it; and at the end torque² beside the optimum. Exits 1 where memory
grew by more than 5 % after the first hundredth, that ratio from the first tenth to the last by more
than 10 %, or torque² is more than 1 % off.
"""

import argparse
import sys
import time
from pathlib import Path

import mujoco
import numpy as np

import resonance_mj as rmj
from resonance_mj import library

BARE = 20
"""Cycles after which the bare arm's steps are timed again."""


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
    times, bare = np.empty(cycles), np.full(cycles, np.nan)
    before, first, last = time.thread_time(), 0.0, 0.0
    model = mujoco.MjModel.from_xml_path(str(library.robots()["two_link.xml"]))
    model.opt.timestep = paper.simulation.timestep
    data, steps = mujoco.MjData(model), motion.steps(model.opt.timestep)

    def progress(done: int, total: int) -> None:
        nonlocal before, first, last
        times[done - 1] = time.thread_time() - before
        if done % BARE == 0:
            began = time.thread_time()
            mujoco.mj_step(model, data, steps)
            bare[done - 1] = time.thread_time() - began
        if done == cycles // 100:
            first = memory()
        if done == cycles:
            last = memory()
        if done % (cycles // 10) == 0:
            tenth = slice(done - cycles // 10, done)
            print(
                f"{done} cycles: {memory():.0f} MB, {1e3 * np.median(times[tenth]):.3f} ms a cycle,"
                f" {ratio(tenth):.3f} times the bare arm's"
            )
        before = time.thread_time()

    def ratio(part: slice) -> float:
        return float(np.median(times[part]) / np.nanmedian(bare[part]))

    run = rmj.simulate(asked, progress=progress)
    grown = last / first - 1
    tenth = cycles // 10
    slower = ratio(slice(cycles - tenth, cycles)) / ratio(slice(2, tenth)) - 1
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
