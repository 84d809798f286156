"""What springs that are best by each cost leave, and how the law comes there: docs/springs.md.

    python benchmarks/costs.py [RUN ...]
    python benchmarks/costs.py --hold 1000 [RUN ...]

Each run has its default gains, and motors of which nothing is given.
"""

import argparse
from time import perf_counter

import numpy as np

import resonance_mj as rmj
from resonance_mj.plan.plan import plan_for
from resonance_mj.springs.cost import KINDS
from resonance_mj.springs.fit import fit

RUNS = ("two-link-transfer", "six-joint-pose", "seven-joint")


def held(cycles: int, name: str) -> None:
    """Print the ends of the law's cost over its optimum's in the second half of many cycles."""
    base = rmj.load(name)
    one = base.model_dump(exclude_unset=True)["motion"][0] | {"duration": float(cycles)}
    base = base.replace({"motion": [one], "simulation.samples": 2000})
    (best,) = rmj.optimum(base)
    # Elements are on the two joints that need most.
    most = np.argsort(-(best.torque_without_springs**2).sum(axis=0))[:2]
    joints = [plan_for(base).robot.joints[j] for j in sorted(most)]
    elements: dict[str, list[dict[str, object]]] = {
        "none": [],
        "cubic": [{"kind": "cubic", "joints": [joint]} for joint in joints],
        "over two joints": [{"joints": joints, "radii": [0.5, -1.5]}],
        "antagonistic": [
            {"kind": "antagonistic", "joints": [joint], "radii": [0.05], "pull": [50.0, 5000.0]}
            for joint in joints
        ],
    }
    print("| elements | least of | from | least | greatest |\n|---|---|---|---|---|")
    for name, given in elements.items():
        for kind in KINDS:
            changes = {"springs.element": given, "springs.cost": kind}
            run = rmj.simulate(base.replace(changes), progress=False)
            (motion,) = run.motions
            if run.status != "ok":
                print(
                    f"| {name} | {KINDS[kind].name} | {run.status}: {run.message} |||", flush=True
                )
                continue
            ratio = (motion.cost / motion.cost_optimal)[cycles // 2 :]
            ends = f"{ratio.min():.4f} | {ratio.max():.4f}"
            print(
                f"| {name} | {KINDS[kind].name} | {motion.cycles_to_optimum} | {ends} |", flush=True
            )


def main() -> None:
    """Print a table of motions by costs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="*", default=RUNS)
    parser.add_argument("--hold", type=int, metavar="CYCLES", help="one motion for so many")
    options = parser.parse_args()
    if options.hold:
        for name in RUNS[:1] if options.runs == RUNS else options.runs:
            held(options.hold, name)
        return
    names = options.runs
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
