"""Runs as files: whole or not at all, refused in one line where they are not as they were saved."""

import io
import json
import random
import shutil
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from test_simulation import assert_equal_to_the_last_bit, short

import resonance_mj as rmj
from resonance_mj import claim, files, library
from resonance_mj.errors import OutputError
from resonance_mj.experiments.loading import for_robot
from resonance_mj.results import storing

NAMES = ["experiment.toml", "run.nc", "summary.json"]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def run():
    paper = rmj.load("paper")
    return rmj.simulate(paper.replace({"motion.0.duration": 2.0, "motion.1.duration": 2.0}))


@pytest.fixture(scope="module")
def other(run):
    return rmj.simulate(run.experiment.replace({"law.beta": 5.0}))


def test_saved_run_is_loaded_as_it_was(run, tmp_path):
    loaded = rmj.Run.load(run.save(tmp_path / "deep" / "folder"))
    assert_equal_to_the_last_bit(loaded, run)
    assert (loaded.versions, loaded.notes) == (run.versions, run.notes)
    assert loaded.summary() == run.summary()
    assert json.loads((tmp_path / "deep/folder/summary.json").read_text()) == run.summary()
    written = rmj.load(tmp_path / "deep/folder/experiment.toml")
    assert written == run.experiment.replace(loaded.found)


@pytest.mark.parametrize("k_v", [2000.0, 1e9])
def test_diverged_run_is_saved_and_loaded_like_any_other(k_v, tmp_path):
    """Of a part of the first cycle, and of no time step at all."""
    run = rmj.simulate(short({"law.k_v": k_v}))
    assert run.data.sizes["cycle"] == 0
    loaded = rmj.Run.load(run.save(tmp_path / "run"))
    assert_equal_to_the_last_bit(loaded, run)
    assert loaded.summary() == run.summary()


def test_any_reader_of_netcdf_finds_variables_with_units_and_what_was_run(run, tmp_path):
    with xr.open_dataset(run.save(tmp_path) / "run.nc", engine="h5netcdf") as found:
        assert set(found.variables) == set(run.data.variables)
        assert all(found[name].attrs["units"] for name in found.variables)
        assert found.attrs["status"] == "ok"
        assert 'kind = "paper"' in found.attrs["experiment"]


def strict(text):
    def refused(constant):
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refused)


def test_summary_is_json_where_numbers_are_not_finite(run, tmp_path):
    data = run.data.copy(deep=True)
    data["tracking_rms"][:], data["torque_squared"][:] = np.nan, np.inf
    run.__class__(run.experiment, run.status, "", data, run.steps, np.nan).save(tmp_path)
    summary = strict((tmp_path / "summary.json").read_text())
    assert summary["simulation_wall_s"] is None
    assert summary["segments"][0]["tracking_rms"] is None
    assert summary["segments"][0]["torque_squared"] is None


def test_summary_and_run_agree_where_data_was_changed_after_its_figures_were_read(run, tmp_path):
    changed = replace(run, data=run.data.copy(deep=True))
    assert changed.summary() == run.summary()
    changed.data["torque_squared"][:] *= 2
    loaded = rmj.Run.load(changed.save(tmp_path))
    assert loaded.summary() == changed.summary() != run.summary()
    assert json.loads((tmp_path / "summary.json").read_text()) == loaded.summary()


# A run is saved whole, or not at all


@pytest.mark.parametrize("reality", ["", "lab"])
def test_the_experiment_as_it_was_run_holds_all_that_was_found_and_is_the_same_run(
    reality, tmp_path
):
    changes = {"motion.0.duration": 6.0} | ({"reality": reality} if reality else {})
    run = rmj.simulate(for_robot("six_joint.xml").replace(changes))
    written = rmj.load(run.save(tmp_path) / "experiment.toml")
    law = written.law
    assert (law.omega, law.eta, law.lead, law.harmonics) == (50.0 if reality else 100.0, 0.8, 1, 20)
    assert (law.jacobian, law.velocity, law.listens) == ("damped", "difference", True)
    assert (law.alpha, law.alpha_0) == (run.plan.gains.alpha, run.plan.gains.alpha_0)
    assert written.robot.home == tuple(run.plan.robot.home.tolist())
    assert (written.robot.tool, written.task.coordinates) == ("tool", ("x", "y", "z"))
    assert written.motion[0].size is not None
    again = rmj.simulate(written)
    for name in ("q", "tau", "stiffness", "torque_squared", "torque_squared_optimal"):
        np.testing.assert_array_equal(again.data[name], run.data[name], err_msg=name)
    loaded = rmj.Run.load(tmp_path)
    assert loaded.experiment == rmj.Run.load(loaded.save(tmp_path / "copy")).experiment.replace(
        {"robot.mjcf": loaded.experiment.robot.mjcf}
    )
    assert rmj.load(tmp_path / "copy" / "experiment.toml").law == law
    assert not [note for note in again.notes if "no effect" in note]


@pytest.mark.slow
def test_one_run_at_a_time_has_a_folder_and_the_other_is_told_so(tmp_path):
    folder = tmp_path / "run"
    command = [sys.executable, "-P", "-m", "resonance_mj.cli", "run", "two-link-transfer"]
    command += ["--out", str(folder)]
    with claim.claimed(folder):
        for more in ([], ["--checkpoint", "2"]):
            refused = subprocess.run([*command, *more], capture_output=True, text=True, check=False)
            assert refused.returncode == 2
            assert f"{folder}: another run is being written" in refused.stderr
    assert not folder.exists()
    many = [
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    ended = [(process.communicate()[1], process.returncode) for process in many]
    assert 0 in {status for _, status in ended}
    assert all(status == 0 or f"{folder}: another run is" in said for said, status in ended)
    assert rmj.Run.load(folder).status is rmj.Status.OK
    assert not [path.name for path in folder.iterdir() if path.name.startswith(".")]


def test_a_save_that_is_interrupted_between_its_files_leaves_the_run_before(run, other, tmp_path):
    run.save(tmp_path)
    replaced = []

    class Interrupted(type(Path())):
        def replace(self, target):
            if len(replaced) == 2:
                raise KeyboardInterrupt
            replaced.append(target)
            return super().replace(target)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(files, "Path", Interrupted)
        with pytest.raises(KeyboardInterrupt):
            other.save(tmp_path)
    assert len(replaced) == 2
    assert_equal_to_the_last_bit(rmj.Run.load(tmp_path), run)
    assert names(tmp_path) == NAMES


@pytest.mark.slow
def test_runs_saved_into_one_folder_at_once_leave_one_of_them_whole(run, other, tmp_path):
    failed = []

    def save(one):
        try:
            for _ in range(3):
                one.save(tmp_path)
                found = rmj.Run.load(tmp_path)
                whole = run if found.experiment == run.experiment else other
                assert found.data.identical(whole.data)
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=save, args=[one]) for one in (run, other, run, other)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failed == []
    assert names(tmp_path) == NAMES
    written, loaded = (tmp_path / "summary.json").read_text(), rmj.Run.load(tmp_path)
    assert written.splitlines() == json.dumps(loaded.summary(), indent=2).splitlines()
    assert rmj.load(tmp_path / "experiment.toml") == loaded.experiment.replace(loaded.found)


KILLED = """
import os, signal, sys
from resonance_mj import files, library
from resonance_mj.errors import OutputError
from resonance_mj.experiments.loading import for_robot
class Path(type(files.Path())):
    def replace(self, target):
        os.kill(os.getpid(), signal.SIGKILL)
files.Path = Path
files.write(sys.argv[1], {"run.nc": b"half"})
"""


def test_what_a_killed_process_left_is_removed_by_the_next_save(run, tmp_path):
    process = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], check=False)
    assert process.returncode == -signal.SIGKILL
    assert len(names(tmp_path)) == 1
    run.save(tmp_path)
    assert names(tmp_path) == NAMES


# What is read is what was saved, or refused in one line


@pytest.fixture(scope="module")
def saved(run, tmp_path_factory):
    return run.save(tmp_path_factory.mktemp("saved"))


def refusal(folder, capfd):
    """The one line with which a folder is refused; nothing else is said."""
    with pytest.raises(rmj.errors.OutputError) as caught:
        rmj.Run.load(folder)
    line = str(caught.value)
    assert line.startswith(f"{folder / 'run.nc'}: ")
    assert line.isprintable()
    assert len(line) < 500 + len(str(folder))
    assert capfd.readouterr() == ("", "")
    return line


def test_a_file_that_is_cut_off_or_has_a_changed_byte_is_refused(saved, tmp_path, capfd):
    whole = (saved / "run.nc").read_bytes()
    chance = random.Random(0)
    for _ in range(100):
        at = chance.randrange(len(whole))
        (tmp_path / "run.nc").write_bytes(whole[:at])
        assert "is cut off" in refusal(tmp_path, capfd)
        flipped = bytearray(whole)
        flipped[at] ^= 1 << chance.randrange(8)
        (tmp_path / "run.nc").write_bytes(flipped)
        assert "damaged, or was changed" in refusal(tmp_path, capfd) or at >= len(whole) - 130


def group(file, name):
    del file[name]
    file.create_group(name)


def put(file, name, **about):
    del file[name]
    file.create_dataset(name, **about)


def attribute(file, name, key, value):
    (file[name] if name else file).attrs[key] = value


def link(file, name, to):
    del file[name]
    file[name] = to


TEXT = [b"x", 5, -1, [1.0, 2.0], np.inf, "", "[]", "{}", "null", "x" * 100_000, h5py.Empty("f")]
CHANGES = [
    lambda file, name, chance: file.__delitem__(name),
    lambda file, name, chance: group(file, name),
    lambda file, name, chance: put(file, name, shape=(10**12,), chunks=(1000,), dtype="f8"),
    lambda file, name, chance: put(file, name, shape=(10**9, 10**6), dtype="f8"),
    lambda file, name, chance: put(
        file, name, shape=(10**8,), dtype="f8", chunks=(10**6,), compression="gzip"
    ),
    lambda file, name, chance: put(file, name, data=chance.choice([1.0, [1], ["a"], [[1.0]]])),
    lambda file, name, chance: put(file, name, data=np.zeros(3, chance.choice(["f4", "?", "V3"]))),
    lambda file, name, chance: put(
        file, name, shape=(9,), dtype="f8", external=[("/etc/passwd", 0, 72)]
    ),
    lambda file, name, chance: link(file, name, h5py.ExternalLink("/etc/passwd", "/x")),
    lambda file, name, chance: link(file, name, h5py.SoftLink("/nowhere")),
    lambda file, name, chance: link(file, name, h5py.SoftLink("/time")),
    lambda file, name, chance: attribute(
        file, name, chance.choice(["units", "scale_factor", "coordinates", "_FillValue"]),
        chance.choice(TEXT),
    ),
    lambda file, name, chance: attribute(
        file, "", chance.choice([*storing._About.model_fields]), chance.choice(TEXT)
    ),
    lambda file, name, chance: file.attrs.pop(chance.choice([*storing._About.model_fields])),
]  # fmt: skip


@pytest.mark.parametrize("sealed", [False, True], ids=["changed", "made to look whole"])
def test_a_changed_file_is_refused_before_any_memory_is_asked_for(saved, sealed, tmp_path, capfd):
    """Files of one change each; with the digest made anew, what it says must fit."""
    whole = (saved / "run.nc").read_bytes()
    before, chance = rmj.Run.load(saved), random.Random(1)
    for number in range(60 if sealed else 200):
        content = io.BytesIO(whole[: -len(storing._seal(b""))])
        with h5py.File(content, "r+") as file:
            name = chance.choice([*file])
            CHANGES[number % len(CHANGES)](file, name, chance)
        end = storing._seal(content.getvalue()) if sealed else whole[-len(storing._seal(b"")) :]
        (tmp_path / "run.nc").write_bytes(content.getvalue() + end)
        try:
            same = rmj.Run.load(tmp_path)
        except rmj.errors.OutputError:
            refusal(tmp_path, capfd)
        else:
            assert sealed
            assert capfd.readouterr() == ("", "")
            same.summary()
            for name in before.data.variables:
                assert same.data[name].dims == before.data[name].dims


# A folder that is sent to somebody

ARM = (library.robots()["two_link.xml"]).read_text(encoding="utf-8")
INCLUDING = """<mujoco><include file="parts/arm.xml"/></mujoco>"""


@pytest.fixture
def sent(tmp_path, monkeypatch):
    """The folder of a run of a user's arm, law and waypoints, moved; and the run."""
    home, away = tmp_path / "home", tmp_path / "away"
    (home / "parts").mkdir(parents=True)
    away.mkdir()
    monkeypatch.chdir(home)
    Path("mine.xml").write_text(INCLUDING)
    Path("parts/arm.xml").write_text(ARM)
    law = "def learn(u, stiffness, offset, center):\n    return u, stiffness + 1, offset, center\n"
    Path("mine.py").write_text(law)
    Path("points.csv").write_text("x,z\n-0.3,0.0\n-0.28,0.03\n-0.32,0.03\n")
    motion = [{"duration": 3.0, "shape": "csv", "file": "points.csv"}]
    experiment = for_robot("mine.xml").replace({"motion": motion, "law.kind": "mine.py"})
    run = rmj.simulate(experiment)
    run.save("run")
    shutil.move("run", away / "run")
    for name in ("mine.xml", "mine.py", "points.csv", "parts/arm.xml"):
        Path(name).unlink()
    monkeypatch.chdir(away)
    return away / "run", run


def test_a_folder_that_was_sent_is_opened_judged_and_run_again(sent):
    folder, run = sent
    loaded = rmj.Run.load("run")
    xr.testing.assert_identical(loaded.data, run.data)
    assert rmj.certify(loaded).items
    again = rmj.simulate(rmj.load(folder / "experiment.toml"))
    np.testing.assert_array_equal(again.data["q"], run.data["q"])
    np.testing.assert_array_equal(again.data["stiffness"], run.data["stiffness"])


def test_another_arm_of_that_name_is_not_taken_for_the_one_that_was_run(sent):
    folder, run = sent
    Path("mine.xml").write_text(ARM.replace('mass="', 'mass="1'))
    assert rmj.Run.load("run").plan.robot.inertia[0, 0] == run.plan.robot.inertia[0, 0]
    (copy,) = folder.glob("inputs-*/parts/arm.xml")
    copy.write_text(ARM.replace('mass="', 'mass="1'))
    with pytest.raises(OutputError, match=r"arm\.xml: was changed since the run was saved"):
        rmj.Run.load("run")


def test_opening_a_run_executes_nothing_of_it(sent):
    folder, _ = sent
    (law,) = folder.glob("inputs-*/law-mine.py")
    law.unlink()
    assert rmj.Run.load("run").data.sizes["cycle"] > 0


def test_a_robot_that_changed_before_its_run_was_saved_is_not_kept_as_if_it_were_the_one(tmp_path):
    arm = tmp_path / "arm.xml"
    arm.write_text(ARM)
    run = rmj.simulate(for_robot(str(arm)).replace({"motion.0.duration": 2.0}))
    arm.write_text(ARM.replace('mass="', 'mass="1'))
    loaded = rmj.Run.load(run.save(tmp_path / "run"))
    assert "changed since it was simulated" in loaded.notes[-1]
    assert not list((tmp_path / "run").glob("inputs-*"))


def test_a_run_saved_over_another_leaves_none_of_its_files(sent, run):
    folder, _ = sent
    (folder / "figure.png").write_bytes(b"of the run before")
    run.save(folder)
    assert names(folder) == NAMES
