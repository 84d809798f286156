"""A sweep beside MuJoCo's bare batch and beside one simulation after the other.

    python benchmarks/sweep.py [--robots 16 64] [--cycles 15] [--repeat 3]

The paper's arm under the transfer law, with as many learning gains as robots; everything from the
experiments to the dataset counts. The bare batch steps as many copies of the same model as many
steps, without a law. Measured in turn in one process; medians.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from statistics import median

import numpy as np
from mujoco.batch import Batch

import resonance_mj as rmj
from resonance_mj.plan.plan import plan_for


def seconds(work: Callable[[], object]) -> float:
    """How long some work takes [s]."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def bare(experiment: rmj.Experiment, robots: int) -> None:
    """The same steps of the same model without a law."""
    plan = plan_for(experiment, looks=False)
    batch = Batch(plan.robot.model, nsim=robots, nthread=0)
    batch.bind("qpos")[:] = plan.robot.qpos
    for segment in plan.schedule:
        batch.step(ids=np.arange(robots), nstep=plan.steps(segment))


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, nargs="+", default=[16, 64])
    parser.add_argument("--cycles", type=int, default=15)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    base = rmj.load("two-link-transfer")
    one = base.model_dump(exclude_unset=True)["motion"][0] | {"duration": float(options.cycles)}
    base = base.replace({"motion": [one]})
    rmj.simulate(base)  # compiles
    print("| robots | sweep [s] | bare batch [s] | ratio | one by one [s] | ratio |")
    print("|---|---|---|---|---|---|")
    for robots in options.robots:
        gains = np.linspace(2.0, 10.0, robots).tolist()
        experiments = [base.replace({"law.beta": beta}) for beta in gains]
        works: list[Callable[[], object]] = [
            lambda gains=gains: rmj.sweep(base, {"law.beta": gains}),
            lambda robots=robots: bare(base, robots),
            lambda experiments=experiments: [rmj.simulate(each) for each in experiments],
        ]
        times = [[seconds(work) for work in works] for _ in range(options.repeat)]
        sweep, batch, alone = (median(column) for column in zip(*times, strict=True))
        print(
            f"| {robots} | {sweep:.2f} | {batch:.2f} | {sweep / batch:.1f} | {alone:.2f} | "
            f"{alone / sweep:.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
