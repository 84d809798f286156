"""What is done beside stepping and learning: recording, watching for what goes wrong, checkpoints.

    python benchmarks/overhead.py [--cycles N] [--rounds N]

The shares of a run's time, between its first step and its last, that go to each; the median of
rounds, in one process and in turn over two arms. Checkpoints are asked for after each cycle, of
which a run saves as many as it has time for. Exits 1 where they take more than 5 % together.
"""

import argparse
import sys
import tempfile
import time
from collections import defaultdict
from unittest import mock

import numpy as np
from rich.progress import track

import resonance_mj as rmj
from resonance_mj.results.run import Run
from resonance_mj.simulation.member import Member
from resonance_mj.simulation.recording import Recording

TARGET = 0.05
"""Most that they may take together, as a share of a run."""

ARMS = ("two-link-transfer", "seven-joint")

PARTS = {
    "recording": (Recording, "add"),
    "watching": (Member, "_what_diverged"),
    "checkpoints": (Member, "checkpoint"),
    "saving them": (Run, "save"),
}


def shares(name: str, cycles: int) -> dict[str, float]:
    """Share of a run that each part takes, and of the run that is an arm's stepping."""
    spent: dict[str, float] = defaultdict(float)

    def timed(part, function):
        def call(*given, **more):
            began = time.perf_counter()
            try:
                return function(*given, **more)
            finally:
                spent[part] += time.perf_counter() - began

        return call

    moments = []
    experiment = rmj.load(name)
    motion = experiment.motion[0]
    motion = motion.model_copy(update={"duration": cycles * motion.period})
    experiment = experiment.replace({"motion": [motion.model_dump(exclude_none=True)]})
    with tempfile.TemporaryDirectory() as folder:
        patches = [
            mock.patch.object(home, method, timed(part, getattr(home, method)))
            for part, (home, method) in PARTS.items()
        ]
        for patch in patches:
            patch.start()
        run = rmj.simulate(
            experiment,
            checkpoint=1,
            folder=folder,
            progress=lambda *_: moments.append(time.perf_counter()),
        )
        for patch in patches:
            patch.stop()
    whole = (moments[-1] - moments[0]) * len(moments) / (len(moments) - 1)
    return {part: spent[part] / whole for part in PARTS} | {
        "stepping": run.simulation_wall_s / whole
    }


def main() -> int:
    """Measure and print."""
    options = argparse.ArgumentParser()
    options.add_argument("--cycles", type=int, default=8000)
    options.add_argument("--rounds", type=int, default=3)
    given = options.parse_args()
    found = defaultdict(list)
    for _ in track(range(given.rounds), "rounds"):
        for name in ARMS:
            found[name].append(shares(name, given.cycles))
    missed = False
    print(f"{'':20}" + "".join(f"{part:>14}" for part in (*PARTS, "together", "stepping")))
    for name, rounds in found.items():
        of = {part: float(np.median([one[part] for one in rounds])) for part in rounds[0]}
        together = float(np.median([sum(one[part] for part in PARTS) for one in rounds]))
        missed |= together > TARGET
        values = [*(of[part] for part in PARTS), together, of["stepping"]]
        print(f"{name:20}" + "".join(f"{100 * value:12.1f} %" for value in values))
    print(f"target: at most {100 * TARGET:.0f} % together: {'MISSED' if missed else 'met'}")
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
