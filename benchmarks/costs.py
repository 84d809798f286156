"""What springs that are best by each cost leave, and how the law comes there: docs/springs.md.

Each run has its default gains, and motors of which nothing is given.
"""

import argparse
from time import perf_counter

import numpy as np

import resonance_mj as rmj
from resonance_mj.springs.cost import KINDS
from resonance_mj.springs.fit import fit

RUNS = ("two-link-transfer", "six-joint-pose", "seven-joint")


def main() -> None:
    """Print a table of motions by costs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="*", default=RUNS)
    names = parser.parse_args().runs
    experiments = [
        rmj.load(name).replace({"springs.cost": kind}) for name in names for kind in KINDS
    ]
    runs = rmj.simulate_many(experiments, progress=False)
    print(
        "| motion | least of | torque² | power [W] | peak | law / optimum | from cycle | fit [ms] |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for run in runs:
        for motion, best in zip(run.motions, run.plan.optima, strict=True):
            bounds, took = run.plan.gains.bounds, []
            for _ in range(9):
                begun = perf_counter()
                fit(best.q, best.torque_without_springs, bounds, best.center, best.dq)
                took.append(perf_counter() - begun)
            last = motion.summary()
            figures = [
                f"{last[name]:.4g} of {last[f'{name}_without_springs']:.4g}"
                for name in ("torque_squared", "electrical_power", "peak_torque")
            ]
            row = (
                f"{run.experiment.name} {motion.number}",
                KINDS[motion.kind].name,
                *figures,
                f"{motion.cost[-1] / motion.cost_optimal:.4f}",
                str(motion.cycles_to_optimum),
                f"{1e3 * np.median(took):.1f}",
            )
            print(f"| {' | '.join(row)} |")


if __name__ == "__main__":
    main()
