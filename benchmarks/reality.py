"""What imperfections of a real arm leave of the optimum: the table of docs/robustness.md.

    python benchmarks/reality.py [--seeds N] [--row WORD]

The paper's arm, the seven-joint and the six-joint arm with default gains, 60 cycles of each motion.
Of each row: the share of the possible reduction that the springs of the last cycle would give, the
reduction of torque² that the motors gave in the last five cycles as a share of what is possible,
and the RMS error of the tool; the worst of motions and seeds.
"""

import argparse

from rich.progress import track

import resonance_mj as rmj
from resonance_mj.evaluation.robustness import figures

CYCLES = 60

ARMS = {
    "two-link": ("two-link-transfer", {"law": {}, "law.kind": "transfer"}),
    "seven-joint": ("seven-joint", {}),
    "six-joint pose": ("six-joint-pose", {}),
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
    "`cheap`, growing over 12 cycles": {"reality": "cheap", "blend": 12},
    "payload of 2 kg": {"payload": 2.0},
    "payload of 4 kg": {"payload": 4.0},
}
"""Keys of the experiment or, without a section, of each motion."""


def experiment(arm, row, seed):
    """An experiment of an arm under a row's imperfections."""
    name, changes = ARMS[arm]
    base, of_row = rmj.load(name), dict(ROWS[row])
    blend = of_row.pop("blend", 1)
    payload = of_row.pop("payload", 0.0)
    for index, motion in enumerate(base.motion):
        changes = changes | {
            f"motion.{index}.duration": CYCLES * motion.period,
            f"motion.{index}.blend": blend,
            f"motion.{index}.payload": payload,
        }
    changes = changes | of_row
    if "reality" in changes:
        changes["reality.seed"] = seed
    return base.replace(changes)


def main():
    """Print the table."""
    options = argparse.ArgumentParser()
    options.add_argument("--seeds", type=int, default=3)
    options.add_argument("--row", default="", help="only rows with this word")
    given = options.parse_args()
    seeds = range(given.seeds)
    lines = []
    for row in track([name for name in ROWS if given.row in name]):
        cells = []
        for arm in ARMS:
            noisy = "reality" in ROWS[row]
            each = [experiment(arm, row, seed) for seed in (seeds if noisy else [0])]
            found = [figures(run) for run in rmj.simulate_many(each)]
            if lost := sum(one["kept"] is None for one in found):
                cells.append(f"diverged, {lost} of {len(found)}")
                continue
            share, reduction = (min(one[name] for one in found) for name in ("share", "kept"))
            error = 1e3 * max(one["tracking_rms"] for one in found)
            cells.append(f"{share:.4f}, {100 * reduction:.1f} %, {error:#.2g} mm")
        lines.append(f"| {row} | {' | '.join(cells)} |")
    print(f"| | {' | '.join(ARMS)} |\n|---|{'---|' * len(ARMS)}")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
