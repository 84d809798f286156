"""Frames per second of a video, beside a bare loop of mujoco.Renderer on the same model.

Both draw the same poses by the same camera, at the same size and quality; the video adds overlays,
captions, plots and H.264. Measured in turn, `ROUNDS` times, on one core and on two: medians of the
ratios are what a busy machine leaves meaningful. Software OpenGL has threads of its own, which it
starts once in a process for the cores it may use: each bare loop has a process of its own. A rate
is taken between the first frame and the last.

    .venv/bin/python benchmarks/render.py [RUN]           # the table
    .venv/bin/python benchmarks/render.py --whole [RUN]   # time and memory of a video of all of it

RUN is runs/paper if not given.
"""

import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from resonance_mj.pictures.film import gl

os.environ.setdefault("MUJOCO_GL", gl.backends()[0] or "")

import mujoco
import numpy as np

import resonance_mj as rmj
from resonance_mj.robots import robot

FRAMES, ROUNDS, FPS = 60, 5, 30.0
WIDTH, HEIGHT = 1280, 720


def camera(model):
    """The model's first camera, or its free one."""
    return model.camera(0).name if model.ncam else None


def bare(folder, cores):
    """Print frames per second of a loop that poses the model and draws it."""
    os.sched_setaffinity(0, range(cores))
    run = rmj.Run.load(folder)
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
            renderer.update_scene(data, -1 if camera(arm.model) is None else camera(arm.model))
            renderer.render(out=pixels)
            times.append(time.perf_counter())
    print((len(times) - 1) / (times[-1] - times[0]))


def bare_in_a_process(folder, cores):
    """Frames per second of the bare loop in a process of its own."""
    line = [sys.executable, __file__, "--bare", str(folder), str(cores)]
    return float(subprocess.run(line, check=True, capture_output=True, text=True).stdout)


def video(run, cores):
    """Frames per second of the whole pipeline."""
    os.sched_setaffinity(0, range(cores))
    options = rmj.RenderOptions(
        size=(WIDTH, HEIGHT), camera=camera(robot.build(run.experiment).model)
    )
    times = []
    with tempfile.TemporaryDirectory() as folder:
        rmj.render(
            run,
            Path(folder, "motion.mp4"),
            0.0,
            FRAMES / FPS,
            FPS,
            options=options,
            progress=lambda done, total: times.append(time.perf_counter()),
        )
        times.append(time.perf_counter())
    return (FRAMES - 1) / (times[-1] - times[0])


def table(folder):
    """Measure in turn and print medians."""
    run = rmj.Run.load(folder)
    columns = ("bare 1 core", "bare 2 cores", "video 1 core", "video 2 cores")

    def line(row):
        return "  ".join(f"{name} {rate:.2f}" for name, rate in zip(columns, row, strict=True))

    rates = []
    for _ in range(ROUNDS):
        rates.append([bare_in_a_process(folder, 1), bare_in_a_process(folder, 2)])
        rates[-1] += [video(run, 1), video(run, 2)]
        print(line(rates[-1]), flush=True)
    bare1, bare2, video1, video2 = np.array(rates).T
    print(f"{run.experiment.name}, {WIDTH}x{HEIGHT}, {FRAMES} frames, {ROUNDS} rounds; medians")
    print(line(np.median(rates, axis=0)))
    print(f"video / bare, both on one core: {np.median(video1 / bare1):.2f}")
    print(f"video on two cores / bare on one: {np.median(video2 / bare1):.2f}")
    print(f"video / bare, both on two cores: {np.median(video2 / bare2):.2f}")


def whole(folder):
    """Render all of a run; print the time, and the greatest memory of all processes together."""
    run = rmj.Run.load(folder)
    peak, done = [0], threading.Event()

    def watch():
        while not done.wait(0.5):
            peak[0] = max(peak[0], sum(map(proportional, family(os.getpid()))))

    watcher = threading.Thread(target=watch)
    watcher.start()
    frames, begin = [], time.perf_counter()
    with tempfile.TemporaryDirectory() as out:
        path = Path(out, "motion.mp4")
        rmj.render(
            run,
            path,
            fps=FPS,
            options=rmj.RenderOptions(size=(WIDTH, HEIGHT)),
            progress=lambda count, total: frames.append(count),
        )
        megabytes = path.stat().st_size / 1e6
    seconds = time.perf_counter() - begin
    done.set()
    watcher.join()
    print(
        f"{run.experiment.name}, {WIDTH}x{HEIGHT}: {len(frames)} frames in {seconds:.0f} s, "
        f"{megabytes:.1f} MB, all processes together at most {peak[0] / 1e6:.0f} MB"
    )


def family(pid):
    """A process and all that it started, and they in turn."""
    found = [pid]
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in task.read_text().split():
            found += family(int(child))
    return found


def proportional(pid):
    """Memory of a process [bytes], what is shared divided by those that share it."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) * 1000


if __name__ == "__main__":
    given = [one for one in sys.argv[1:] if not one.startswith("--")]
    if "--bare" in sys.argv:
        bare(given[0], int(given[1]))
    else:
        (whole if "--whole" in sys.argv else table)(given[0] if given else "runs/paper")
