"""The command that takes a sweep file."""

from __future__ import annotations

import os
import time
from argparse import Namespace
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import resonance_mj as rmj

from ..progress import bar
from ..text import duration, shown
from .command import DONE, NOT_WELL, Screen, argument, command, complain, flag

if TYPE_CHECKING:
    from ..experiments.sweeping import Sweep


DASK = argument(
    "--dask", "simulate on a Dask cluster, or local:N for N workers here", metavar="ADDRESS"
)


@command(
    argument("sweep", "a sweep's TOML file, or a built-in name", metavar="SWEEP"),
    argument("--out", "where to write; runs/NAME", metavar="FOLDER", type=Path),
    argument("--threads", "to simulate with; all cores", metavar="N", type=int, default=0),
    DASK,
    flag("--dry-run", "say how many experiments, how long and how large, and nothing else"),
    flag("--yes", "allow more than a million experiments"),
    figures=True,
)
def sweep(options: Namespace) -> int:
    """Simulate an experiment with many values of its keys."""
    from ..experiments.sweeping import load_sweep

    settings, screen = load_sweep(options.sweep), Screen(options)
    folder = options.out or Path("runs") / Path(options.sweep).stem
    if options.dry_run:
        figures, line = _foreseen(settings, options)
        screen.table(figures)
        screen.line(line)
        return DONE
    name = folder.name
    with bar(f"{name}: preparing", "runs", screen.console, settings.size, then=name) as show:
        how = {"threads": options.threads, "dask": options.dask, "yes": options.yes}
        found = rmj.sweep(options.sweep, folder=folder, **how, progress=show)
    counts = Counter(found["status"].values.ravel().tolist())
    said = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    screen.table({"folder": folder, "runs": settings.size, "status": dict(counts)})
    screen.line(f"{settings.size} runs: {said}")
    screen.line(f"{folder}: sweep.nc, summary.csv, sweep.json")
    if counts["ok"]:
        return DONE
    complain(f"{folder.name}: no run is ok; summary.csv says why")
    return NOT_WELL


def _foreseen(settings: Sweep, options: Namespace) -> tuple[dict[str, float], str]:
    """What a sweep would take, by the first experiment's first cycles."""
    from ..sweeps.dataset import FIGURES
    from ..sweeps.sweep import SHARD

    experiments = settings.experiments(yes=options.yes)
    first = experiments[0]
    dt, cores = first.simulation.timestep, options.threads or os.cpu_count() or 1
    steps = sum(
        motion.cycles * motion.steps(one.simulation.timestep)
        for one in experiments
        for motion in one.motion
    )
    motion = first.motion[0]
    few = {"duration": motion.period * min(3, motion.cycles), "blend": 0}
    pilot = first.model_copy(update={"motion": (motion.model_copy(update=few),)})
    began = time.perf_counter()
    run = rmj.simulate(pilot)
    each = time.perf_counter() - began - run.simulation_wall_s
    seconds = (steps * run.simulation_wall_s / run.steps + each * len(experiments)) / cores
    joints, most = run.data.sizes["joint"], max(len(one.motion) for one in experiments)
    cycles = max(sum(motion.cycles for motion in one.motion) for one in experiments)
    disk = 8 * len(experiments) * (most * (len(FIGURES) + 4 * joints) + 2 * cycles)
    columns = 7 * joints + 2 * run.data.sizes["axis"]
    memory = SHARD * 8 * columns * 6 * max(one.steps(dt) for one in first.motion)
    figures = {
        "experiments": len(experiments),
        "time_steps": steps,
        "seconds": seconds,
        "disk_bytes": disk,
        "memory_bytes": memory,
    }
    return figures, (
        f"{len(experiments)} experiments, {steps:.3g} time steps: about {duration(seconds)} on "
        f"{cores} cores, {disk / 1e6:.3g} MB on disk and {memory / 1e6:.3g} MB of memory more than "
        "the models take"
    )


@command(
    argument("tuning", "a tuning's TOML file: docs/tuning.md", metavar="TUNING"),
    argument("--out", "where to write; runs/NAME", metavar="FOLDER", type=Path),
    argument("--threads", "to simulate with; all cores", metavar="N", type=int, default=0),
    DASK,
    figures=True,
)
def tune(options: Namespace) -> int:
    """Look for the keys of an experiment that are best by a figure."""
    from ..experiments.tuning import load_tuning

    settings, screen = load_tuning(options.tuning), Screen(options)
    folder = options.out or Path("runs") / Path(options.tuning).stem
    name, total = folder.name, settings.trials
    with bar(f"{name}: preparing", "trials", screen.console, total, then=name) as show:
        how = {"threads": options.threads, "dask": options.dask}
        found = rmj.tune(options.tuning, folder=folder, **how, progress=show)
    tried = int(found.data.sizes["run"])
    within = int(found.data["feasible"].sum())
    figures = {"folder": folder, "trials": tried, "feasible": within, "figure": found.figure}
    screen.table(figures | {"value": found.value, "keys": found.keys})
    screen.line(f"{tried} trials, {within} ok and within the constraints")
    if found.keys:
        screen.line(f"best: {found.figure} = {found.value:.6g}, with")
        for key, value in found.keys.items():
            screen.line(f"  {key} = {shown(value)}")
    best = ["best.toml"] if found.keys else []
    screen.line(f"{folder}: {', '.join([*best, 'sweep.nc', 'summary.csv', 'sweep.json'])}")
    if found.keys:
        return DONE
    complain(f"{folder.name}: no trial is ok within the constraints; summary.csv says why")
    return NOT_WELL
