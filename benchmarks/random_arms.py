"""The default law on arms that nobody chose: how many cycles it takes, how near it ends.

    python benchmarks/random_arms.py [--arms N] [--seed S] [--reality PRESET] [--free]

Each arm has 2 to 7 hinges about random axes, links of 10 to 40 cm and 0.3 to 3 kg, light damping;
everything else is what the program finds for it. Half of the arms are run again, but for `--free`,
with motors that give a quarter more than the optimum needs, or a share of what is needed without
springs where that is more: 100, 70, 50, 30 %. Prints how many reach the optimum within 10 and 25
cycles, and how many end within 1, 2, 5 % of the bounded optimum of the joint motion that they made;
with small motors in the 37 cycles that they take, 12 of them growing.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.progress import track

import resonance_mj as rmj
from resonance_mj.experiments.loading import for_robot
from resonance_mj.plan.plan import plan_for
from resonance_mj.results.cycles import kept
from resonance_mj.springs.fit import LinearSprings
from resonance_mj.springs.optimum import best_springs

CYCLES = 25

LASTING = 60.0
"""Cycles under imperfections."""

SHARES = (1.0, 0.7, 0.5, 0.3)
"""Of the peak torque without springs, that small motors give at least."""


def mjcf(rng: np.random.Generator, limits: np.ndarray | None = None) -> str:
    """A serial arm as MJCF, of 2 to 7 joints; with the motors' limits (n,) [N m] or without."""
    joints = int(rng.integers(2, 8))
    open_bodies, motors = "", ""
    at = "0 0 0"
    for j in range(joints):
        length, mass, damping = rng.uniform(0.1, 0.4), rng.uniform(0.3, 3), rng.uniform(0, 0.05)
        axis = " ".join(map(str, np.eye(3)[rng.integers(3)]))
        along = " ".join(f"{x:.4f}" for x in length * np.eye(3)[rng.integers(3)])
        open_bodies += (
            f'<body name="link{j}" pos="{at}"><joint name="j{j}" axis="{axis}" '
            f'damping="{damping:.4f}"/><geom type="capsule" fromto="0 0 0 {along}" size="0.02" '
            f'mass="{mass:.4f}" contype="0" conaffinity="0"/>'
        )
        at = along
        if limits is not None:
            motors += f'<motor joint="j{j}" ctrlrange="{-limits[j]:.6g} {limits[j]:.6g}"/>'
    return (
        f'<mujoco><worldbody>{open_bodies}<site name="tool" pos="{at}"/>'
        f"{'</body>' * joints}</worldbody><actuator>{motors}</actuator></mujoco>"
    )


def arms(count: int, seed: int, folder: Path) -> Iterator[tuple[int, rmj.Experiment]]:
    """Random arms that can make the default motion, with its experiment and the arm's seed."""
    found, number = 0, seed
    while found < count:
        path = folder / f"arm{number}.xml"
        path.write_text(mjcf(np.random.default_rng(number)))
        experiment = for_robot(str(path)).replace({"motion.0.duration": float(CYCLES)})
        try:
            rmj.optimum(experiment)
        except rmj.ResonanceError:
            pass  # no size of the default motion suits it
        else:
            found += 1
            yield number, experiment
        number += 1


def with_limits(
    number: int, experiment: rmj.Experiment, folder: Path, share: float
) -> rmj.Experiment:
    """The same arm with small motors."""
    plan = plan_for(experiment)
    (best,) = plan.optima
    without, left = (np.abs(t).max(axis=0) for t in (best.torque_without_springs, best.torque))
    path = folder / f"limited{number}-{share}.xml"
    path.write_text(mjcf(np.random.default_rng(number), np.maximum(1.25 * left, share * without)))
    # The motion stays that of the arm with motors without limits.
    (motion,) = plan.experiment.motion
    as_before = {name: getattr(motion, name) for name in ("size", "center", "plane")}
    longer = {"robot.mjcf": str(path), "motion.0.duration": CYCLES + 12.0}
    return experiment.replace(
        longer | {f"motion.0.{name}": value for name, value in as_before.items()}
    )


class Ended(NamedTuple):
    """What is kept of a run."""

    status: str
    message: str
    reached: int | None
    """First cycle at the optimum."""
    tracking_rms: float
    nearness: float
    """torque² of the last cycle over that of the bounded optimum of the joint motion made."""


def ended(run: rmj.Run) -> Ended:
    """How a run ended."""
    motion, near = run.motions[0], np.inf
    if run.status is rmj.Status.OK:
        last = kept(run)[-1]
        acting = LinearSprings(last.stiffness, last.offset, last.center)
        best = best_springs(
            last.q,
            last.tau + acting.torque(last.q),
            center=last.q.mean(axis=0),
            period=run.experiment.motion[0].period,
            bounds=run.plan.gains.bounds,
        )
        near = float((last.tau**2).sum(axis=1).mean() / best.torque_squared)
    rms = float(motion.tracking_rms[-1]) if len(motion.tracking_rms) else np.inf
    return Ended(str(run.status), run.message, motion.cycles_to_optimum, rms, near)


HEADS = (
    "by cycle 10",
    f"by cycle {CYCLES}",
    *(f"within {percent} %" for percent in (1, 2, 5)),
    "RMS below 1 mm",
    "within 1 % and 1 mm",
    "not ok",
)


def row(name: str, runs: list[Ended]) -> str:
    """A line of the table."""
    counts = [
        sum(run.reached is not None and run.reached <= most for run in runs)
        for most in (10, CYCLES)
    ]
    counts += [sum(run.nearness < 1 + within for run in runs) for within in (0.01, 0.02, 0.05)]
    on_path = [run for run in runs if run.status == rmj.Status.OK and run.tracking_rms < 1e-3]
    counts += [len(on_path), sum(run.nearness < 1.01 for run in on_path)]
    counts += [sum(run.status != rmj.Status.OK for run in runs)]
    shares = " | ".join(f"{n} ({100 * n / len(runs):.1f} %)" for n in counts)
    return f"| {name} | {len(runs)} | {shares} |"


def main() -> None:
    """Run the arms and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arms", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--free", action="store_true", help="only motors without limits")
    parser.add_argument("--reality", help="a preset under which the arms without limits are run")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        free: dict[int, Ended] = {}
        limited: dict[float, list[Ended]] = {share: [] for share in SHARES}
        for number, experiment in track(
            arms(options.arms, options.seed, folder), total=options.arms
        ):
            if options.reality:
                lasting = {"motion.0.duration": LASTING, "reality": options.reality}
                experiment = experiment.replace(lasting)
            free[number] = ended(rmj.simulate(experiment, progress=False))
            if len(free) % 2 and not (options.reality or options.free):
                for share, runs in limited.items():
                    small = with_limits(number, experiment, folder, share)
                    runs.append(ended(rmj.simulate(small, progress=False)))
    print(f"| motors | arms | {' | '.join(HEADS)} |\n|{'---|' * (len(HEADS) + 2)}")
    print(row("without limits", list(free.values())))
    for share, runs in limited.items():
        if runs:
            print(row(f"small, at least {share:.0%} of the peak without springs", runs))
    for number, run in free.items():
        if run.status != rmj.Status.OK or run.nearness > 1.01 or run.tracking_rms > 1e-3:
            miss = f"{run.nearness:.3f} of the optimum, {1e3 * run.tracking_rms:.3g} mm"
            print(f"arm {number}: {run.status}: {miss}: {run.message}")


if __name__ == "__main__":
    main()
