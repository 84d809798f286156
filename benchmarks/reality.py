"""What imperfections of a real arm leave of the optimum: the table of docs/robustness.md.

    python benchmarks/reality.py [--seeds N] [--row WORD] [--robots FILE...]

The paper's arm, the seven-joint and the six-joint arm with default gains, 60 cycles of each motion;
or other arms, each with the motion that is found for it.
Of each row: the share of the possible reduction that the springs of the last cycle would give, the
reduction of torque² that the motors gave in the last five cycles as a share of what is possible,
with such springs as the row has,
and the RMS error of the tool; the worst of motions and seeds.
"""

import argparse
from pathlib import Path

from rich.progress import track

import resonance_mj as rmj
from resonance_mj.evaluation.robustness import figures
from resonance_mj.experiments.loading import for_robot

CYCLES = 60

ARMS = {
    "two-link": rmj.load("two-link-transfer").replace({"law": {}, "law.kind": "transfer"}),
    "seven-joint": rmj.load("seven-joint"),
    "six-joint pose": rmj.load("six-joint-pose"),
}

ROWS = {
    "ideal": {},
    "encoder noise of 1e-4 rad": {"reality": {"encoder_noise": 1e-4}},
    "encoder noise of 1e-3 rad": {"reality": {"encoder_noise": 1e-3}},
    "measurement 5 ms late": {"reality": {"measurement_delay": 0.005}},
    "measurement 10 ms late": {"reality": {"measurement_delay": 0.01}},
    "torque 10 ms late": {"reality": {"torque_delay": 0.01}},
    "control at 200 Hz": {"reality": {"control_period": 0.005}},
    "stiffness at 1 N m/rad/s": {"reality": {"stiffness_rate": 1.0}},
    "friction of 10 %": {"reality": {"friction": 0.1}},
    "`lab`": {"reality": "lab"},
    "`cheap`": {"reality": "cheap"},
    "control at 100 Hz": {"reality": {"control_period": 0.01}},
    "springs of x + 2 x³": {"reality": {"spring_stiffening": 2.0}},
    "springs with 10 % hysteresis": {"reality": {"spring_hysteresis": 0.1}},
    "springs damped by 10 ms": {"reality": {"spring_damping": 0.01}},
    "springs 30 % too stiff": {"reality": {"spring_error": 0.3}},
    "`lab`, springs of x + 0.5 x³": {
        "reality": {"preset": "lab", "spring_stiffening": 0.5, "spring_hysteresis": 0.05}
    },
    "payload of 2 kg": {"payload": 2.0},
    "payload of 4 kg": {"payload": 4.0},
}
"""Keys of the experiment or, without a section, of each motion. Springs that are not linear are
passive and within half a turn, as by default."""


def experiment(base, row, seed):
    """An experiment under a row's imperfections."""
    changes, of_row = {}, dict(ROWS[row])
    payload = of_row.pop("payload", 0.0)
    for index, motion in enumerate(base.motion):
        changes = changes | {
            f"motion.{index}.duration": CYCLES * motion.period,
            f"motion.{index}.blend": None,
            f"motion.{index}.payload": payload,
        }
    changes = changes | of_row
    if "reality" in changes:
        changes["reality.seed"] = seed
    if "spring" in row:
        changes["springs"] = {}
    return base.replace(changes)


def main():
    """Print the table."""
    options = argparse.ArgumentParser()
    options.add_argument("--seeds", type=int, default=3)
    options.add_argument("--row", default="", help="only rows with this word")
    options.add_argument("--robots", nargs="+", default=[], help="other arms, as MJCF or URDF")
    given = options.parse_args()
    arms = {Path(path).parent.name: for_robot(path) for path in given.robots} or ARMS
    seeds = range(given.seeds)
    lines = []
    for row in track([name for name in ROWS if given.row in name]):
        cells = []
        for arm in arms.values():
            noisy = "reality" in ROWS[row]
            each = [experiment(arm, row, seed) for seed in (seeds if noisy else [0])]
            found = [figures(run) for run in rmj.simulate_many(each, progress=False)]
            if lost := sum(one["kept"] is None for one in found):
                cells.append(f"diverged, {lost} of {len(found)}")
                continue
            share, reduction = (min(one[name] for one in found) for name in ("share", "kept"))
            error = 1e3 * max(one["tracking_rms"] for one in found)
            cells.append(f"{share:.4f}, {100 * reduction:.1f} %, {error:#.2g} mm")
        lines.append(f"| {row} | {' | '.join(cells)} |")
    print(f"| | {' | '.join(arms)} |\n|---|{'---|' * len(arms)}")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
