"""A run that is interrupted or killed goes on where it was, and ends with the same bits."""

import dataclasses
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.errors import ResonanceError
from resonance_mj.status import Status

CASES = {
    "two motions": ("two-link-transfer", {"motion.0.duration": 8.0, "motion.1.duration": 8.0}),
    "a real arm whose motion grows": (
        "seven-joint",
        {"reality": "lab", "motion.0.duration": 12.0, "motion.0.blend": 4},
    ),
    "elements, thinned, with a load": (
        "two-link-transfer",
        {
            "motion.0.duration": 7.0,
            "motion.1.duration": 7.0,
            "motion.1.payload": 0.5,
            "springs.element": [{"joints": ["joint1", "joint2"]}],
            "simulation.samples": 6000,
        },
    ),
    "the law as printed under RK4": (
        "paper",
        {"motion.0.duration": 6.0, "motion.1.duration": 6.0, "simulation.integrator": "RK4"},
    ),
}


def experiment(case):
    name, changes = CASES[case]
    return rmj.load(name).replace(changes)


def interrupted(asked, after, **options):
    done = []
    return rmj.simulate(asked, stop=lambda: done.append(1) or len(done) == after, **options)


def same(one, other):
    return [
        name
        for name in one.data.variables
        if not np.array_equal(
            one.data[name], other.data[name], equal_nan=one.data[name].dtype.kind == "f"
        )
    ] == [] and (one.status, one.message, one.notes, one.steps) == (
        other.status,
        other.message,
        other.notes,
        other.steps,
    )


@pytest.mark.parametrize(
    "case",
    [*list(CASES)[:2], *(pytest.param(one, marks=pytest.mark.slow) for one in list(CASES)[2:])],
)
def test_an_interrupted_run_ends_as_if_nothing_had_happened(case, tmp_path):
    asked = experiment(case)
    whole = rmj.simulate(asked)
    for after in (1, 5, len(whole.plan.schedule) - 1):
        part = interrupted(asked, after)
        assert part.status is Status.INTERRUPTED
        part.save(tmp_path / "run")
        assert same(rmj.simulate(asked, resume=rmj.Run.load(tmp_path / "run")), whole)


def test_a_run_may_be_interrupted_again_and_again(tmp_path):
    asked = experiment("two motions")
    part = interrupted(asked, 3)
    for _ in range(3):
        part = interrupted(asked, 3, resume=part)
    assert part.data.sizes["cycle"] == 12
    assert same(rmj.simulate(asked, resume=part), rmj.simulate(asked))


def test_a_run_that_has_ended_is_returned_as_it_is():
    asked = experiment("two motions")
    whole = rmj.simulate(asked)
    assert rmj.simulate(asked, resume=whole) is whole


def test_only_the_same_experiment_with_the_same_versions_is_resumed():
    asked = experiment("two motions")
    part = interrupted(asked, 3)
    with pytest.raises(ResonanceError, match="is of another experiment"):
        rmj.simulate(asked.replace({"law.beta": 9.0}), resume=part)
    older = dataclasses.replace(part, versions=part.versions | {"mujoco": "3.9.9"})
    with pytest.raises(ResonanceError, match=r"was begun with mujoco 3\.9\.9"):
        rmj.simulate(asked, resume=older)
    without = dataclasses.replace(part, data=part.data.drop_vars("checkpoint"))
    with pytest.raises(ResonanceError, match="did not keep the state"):
        rmj.simulate(asked, resume=without)


def test_a_checkpoint_that_was_changed_is_refused_before_a_step_goes_by_it():
    asked = experiment("two motions")
    part = interrupted(asked, 3)
    state = part.data["checkpoint"].values
    for wrong in (state[:-3], state[:5], np.zeros(4), np.full_like(state, np.nan), state * 1.5):
        damaged = part.data.assign(checkpoint=("number", wrong, part.data["checkpoint"].attrs))
        with pytest.raises(ResonanceError, match="checkpoint is damaged"):
            rmj.simulate(asked, resume=dataclasses.replace(part, data=damaged))
    # A number of the law's memory by which its compiled step finds an array.
    numbers = np.flatnonzero(state == float(len(part.data["joint"])))
    for at in numbers[:3]:
        moved = state.copy()
        moved[at] = 1e6
        damaged = part.data.assign(checkpoint=("number", moved, part.data["checkpoint"].attrs))
        try:
            run = rmj.simulate(asked, resume=dataclasses.replace(part, data=damaged))
        except ResonanceError:
            continue
        assert run.status in Status  # it was no size or place: a number that steps change


def test_a_checkpoint_without_a_folder_is_refused():
    for given in ({"checkpoint": 5}, {"checkpoint": -1, "folder": "run"}):
        with pytest.raises(ResonanceError, match="a number of cycles and a folder"):
            rmj.simulate(experiment("two motions"), **given)


def command(folder):
    keys = ["--motion.0.duration", "12", "--motion.1.duration", "12"]
    keys += ["--simulation.timestep", "2e-4"]
    options = ["--checkpoint", "2", "--resume", "--out", str(folder), "--quiet"]
    return subprocess.Popen(
        [
            sys.executable,
            "-P",
            "-m",
            "resonance_mj.cli",
            "run",
            "two-link-transfer",
            *keys,
            *options,
        ],
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
def test_a_killed_run_goes_on_with_the_same_command_and_leaves_nothing_behind(tmp_path):
    folder = tmp_path / "run"
    file = folder / "run.nc"
    for _ in range(2):
        process = command(folder)
        before = file.stat().st_mtime_ns if file.exists() else 0
        # Killed in the midst of its work: as soon as it has written once more.
        while process.poll() is None and not (file.exists() and file.stat().st_mtime_ns != before):
            time.sleep(0.005)
        assert process.poll() is None, process.communicate()
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        assert rmj.Run.load(folder).status is Status.INTERRUPTED
    process = command(folder)
    _, said = process.communicate()
    assert process.returncode == 0, said
    asked = rmj.load("two-link-transfer").replace(
        {"motion.0.duration": 12.0, "motion.1.duration": 12.0, "simulation.timestep": 2e-4}
    )
    assert same(rmj.Run.load(folder), rmj.simulate(asked))
    kinds = {"run.nc", "summary.json", "experiment.toml", "figure.svg", "figure.png"}
    assert {path.name for path in folder.iterdir()} == kinds
