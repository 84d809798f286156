"""What kinds of springs leave to the motors, on the project's arms: the table of docs/springs.md.

    python benchmarks/elements.py
    python benchmarks/elements.py --pairs

The optimum of each desired motion by inverse dynamics, with stiffness >= 0: torque² [N² m²], mean
|τ q̇| of all motors [W] and the largest torque [N m]. Or what antagonistic pairs of tendons
of several rates leave on the paper's arm, and the law with them.
"""

import argparse
from itertools import combinations, pairwise

import numpy as np
from transfer import RUNS

import resonance_mj as rmj
from resonance_mj.plan.plan import plan_for


def kinds(plan):
    """What each kind of springs on a plan's arm changes in its experiment."""
    joints, home = plan.robot.joints, plan.joints[0].q.mean(axis=0)
    slopes = [
        {"name": f"{joint} {kind}", "kind": kind, "joints": [joint], "rest": float(angle)}
        for joint, angle in zip(joints, home, strict=True)
        for kind in ("above", "below")
    ]
    own = {joint: {"kind": "adjustable"} for joint in joints}
    none = {joint: {"kind": "none"} for joint in joints}
    return {
        "none": {"springs.joint": none},
        "linear": {},
        "cubic": {"springs.element": [{"kind": "cubic", "joints": [j]} for j in joints]},
        "two slopes": {"springs.element": slopes, "springs.joint": own},
        "and neighbours": {"springs.element": [{"joints": list(two)} for two in pairwise(joints)]},
        "and all pairs": {
            "springs.element": [{"joints": list(two)} for two in combinations(joints, 2)]
        },
    }


def main():
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", action="store_true", help="of antagonistic pairs")
    if parser.parse_args().pairs:
        pairs()
        return
    for name in RUNS:
        experiment = rmj.load(name).replace({"springs.stiffness": [0.0, np.inf]})
        each = kinds(plan_for(experiment))
        if name == RUNS[0]:
            print(f"| motion | {' | '.join(each)} |\n|---|{'---|' * len(each)}")
        plans = [plan_for(experiment.replace(changes)) for changes in each.values()]
        for number in range(len(experiment.motion)):
            cells = [_cell(plan.optima[number], plan.joints[number].dq) for plan in plans]
            print(f"| {name} {number + 1} | {' | '.join(cells)} |", flush=True)


def pairs():
    """Print what taut pairs of tendons leave, and where the law is with them."""
    print(
        "| a [N/m] | least that taut pairs leave | law / optimum | from cycle |\n|---|---|---|---|"
    )
    for rate in (100.0, 50.0, 20.0):
        given = {"kind": "antagonistic", "radii": [0.05], "pull": [rate, 100 * rate]}
        both = [given | {"joints": [j], "pretension": 1.0} for j in ("joint1", "joint2")]
        experiment = rmj.load(RUNS[0]).replace({"springs.element": both})
        motions = rmj.simulate(experiment, progress=False).motions
        least = ", ".join(f"{motion.torque_squared_optimal:.4g}" for motion in motions)
        of = [motion.torque_squared[-1] / motion.torque_squared_optimal for motion in motions]
        cycles = ", ".join(str(motion.cycles_to_optimum) for motion in motions)
        print(f"| {rate:g} | {least} | {', '.join(f'{one:.4f}' for one in of)} | {cycles} |")


def _cell(best, dq):
    power = np.abs(best.torque * dq).sum(axis=1).mean()
    return f"{best.torque_squared:.4g}, {power:.3g} W, {np.abs(best.torque).max():.3g}"


if __name__ == "__main__":
    main()
