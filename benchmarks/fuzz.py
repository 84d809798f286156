"""Mutated copies of every file that the project ships: each is taken, or refused in one line.

    python benchmarks/fuzz.py [--cases N] [--seed S] [--kind WORD]

A case is loaded and planned, and simulated for a few cycles if that takes no more than `STEPS` time
steps. It fails where an exception comes that is not the program's own, where the message has more
than a line or does not name the file, where it takes longer than `SECONDS`, or where the process
grows by more than `MEMORY`, or writes into the working folder. Exits 1 if one failed.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import resource
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

import numpy as np

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.errors import ResonanceError
from resonance_mj.plan.plan import plan_for

STEPS, SECONDS, MEMORY = 20_000, 10.0, 2 << 30

NUMBERS = "0 -0.0 1 -1 2 3.5 1e-9 1e-308 1e9 1e18 1e308 -1e308 nan inf -inf 9999999999999999999"
WORDS = 'x joint1 "" true "lab" [] [1.0] {} -- "../x" "é" "\\u0000" transfer linear'
CHARACTERS = "\"'[]{}()<>=#,.-+eE\\/ \n\t\0é∞0123456789azAZ_:&;%"

WAYPOINTS = """t,x,z
0.0,-0.3,0.0
0.25,-0.25,0.1
0.5,-0.2,0.0
0.75,-0.25,-0.1
"""


def mutated(text: str, rng: random.Random) -> str:
    """A text with one to three things changed in it."""
    for _ in range(rng.randint(1, 3)):
        kind = rng.randrange(7)
        numbers = list(re.finditer(r"-?\d+\.?\d*(?:e[-+]?\d+)?", text))
        words = list(re.finditer(r"[A-Za-z_][\w.-]*", text))
        lines = text.split("\n")
        at = rng.randrange(len(text) + 1)
        if kind <= 1 and numbers:
            found = rng.choice(numbers)
            text = text[: found.start()] + rng.choice(NUMBERS.split()) + text[found.end() :]
        elif kind == 2 and words:
            found, other = rng.choice(words), rng.choice(words)[0]
            with_what = rng.choice([other, rng.choice(WORDS.split())])
            text = text[: found.start()] + with_what + text[found.end() :]
        elif kind == 3:
            text = text[:at] + text[at + rng.choice([1, 1, 3, 20, 200]) :]
        elif kind == 4:
            extra = "".join(rng.choices(CHARACTERS, k=rng.choice([1, 1, 2, 30])))
            text = text[:at] + extra + text[at:]
        elif kind == 5:
            one = rng.randrange(len(lines))
            lines.insert(rng.randrange(len(lines) + 1), lines[one])
            text = "\n".join(lines)
        else:
            one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
            lines[one], lines[other] = lines[other], lines[one]
            text = "\n".join(lines)
    return text


def sources() -> dict[str, list[tuple[str, str]]]:
    """Of each kind of file, those that the project ships: name and text."""
    experiments = library.experiments() | library.validation()
    cases = Path(__file__).parent.parent.parent / "shared" / "cases"
    others = sorted(cases.glob("robots/*.xml")) + sorted(cases.glob("robots/*.urdf"))
    robots = [*library.robots().values(), *others]
    return {
        "experiment": [(path.name, path.read_text()) for path in experiments.values()]
        + [("elements.toml", ELEMENTS), ("reality.toml", REALITY)],
        "robot": [(path.name, path.read_text()) for path in robots],
        "waypoints": [("way.csv", WAYPOINTS)],
        "sweep": [(path.name, path.read_text()) for path in library.sweeps().values()],
    }


ELEMENTS = """[robot]
mjcf = "two_link.xml"
[task]
coordinates = ["x", "z"]
[[motion]]
duration = 4.0
[springs]
stiffness = [0.0, 200.0]
[springs.joint.joint2]
rest = -1.5
[[springs.element]]
kind = "cubic"
joints = "joint1"
stiffness = [0.0, 300.0]
[[springs.element]]
name = "both"
joints = ["joint1", "joint2"]
radii = [0.5, -0.3]
rest = [0.0, 2.0]
[[springs.element]]
kind = "above"
joints = ["joint2"]
rest = -1.0
"""

REALITY = """reality = {preset = "lab", seed = 3, motor_torque = [30.0, 20.0], torque_delay = 0.001}
[robot]
mjcf = "two_link.xml"
[task]
coordinates = ["x", "z"]
[[motion]]
duration = 6.0
payload = 0.5
blend = 4
"""


def tried(kind: str, name: str, text: str, folder: Path) -> str:
    """What is wrong with how a case is taken; empty if nothing is."""
    path = folder / name
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    began = time.perf_counter()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wrong = ""
    try:
        _use(kind, path)
    except ResonanceError as error:
        said = str(error)
        if "\n" in said:
            wrong = f"several lines: {said[:300]!r}"
        elif len(said) > 2000:
            wrong = f"a line of {len(said)} letters: {said[:200]!r}"
    except RecursionError:
        wrong = "recursion"
    except Exception:
        wrong = traceback.format_exc(limit=-3)
    if (took := time.perf_counter() - began) > SECONDS:
        wrong += f" took {took:.1f} s"
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    if grown > MEMORY:
        wrong += f" grew by {grown / 2**30:.1f} GiB"
    return wrong


def _use(kind: str, path: Path) -> None:
    if kind == "sweep":
        from resonance_mj.experiments.sweeping import load_sweep

        _ = load_sweep(str(path)).size
        return
    if kind == "waypoints":
        motion = {"file": str(path), "duration": 4.0}
        experiment = rmj.load("two-link-transfer").replace({"motion": [motion], "law": {}})
    else:
        experiment = rmj.load(path)
    motions = experiment.motion
    few = {f"motion.{i}.duration": min(one.cycles, 4) * one.period for i, one in enumerate(motions)}
    experiment = experiment.replace(few)
    dt = experiment.simulation.timestep
    steps = sum(one.cycles * one.steps(dt) for one in experiment.motion)
    if experiment.law.kind.endswith(".py"):
        return
    if steps > STEPS:
        return
    plan = plan_for(experiment)
    _ = plan.notes
    run = rmj.simulate(experiment)
    run.summary()


def batch(kind: str, first: int, count: int) -> int:
    """Try some cases, each on a line of its own, and say which failed."""
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        work = folder / "work"
        work.mkdir()
        os.chdir(work)
        files = sources()[kind]
        for number in range(first, first + count):
            rng = random.Random(number)
            source, text = files[rng.randrange(len(files))]
            print(f"@ {number} {source}", flush=True)
            with np.errstate(all="ignore"):
                wrong = tried(kind, source, mutated(text, rng), folder)
            left = [path.name for path in work.iterdir()]
            if left:
                wrong += f" left {left}"
                for path in work.iterdir():
                    path.unlink()
            if wrong:
                bad += 1
                print(f"! {kind} {number} {source}: {wrong}", flush=True)
    return bad


def main() -> int:
    """Try the cases, in processes of their own that are ended where they hang."""
    options = argparse.ArgumentParser()
    options.add_argument("--cases", type=int, default=1000)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--kind", default="")
    options.add_argument("--batch", nargs=3)
    given = options.parse_args()
    if given.batch:
        kind, first, count = given.batch
        return int(batch(kind, int(first), int(count)) > 0)
    kinds = [kind for kind in sources() if given.kind in kind]
    bad, size, done = 0, 100, 0
    each = -(-given.cases // len(kinds))
    for kind in kinds:
        first, last = given.seed, given.seed + each
        while first < last:
            count = min(size, last - first)
            ended = _watched(kind, first, count)
            bad += ended[1]
            done += ended[0] - first
            first = ended[0]
            print(f"{done} cases, {bad} failed", file=sys.stderr, end="\r")
    print(f"\n{done} cases, {bad} failed")
    return int(bad > 0)


def _watched(kind: str, first: int, count: int) -> tuple[int, int]:
    """Run a batch; the number that comes after what was tried, and how many failed."""
    command = [sys.executable, __file__, "--batch", kind, str(first), str(count)]
    bad, last, seen = 0, first, 0
    with tempfile.TemporaryDirectory() as name:
        output = Path(name) / "output"
        with output.open("wb") as file:
            process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
        timer = time.monotonic()
        while True:
            ended = process.poll() is not None
            lines = output.read_text(errors="replace").split("\n")[:-1]
            for line in lines[seen:]:
                timer = time.monotonic()
                if line.startswith("@"):
                    last = int(line.split()[1])
                else:
                    bad += line.startswith("!")
                    print(line)
            seen = len(lines)
            if ended:
                break
            if time.monotonic() - timer > 3 * SECONDS:
                process.kill()
                process.wait()
                print(f"! {kind} {last}: hangs")
                return last + 1, bad + 1
            time.sleep(0.05)
    if process.returncode not in (0, 1):
        print(f"! {kind} {last}: the process ended with {process.returncode}")
        return last + 1, bad + 1
    return first + count, bad


if __name__ == "__main__":
    sys.exit(main())
