"""What comes before the first step: seconds from `simulate` being called to its first `mj_step`.

    python benchmarks/startup.py [--rounds N]

Two arms in turn: the seven-joint arm of the package, and the same beside 30 MB of meshes, as
commercial arms have. The law is compiled before; MuJoCo's cache of meshes is emptied each time.
With PYTHONPATH at another checkout the same file measures that one.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.loading import for_robot

RINGS, MESHES = 400, 4
"""Vertices along and around each mesh, and how many there are: 30 MB in all."""


def main() -> None:
    """Print the medians."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    rounds = parser.parse_args().rounds
    print(f"{rmj.__file__}, {rounds} rounds")
    with tempfile.TemporaryDirectory() as folder:
        plain, heavy = arms(Path(folder))
        before_first_step(plain)
        taken: dict[str, list[float]] = {"seven_joint": [], "with 30 MB of meshes": []}
        for _ in range(rounds):
            for name, path in zip(taken, (plain, heavy), strict=True):
                taken[name].append(before_first_step(path))
    for name, seconds in taken.items():
        print(
            f"{name:22} {statistics.median(seconds):.3f} s "
            f"(from {min(seconds):.3f} to {max(seconds):.3f})"
        )


def before_first_step(path: Path) -> float:
    """Seconds from `simulate` to the first step of a run of two cycles."""
    experiment = for_robot(str(path)).replace({"motion.0.duration": 2.0})
    mujoco.mj_clearCache(mujoco.mj_getCache())
    step, first = mujoco.mj_step, []

    def timed(*arguments: Any) -> None:
        first.append(time.perf_counter())
        step(*arguments)

    mujoco.mj_step = timed
    try:
        began = time.perf_counter()
        rmj.simulate(experiment)
    finally:
        mujoco.mj_step = step
    return float(first[0] - began)


def arms(folder: Path) -> tuple[Path, Path]:
    """The seven-joint arm, and the same with meshes beside it that nothing touches."""
    text = library.robots()["seven_joint.xml"].read_text(encoding="utf-8")
    plain, heavy = folder / "plain.xml", folder / "heavy.xml"
    plain.write_text(text, encoding="utf-8")
    write_mesh(folder / "mesh.obj")
    assets = "".join(
        f'<mesh name="mesh{i}" file="mesh.obj" scale="{1 + i / 100} 1 1"/>' for i in range(MESHES)
    )
    geoms = "".join(
        f'<geom type="mesh" mesh="mesh{i}" pos="5 {i} 0" contype="0" conaffinity="0"/>'
        for i in range(MESHES)
    )
    world = f"<asset>{assets}</asset><worldbody>{geoms}"
    heavy.write_text(text.replace("<worldbody>", world, 1), encoding="utf-8")
    return plain, heavy


def write_mesh(path: Path) -> None:
    """An uneven sphere."""
    along, around = np.meshgrid(
        np.linspace(0, np.pi, RINGS),
        np.linspace(0, 2 * np.pi, RINGS, endpoint=False),
        indexing="ij",
    )
    r = 0.03 * (1 + 0.1 * np.sin(9 * along) * np.sin(7 * around))
    circle = np.stack([np.cos(around), np.sin(around)], axis=-1)
    points = np.dstack([(r * np.sin(along))[..., None] * circle, r * np.cos(along)])
    i, j = np.meshgrid(np.arange(RINGS - 1), np.arange(RINGS), indexing="ij")
    a, b = i * RINGS + j, i * RINGS + (j + 1) % RINGS
    faces = np.stack([a, a + RINGS, b, b, a + RINGS, b + RINGS], axis=-1).reshape(-1, 3) + 1
    with path.open("w", encoding="utf-8") as file:
        np.savetxt(file, points.reshape(-1, 3), "v %.6f %.6f %.6f")
        np.savetxt(file, faces, "f %d %d %d")


if __name__ == "__main__":
    main()
