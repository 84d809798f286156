"""What the paper leaves open, measured: the Markdown tables of docs/reproduction.md.

    python benchmarks/readings.py [TABLE ...] [--cycles N]

Tables: readings, optimum, springs, tracking, stability, scan. If none is named, all but scan,
which takes some minutes more.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

import resonance_mj as rmj
from resonance_mj.plan.plan import plan_for

LINK_1, LINK_2 = 0.3, 0.25
"""Lengths of the links [m], Sec. VI-A."""

STARTS = ((-0.3, 0.0), (-0.2, 0.3))
"""x_d(0) of the two motions [m], Sec. VI-A."""

Changes = dict[str, Any]


def pose(motion: int = 0, elbow: int = -1, turns: int = 0) -> list[float]:
    """Joint angles at the start of a motion, by inverse kinematics in closed form [rad].

    Args:
        motion: 0 or 1.
        elbow: sign of q2.
        turns: full turns added to q1, whose shoulder-to-tip angle is taken from 0 to 2π.
    """
    x, y = STARTS[motion]
    q2 = elbow * math.acos((x**2 + y**2 - LINK_1**2 - LINK_2**2) / (2 * LINK_1 * LINK_2))
    to_tip = math.atan2(y, x) % (2 * math.pi) + 2 * math.pi * turns
    return [to_tip - math.atan2(LINK_2 * math.sin(q2), LINK_1 + LINK_2 * math.cos(q2)), q2]


def centers(q_c: Any, q_s: Any) -> Changes:
    """The two centres that the paper does not report."""
    return {"law.q_c": q_c, "law.q_s": q_s}


CENTERED = centers("mean", "mean")
FASTER = {"law.gamma_k": [500.0, 50.0], "law.gamma_qe": [1500.0, 100.0]}
ELBOW_UP = {"robot.home": pose(elbow=1)}

READINGS: dict[str, tuple[str, Changes]] = {
    "`paper`: the reading chosen": ("paper", {}),
    "q_c = q_s = 0": ("paper", centers([0.0, 0.0], [0.0, 0.0])),
    "q_c = (-0.5, -2.0), q_s = mean": ("paper", {"law.q_s": "mean"}),
    "q_c = mean, q_s = 0": ("paper", {"law.q_c": "mean"}),
    "`paper-centered`: q_c = q_s = mean": ("paper-centered", {}),
    "`paper-running`: q_c = q_s = running mean": ("paper-running", {}),
    "`paper-transpose`: Jᵀ in (8)": ("paper-transpose", {}),
    "Jᵀ in (8), q_c = q_s = mean": ("paper-transpose", CENTERED),
    "Jᵀ in (8), β and Γ times 10": ("paper-transpose", FASTER | {"law.beta": 10.0}),
    "no gravity": ("paper", {"simulation.gravity": [0.0, 0.0, 0.0]}),
    "gravity 9.81 along -y": ("paper", {"simulation.gravity": [0.0, 0.0, -9.81]}),
    "gravity 9.8 along +x": ("paper", {"simulation.gravity": [9.8, 0.0, 0.0]}),
    "gravity 9.8 along -x": ("paper", {"simulation.gravity": [-9.8, 0.0, 0.0]}),
    "elbow q2 > 0": ("paper", ELBOW_UP),
    "elbow q2 > 0, q_c = q_s = mean": ("paper-centered", ELBOW_UP),
    "start at (3.5, -1.5)": ("paper", {"robot.home": [3.5, -1.5]}),
    "start at q1 = 4.00114 - 2π": ("paper", {"robot.home": pose(turns=-1)}),
    "q_e(0) = the start pose": ("paper", {"springs.initial_equilibrium": pose()}),
    "k(0) = (10, 2)": ("paper", {"springs.initial_stiffness": [10.0, 2.0]}),
    "time step 0.25 ms": ("paper", {"simulation.timestep": 0.25e-3}),
    "time step 0.5 ms": ("paper", {"simulation.timestep": 0.5e-3}),
    "time step 2 ms": ("paper", {"simulation.timestep": 2e-3}),
    "integrator Euler": ("paper", {"simulation.integrator": "Euler"}),
    "integrator RK4": ("paper", {"simulation.integrator": "RK4"}),
}

OPTIMA = {
    "g 9.8 along -y, q2 < 0": {},
    "g 9.81 along -y, q2 < 0": {"simulation.gravity": [0.0, 0.0, -9.81]},
    "no gravity, q2 < 0": {"simulation.gravity": [0.0, 0.0, 0.0]},
    "g 9.8 along +x, q2 < 0": {"simulation.gravity": [9.8, 0.0, 0.0]},
    "g 9.8 along -x, q2 < 0": {"simulation.gravity": [-9.8, 0.0, 0.0]},
    "g 9.8 along -y, q2 > 0": ELBOW_UP,
    "no gravity, q2 > 0": ELBOW_UP | {"simulation.gravity": [0.0, 0.0, 0.0]},
}

GRAVITIES = {
    "g 9.8 along -y": [0.0, 0.0, -9.8],
    "g 9.8 along +y": [0.0, 0.0, 9.8],
    "g 9.8 along +x": [9.8, 0.0, 0.0],
    "g 9.8 along -x": [-9.8, 0.0, 0.0],
    "no gravity": [0.0, 0.0, 0.0],
}
SCAN_1 = (-1.0, -0.5, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
SCAN_2 = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0)
PRINTED = (98.0, 84.0)
"""Reductions that the paper prints [%], Sec. VI-B."""

LONG: tuple[Changes, ...] = (
    {"law.beta": 1.0},
    {"law.beta": 3.0},
    {"law.beta": 10.0},
    {"law.beta": 1.0, "simulation.timestep": 0.25e-3},
    {"law.beta": 1.0, "law.lead": 1},
    {"law.beta": 3.0, "law.lead": 1},
    {"law.beta": 10.0, "law.lead": 1},
    {"law.beta": 1.0, "law.lead": 2},
    {"law.beta": 10.0, "law.lead": 2},
)
"""What the long runs change in `paper-centered`."""


def alone(motion: int, cycles: int, changes: Changes) -> rmj.Experiment:
    """One motion of `paper-centered` alone, from rest at its own start."""
    centered = rmj.load("paper-centered")
    repeated = centered.motion[motion].model_dump() | {"duration": float(cycles)}
    return centered.replace(
        {"motion": [repeated], "robot.home": pose(motion), "simulation.samples": 400_000} | changes
    )


def readings() -> Iterator[Sequence[str]]:
    """Of each reading, at the ends of both motions: reduction [%], K [N m/rad], tracking [mm]."""
    yield (
        "reading",
        "39-40 s",
        "79-80 s",
        "optimum",
        "K",
        "RMS",
    )
    runs = rmj.simulate_many([rmj.load(name).replace(new) for name, new in READINGS.values()])
    for label, run in zip(READINGS, runs, strict=True):
        ends = run.summary()["segments"]
        if any(end["torque_reduction"] is None for end in ends):
            yield (label, *("-",) * 4, run.message)
            continue
        yield (
            label,
            *(f"{100 * end['torque_reduction']:.1f}" for end in ends),
            "; ".join(f"{100 * end['torque_reduction_optimal']:.1f}" for end in ends),
            "; ".join(listed(end["stiffness"], 2) for end in ends),
            "; ".join(f"{1e3 * end['tracking_rms']:.2f}" for end in ends),
        )


def optimum() -> Iterator[Sequence[str]]:
    """The best constant springs, which only gravity and the elbow's branch change."""
    yield "gravity, elbow", "motion", "K_opt [N m/rad]", "q_e,opt [rad]", "reduction [%]"
    for label, changes in OPTIMA.items():
        for number, best in enumerate(rmj.optimum(rmj.load("paper").replace(changes)), 1):
            yield (
                label,
                str(number),
                listed(best.stiffness, 3),
                listed(best.equilibrium, 3),
                f"{100 * best.torque_reduction:.1f}",
            )


def springs() -> Iterator[Sequence[str]]:
    """What the springs do within the last cycle of a motion, and what they would do held still.

    Swings in N m/rad and N m, reductions in %. The last two columns leave tracking out: they are
    the springs on the exact joint motion q_d.
    """
    yield (
        "run, cycle",
        "swing of k",
        "swing of q̄_e",
        "reduction",
        "on q_d",
        "on q_d, held at mean",
    )
    for label, (name, changes) in {
        "`paper`": ("paper", {}),
        "`paper-centered`": ("paper-centered", {}),
        "centered, Γ times 10, lead 1": ("paper-centered", FASTER | {"law.lead": 1}),
    }.items():
        experiment = rmj.load(name).replace(changes)
        run, optima = rmj.simulate(experiment), rmj.optimum(experiment)
        for best, cycle, end in zip(optima, (40, 80), run.summary()["segments"], strict=True):
            now = run.data.isel(time=run.data["cycle_of_sample"].values == cycle)
            k, offset = now["stiffness"].values, now["offset"].values
            yield (
                f"{label}, {cycle}",
                listed(np.ptp(k, axis=0), 2),
                listed(np.ptp(offset, axis=0), 2),
                f"{100 * end['torque_reduction']:.1f}",
                f"{on_desired(best, k, offset):.1f}",
                f"{on_desired(best, k.mean(axis=0), offset.mean(axis=0)):.1f}",
            )


def on_desired(best: rmj.Optimum, k: np.ndarray, offset: np.ndarray) -> float:
    """Reduction [%] by given springs, constant or not, on the exact joint motion."""
    left = best.torque_without_springs - (offset - k * (best.q - best.center))
    return 100 * (1 - (left**2).sum(axis=1).mean() / best.torque_squared_without_springs)


def tracking() -> Iterator[Sequence[str]]:
    """Tracking [mm] of each motion after 300 cycles with lead 1, beside `half_a_step`."""
    yield "integrator", "time step [ms]", "motion 1", "half a step", "motion 2", "half a step"
    cases = [
        {"law.lead": 1, "simulation.integrator": name, "simulation.timestep": dt}
        for name in ("implicitfast", "RK4")
        for dt in (1e-3, 0.5e-3)
    ]
    experiments = [alone(motion, 300, case) for case in cases for motion in (0, 1)]
    runs = iter(rmj.simulate_many(experiments))
    for case in cases:
        name, dt = case["simulation.integrator"], case["simulation.timestep"]
        cells = []
        for run in (next(runs), next(runs)):
            expected = "-" if name == "RK4" else f"{half_a_step(run.experiment):.4f}"
            cells += [f"{1e3 * run.data['tracking_rms'].values[-1]:.4f}", expected]
        yield name, f"{1e3 * dt:g}", *cells


def half_a_step(experiment: rmj.Experiment) -> float:
    """RMS of Δx [mm] where y of (8) vanishes and q̇ is the slope of q half a time step earlier.

    It is the periodic solution of d(Δx)/dt + α Δx = (Δt/2) J q̈_d.
    """
    plan = plan_for(experiment)
    motion, kinematics = plan.joints[0], plan.kinematics
    dt = experiment.simulation.timestep
    pushed = [
        kinematics.jacobian(q) @ ddq * dt / 2 for q, ddq in zip(motion.q, motion.ddq, strict=True)
    ]
    omega = 2 * np.pi * np.fft.rfftfreq(len(pushed), dt)
    shape = np.fft.rfft(pushed, axis=0) / (experiment.law.alpha + 1j * omega)[:, None]
    error = np.fft.irfft(shape, len(pushed), axis=0)
    return float(1e3 * np.sqrt((error**2).sum(axis=1).mean()))


def stability(cycles: int) -> Iterator[Sequence[str]]:
    """Each motion alone for many cycles: when torque² passes that of an arm without springs."""
    yield (
        "motion",
        "β",
        "dt [ms]",
        "lead",
        "best [%]",
        "worse",
        "DIVERGED",
        "torque²",
        "RMS",
        "u [Hz]",
    )
    runs = rmj.simulate_many(
        [alone(motion, cycles, changes) for changes in LONG for motion in (0, 1)]
    )
    for index, run in enumerate(runs):
        changes = LONG[index // 2]
        ratio = run.data["torque_squared"].values / float(
            run.data["torque_squared_without_springs"][0]
        )
        # From this cycle on, counted from 1, no cycle is better than an arm without springs.
        worse = int(np.flatnonzero(ratio <= 1)[-1]) + 2
        ended = len(ratio) if run.status == rmj.Status.DIVERGED else None
        yield (
            str(index % 2 + 1),
            f"{changes['law.beta']:g}",
            f"{1e3 * changes.get('simulation.timestep', 1e-3):g}",
            str(changes.get("law.lead", 0)),
            f"{100 * (1 - ratio.min()):.1f} in cycle {int(ratio.argmin()) + 1}",
            f"from {worse}" if worse <= len(ratio) else f"not in {len(ratio)}",
            f"in {ended}" if ended else f"not in {len(ratio)}",
            f"{ratio[-1]:.3g}",
            f"{1e3 * run.data['tracking_rms'].values[-1]:.2f}",
            f"{loudest(run):g}",
        )


OWN = 50
"""Harmonics of 1/T that a motion's own torque has."""


def loudest(run: rmj.Run) -> float:
    """Frequency above the motion's own at which the last learned torque kept is largest [Hz]."""
    cycle = run.data["cycle_of_sample"].values
    u = run.data["u"].values[cycle == cycle[-1]]
    spectrum = np.abs(np.fft.rfft(u, axis=0)).max(axis=1)
    spectrum[:OWN] = 0.0
    return float(spectrum.argmax() / run.experiment.motion[0].period)


def scan() -> Iterator[Sequence[str]]:
    """For each gravity and elbow, which q_c of a grid, with q_s = 0, is nearest to the paper."""
    yield (
        "gravity, elbow",
        "optimum [%]",
        "nearest q_c [rad]",
        "39-40 s [%]",
        "79-80 s [%]",
        "both within 1 and 2 points",
    )
    grid = [[float(q_c1), float(q_c2)] for q_c1 in SCAN_1 for q_c2 in SCAN_2]
    # Without samples in time: only the figures of the cycles are read.
    common = {"law.q_s": [0.0, 0.0], "simulation.samples": 1}
    for direction, gravity in GRAVITIES.items():
        for sign, elbow in (("<", {}), (">", ELBOW_UP)):
            paper = rmj.load("paper").replace({"simulation.gravity": gravity} | elbow | common)
            runs = rmj.simulate_many([paper.replace({"law.q_c": q_c}) for q_c in grid])
            ends = [run.summary()["segments"] for run in runs]
            found = 100 * np.array(
                [[end["torque_reduction"] or np.nan for end in pair] for pair in ends]
            )
            away = np.abs(found - PRINTED)
            best = int(np.nanargmin(away.sum(axis=1)))
            near = int((away <= (1.0, 2.0)).all(axis=1).sum())
            yield (
                f"{direction}, q2 {sign} 0",
                "; ".join(f"{100 * end['torque_reduction_optimal']:.1f}" for end in ends[0]),
                listed(grid[best], 1),
                *(f"{value:.1f}" for value in found[best]),
                f"{near} of {len(grid)}",
            )


def listed(values: Sequence[float] | np.ndarray, digits: int) -> str:
    """Numbers of the two joints."""
    return "(" + ", ".join(f"{value:.{digits}f}" for value in values) + ")"


def main() -> None:
    """Print the tables."""
    tables = {
        "readings": readings,
        "optimum": optimum,
        "springs": springs,
        "tracking": tracking,
        "stability": lambda: stability(options.cycles),
        "scan": scan,
    }
    parser = argparse.ArgumentParser(description="Tables of docs/reproduction.md.")
    parser.add_argument("table", nargs="*", help=f"of {', '.join(tables)}; all but scan if none")
    parser.add_argument("--cycles", type=int, default=1800, help="most cycles of a long run")
    options = parser.parse_args()
    unknown = [name for name in options.table if name not in tables]
    if unknown:
        parser.error(f"{unknown[0]}: no such table; there are {', '.join(tables)}")
    if options.cycles < 2:
        parser.error(f"--cycles {options.cycles}: at least 2 are needed")
    for name in options.table or [name for name in tables if name != "scan"]:
        print(f"{name}\n")
        for index, row in enumerate(tables[name]()):
            print(f"| {' | '.join(row)} |")
            if index == 0:
                print("|" + "---|" * len(row))
        print(flush=True)


if __name__ == "__main__":
    main()
