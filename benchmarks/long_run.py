"""Ten thousand cycles of the paper's second motion under the transfer law: does it hold, how fast.

    python benchmarks/long_run.py [--cycles N]

Prints torque² beside the optimum's over blocks of cycles, the wall and processor time of the whole
run, the share of both that MuJoCo's steps with the law took, and the most memory that was used.
"""

from __future__ import annotations

import argparse
import resource
import time

import numpy as np
from rich.progress import Progress

import resonance_mj as rmj


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cycles", type=int, default=10_000)
    cycles = parser.parse_args().cycles
    experiment = rmj.load("two-link-transfer")
    motion = experiment.motion[1].model_copy(update={"duration": float(cycles)})
    experiment = experiment.model_copy(update={"motion": (motion,)})
    began, used = time.perf_counter(), time.process_time()
    with Progress() as progress:
        bar = progress.add_task("two-link-transfer", total=cycles)
        run = rmj.simulate(
            experiment, progress=lambda done, _: progress.update(bar, completed=done)
        )
    wall, processor = time.perf_counter() - began, time.process_time() - used
    (segment,) = run.summary()["segments"]
    ratio = run.data["torque_squared"].values / segment["torque_squared_optimal"]
    print(f"{run.status} {run.message}")
    print(f"{'cycles':>14} {'torque² / optimum: least':>26} {'most':>8}")
    for block in np.array_split(np.arange(cycles), 10):
        name = f"{block[0] + 1}-{block[-1] + 1}"
        print(f"{name:>14} {ratio[block].min():26.4f} {ratio[block].max():8.4f}")
    error = np.abs(np.divide(segment["stiffness"], segment["stiffness_optimal"]) - 1).max()
    print(f"stiffness at the end: within {error:.2%} of the optimum")
    print(f"tracking RMS of the last cycle: {segment['tracking_rms'] * 1e6:.2f} µm")
    print(
        f"wall {wall:.1f} s, processor {processor:.1f} s, of it steps {run.simulation_wall_s:.1f} s"
    )
    print(f"memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
