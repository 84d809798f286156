"""Frames per second of a video, beside a bare loop of mujoco.Renderer on the same model.

Both draw the same poses at the same size and quality; the video adds overlays, captions, plots and
H.264. In one process and in turn, `ROUNDS` times, on one core and on two: medians of the ratios are
what a busy machine leaves meaningful. A rate is taken between the first frame and the last.

Run it with `.venv/bin/python benchmarks/render.py [RUN]`; RUN is runs/paper if not given.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

from resonance_mj.video import gl

os.environ["MUJOCO_GL"] = gl.backends()[0] or ""

import mujoco
import numpy as np

import resonance_mj as rmj
from resonance_mj.robots import robot

FRAMES, ROUNDS, FPS = 60, 5, 30.0
WIDTH, HEIGHT = 1280, 720


def bare(run, cores):
    """Frames per second of a loop that poses the model and draws it."""
    os.sched_setaffinity(0, cores)
    arm = robot.build(run.experiment)
    buffer = arm.model.vis.global_
    buffer.offwidth, buffer.offheight = max(buffer.offwidth, WIDTH), max(buffer.offheight, HEIGHT)
    data = mujoco.MjData(arm.model)
    step = round(1 / (FPS * run.experiment.simulation.timestep))
    poses = run.data["q"].values[: FRAMES * step : step]
    pixels = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    times = []
    with mujoco.Renderer(arm.model, HEIGHT, WIDTH) as renderer:
        for q in poses:
            data.qpos[arm.qpos_address] = q
            mujoco.mj_kinematics(arm.model, data)
            mujoco.mj_comPos(arm.model, data)
            mujoco.mj_camlight(arm.model, data)
            renderer.update_scene(data)
            renderer.render(out=pixels)
            times.append(time.perf_counter())
    return (len(times) - 1) / (times[-1] - times[0])


def video(run, cores):
    """Frames per second of the whole pipeline."""
    os.sched_setaffinity(0, cores)
    times = []
    with tempfile.TemporaryDirectory() as folder:
        rmj.render(
            run,
            Path(folder, "motion.mp4"),
            0.0,
            FRAMES / FPS,
            FPS,
            look=rmj.Look(size=(WIDTH, HEIGHT)),
            progress=lambda done, total: times.append(time.perf_counter()),
        )
        times.append(time.perf_counter())
    return (FRAMES - 1) / (times[-1] - times[0])


def main():
    """Measure in turn and print medians."""
    run = rmj.Run.load(sys.argv[1] if len(sys.argv) > 1 else "runs/paper")
    all_cores = sorted(os.sched_getaffinity(0))
    sets = [set(all_cores[:1]), set(all_cores[:2])][: min(2, len(all_cores))]
    rates = []
    for _ in range(ROUNDS):
        rates.append([(bare(run, cores), video(run, cores)) for cores in sets])
        print("  ".join(f"bare {b:5.1f} video {v:5.1f}" for b, v in rates[-1]), flush=True)
    table = np.array(rates)
    print(f"{run.experiment.name}, {WIDTH}x{HEIGHT}, {FRAMES} frames, {ROUNDS} rounds; medians")
    for index, cores in enumerate(sets):
        b, v = np.median(table[:, index], axis=0)
        same = np.median(table[:, index, 1] / table[:, index, 0])
        one = np.median(table[:, index, 1] / table[:, 0, 0])
        print(
            f"{len(cores)} core(s): bare {b:.1f}, video {v:.1f} frames/s; video by bare on as many "
            f"cores {same:.2f}, by bare on one core {one:.2f}"
        )


if __name__ == "__main__":
    main()
