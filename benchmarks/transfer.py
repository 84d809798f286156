"""The law as printed beside the transfer, on every robot in mjcf/: the tables of docs/transfer.md.

    python benchmarks/transfer.py [--long N] [NAME ...]

Each robot makes the motion of its run for 40 cycles and then another: the paper's second on the
paper's arm, an ellipse of 0.7 times the size on the others. Then the last motion is repeated N
times more from rest. Prints, of each motion, the cycle from which torque² stays within 5 % of the
optimum, how far the stiffness is from the optimum's at the end (of the stiffest spring), and the
tracking; and of the long run the worst of torque² against the optimum after its first tenth.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from rich.progress import Progress

import resonance_mj as rmj
from resonance_mj.evaluation.comparison import contending

CYCLES = 40
RUNS = (
    "two-link-transfer",
    "planar-three-link",
    "scara",
    "six-joint",
    "six-joint-pose",
    "seven-joint",
    "seven-joint-pose",
)


def changing(name: str) -> rmj.Experiment:
    """A run with a motion of 40 cycles and a change of motion after it."""
    experiment = rmj.load(name)
    if len(experiment.motion) > 1:
        return experiment
    first = experiment.motion[0].model_dump() | {"duration": CYCLES * experiment.motion[0].period}
    second = first | {"shape": "ellipse", "size": [0.7 * half for half in first["size"]]}
    return experiment.replace({"motion": [first, second]})


def repeated(experiment: rmj.Experiment, cycles: int) -> rmj.Experiment:
    """The last motion alone, many times."""
    last = experiment.motion[-1].model_dump()
    return experiment.replace({"motion": [last | {"duration": cycles * last["period"]}]})


def figures(run: rmj.Run, segment: int) -> list[str]:
    """Cycles to the optimum, error of the stiffness and tracking in a motion, as text."""
    found = run.summary()["segments"]
    if segment >= len(found) or found[segment]["torque_squared"] is None:
        return [str(run.status), "", ""]
    one = found[segment]
    best = np.array(one["stiffness_optimal"])
    off = np.abs(np.array(one["stiffness"]) - best).max() / np.abs(best).max()
    reached: Any = one["cycles_to_optimum"] or "never"
    return [str(reached), f"{100 * off:.2g}", f"{1e6 * one['tracking_rms']:.2g}"]


def lasting(run: rmj.Run) -> str:
    """How far torque² was from the optimum after the first tenth of a long run."""
    ratio = run.data["torque_squared"].values / run.data["torque_squared_optimal"].values[-1]
    if run.status is not rmj.Status.OK:
        return f"{run.status}, cycle {len(ratio)}"
    return f"{np.abs(ratio[len(ratio) // 10 :] - 1).max():.2%}"


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--long", type=int, default=1000, help="cycles of the long run")
    parser.add_argument("names", nargs="*", metavar="NAME", default=RUNS)
    options = parser.parse_args()
    motions = [
        f"motion {i}: {what}" for i in (1, 2) for what in ("cycles", "k off [%]", "RMS [µm]")
    ]
    print("| robot | law |", " | ".join(motions), f"| {options.long} cycles |")
    print("|---|---|" + "---|" * (len(motions) + 1))
    with Progress(transient=True) as progress:
        for name in options.names:
            experiment = changing(name)
            laws = {one.name: each for one, each in contending(experiment)}
            if name == "two-link-transfer":  # the printed law with the paper's own beta
                laws["printed"] = rmj.load("paper-centered")
            for law in ("printed", "transfer"):
                bar = progress.add_task(f"{name}, {law}")

                def show(done: int, total: int, bar: Any = bar) -> None:
                    progress.update(bar, completed=done, total=total)

                run = rmj.simulate(laws[law], progress=show)
                long = rmj.simulate(repeated(laws[law], options.long), progress=show)
                cells = [*figures(run, 0), *figures(run, 1), lasting(long)]
                progress.remove_task(bar)
                progress.console.print(
                    "|",
                    " | ".join([name.removesuffix("-transfer"), law, *cells]),
                    "|",
                    soft_wrap=True,
                )


if __name__ == "__main__":
    main()
