"""Seconds from `simulate` to the first step of MuJoCo, on a light arm and on one with heavy meshes.

    python benchmarks/startup.py [--rounds N]

Another version of the package is measured by the same script with PYTHONPATH set to its checkout.
The arms are mjcf/seven_joint.xml, and the same with 30 MB of generated meshes.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.loading import for_robot

POINTS, MESHES = 400, 4


def heavy(folder: Path, text: str) -> Path:
    """The arm with an uneven sphere, a few times in other sizes, as meshes that are only seen."""
    u = np.linspace(0, np.pi, POINTS)[:, None]
    v = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    r = 0.03 * (1 + 0.1 * np.sin(9 * u) * np.sin(7 * v))
    points = np.stack([r * np.sin(u) * np.cos(v), r * np.sin(u) * np.sin(v), r * np.cos(u)], -1)
    i, j = np.meshgrid(np.arange(POINTS - 1), np.arange(POINTS), indexing="ij")
    a, b = i * POINTS + j, i * POINTS + (j + 1) % POINTS
    faces = np.stack([a, a + POINTS, b, b, a + POINTS, b + POINTS], -1).reshape(-1, 3) + 1
    with (folder / "m.obj").open("w") as file:
        file.writelines(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points.reshape(-1, 3))
        file.writelines(f"f {a} {b} {c}\n" for a, b, c in faces)
    assets = "".join(
        f'<mesh name="m{n}" file="m.obj" scale="{1 + n / 100} 1 1"/>' for n in range(MESHES)
    )
    geoms = "".join(
        f'<geom type="mesh" mesh="m{n}" pos="5 {n} 0" contype="0" conaffinity="0"/>'
        for n in range(MESHES)
    )
    path = folder / "heavy.xml"
    with_meshes = f"<asset>{assets}</asset><worldbody>{geoms}"
    path.write_text(text.replace("<worldbody>", with_meshes, 1))
    return path


def seconds(arm: Path) -> float:
    """From the call of `simulate` to its first step."""
    experiment = for_robot(str(arm)).replace({"motion.0.duration": 2.0})
    step, first = mujoco.mj_step, []

    def timed(*arguments: object) -> None:
        first.append(time.perf_counter())
        step(*arguments)

    mujoco.mj_step = timed
    try:
        began = time.perf_counter()
        rmj.simulate(experiment)
    finally:
        mujoco.mj_step = step
    return first[0] - began


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    with tempfile.TemporaryDirectory() as name:
        light = Path(name, "light.xml")
        light.write_text(library.robots()["seven_joint.xml"].read_text(encoding="utf-8"))
        arms = {"light": light, "heavy": heavy(Path(name), light.read_text())}
        seconds(light)  # loads the law
        for label, arm in arms.items():
            found = [seconds(arm) for _ in range(rounds)]
            print(
                f"{label}: {statistics.median(found):.3f} s ({min(found):.3f} to {max(found):.3f})"
            )
    print(f"{rmj.__file__}, MuJoCo {mujoco.__version__}, median of {rounds}")


if __name__ == "__main__":
    main()
