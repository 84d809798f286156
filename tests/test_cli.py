"""The command line as a user meets it: real processes, files, exit statuses, one line on stderr."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import cli

SHORT = ["--motion.0.duration", "2", "--motion.1.duration=3"]


def resonance_mj(*arguments, cwd):
    command = [sys.executable, "-m", "resonance_mj.cli", *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A short run in an empty folder, shared by the tests that look at what it left."""
    folder = tmp_path_factory.mktemp("cli")
    return folder, resonance_mj("run", "paper", *SHORT, cwd=folder)


def test_run_writes_run_summary_experiment_and_figure_and_nothing_else(finished):
    folder, process = finished
    assert (process.returncode, process.stderr) == (0, "")
    assert sorted(path.name for path in (folder / "runs" / "paper").iterdir()) == [
        "experiment.toml",
        "figure.png",
        "figure.svg",
        "run.nc",
        "summary.json",
    ]
    assert [path.name for path in folder.iterdir()] == ["runs"]


def test_run_prints_progress_and_a_table_beside_the_optimum(finished):
    _, process = finished
    for words in ("5/5 cycles", "torque reduction [%]", "optimum", "stiffness joint2 [N m/rad]"):
        assert words in process.stdout


def test_the_summary_has_the_documented_keys_and_agrees_with_the_run(finished):
    folder, _ = finished
    summary = json.loads((folder / "runs" / "paper" / "summary.json").read_text())
    assert set(summary) == {
        "name", "status", "message", "notes", "versions", "steps", "simulation_wall_s", "segments",
    }  # fmt: skip
    assert set(summary["segments"][0]) == {
        "start_s", "end_s", "cycles", "torque_reduction", "torque_reduction_optimal",
        "torque_squared", "torque_squared_without_springs", "torque_squared_optimal",
        "tracking_rms", "stiffness", "stiffness_optimal", "offset", "offset_optimal",
        "cycles_to_optimum",
        *(f"{name}{of}" for name in ("electrical_power", "electrical_energy", "peak_torque")
          for of in ("", "_optimal", "_without_springs")),
    }  # fmt: skip
    assert [segment["cycles"] for segment in summary["segments"]] == [2, 3]
    run = rmj.Run.load(folder / "runs" / "paper")
    tau = run.data["tau"].sel(time=slice(3.9999, None)).values
    last = summary["segments"][1]
    assert np.isclose((tau**2).sum(axis=1).mean(), last["torque_squared"], rtol=1e-12)
    assert np.isclose(
        1 - last["torque_squared"] / last["torque_squared_without_springs"],
        last["torque_reduction"],
    )


def test_the_resolved_experiment_runs_again_to_the_same_numbers(finished, tmp_path):
    folder, _ = finished
    resolved = folder / "runs" / "paper" / "experiment.toml"
    assert "# mujoco " in resolved.read_text()
    again = rmj.simulate(rmj.load(resolved))
    first = rmj.Run.load(folder / "runs" / "paper")
    assert first.data.drop_attrs().equals(again.data.drop_attrs())


@pytest.mark.slow
def test_plot_draws_a_saved_run_again(finished, tmp_path):
    folder, _ = finished
    process = resonance_mj("plot", folder / "runs" / "paper", "--out", tmp_path / "new", cwd=folder)
    assert process.returncode == 0
    svg = (tmp_path / "new" / "figure.svg").read_text()
    for words in ("tool position x [m]", "stiffness k of joint1", "motor torque", "optimal"):
        assert words in svg


def test_an_option_on_the_command_line_is_the_same_as_a_key_in_python(finished):
    folder, _ = finished
    python = rmj.load("paper").replace({"motion.0.duration": 2.0, "motion.1.duration": 3.0})
    assert rmj.Run.load(folder / "runs" / "paper").experiment == python


def test_a_run_that_diverges_exits_1_says_why_and_keeps_what_was_recorded(tmp_path):
    process = resonance_mj("run", "paper", *SHORT, "--law.k_v", "1e5", "--out", "x", cwd=tmp_path)
    assert process.returncode == 1
    (line,) = process.stderr.splitlines()
    for words in ("diverged", "cycle 1", "joint", "try"):
        assert words in line
    run = rmj.Run.load(tmp_path / "x")
    assert run.status is rmj.Status.DIVERGED
    assert 0 < run.data.sizes["time"] < 1000
    assert np.isfinite(run.data["q"].values).all()
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "papr"], ["'papr'", "'paper'"]),
        (["run", "no/such.toml"], ["no/such.toml", "does not exist"]),
        (["run", "paper", "--law.bta", "3"], ["law.bta", "'beta'"]),
        (["run", "paper", "--law.beta"], ["--law.beta", "value must follow"]),
        (["run", "paper", "--law.k_v", "1,2,3"], ["law.k_v", "3 numbers", "x, z"]),
        (["run", "paper", "--robot.mjcf", "no.xml"], ["robot.mjcf = 'no.xml'", "two_link.xml"]),
        (["run", "paper", "--robot.tool", "tip"], ["robot.tool = 'tip'", "sites are: tool"]),
        (["run", "paper", "--robot.home", "up"], ["robot.home = 'up'", "keyframes are: home"]),
        (["run", "paper", "--robot.home", "1"], ["robot.home"]),
        (["run", "paper", "--motion.0.offset=-0.6,0"], ["motion.0", "reach 0.000 s", "50.0 mm"]),
        (["run", "paper", "--motion.0.offset=-0.5,0", "--motion.0.sin", "[[0.05],[0]]"],
         ["motion.0", "singular pose 0.750 s", "singular value"]),
        (["run", "paper", "--out", "taken"], ["taken", "cannot be written"]),
        (["plot", "nowhere"], ["nowhere", "no run"]),
        (["list", "--law.beta", "3"], ["--law.beta", "no keys"]),
        (["walk"], ["'walk'", "run"]),
        (["run"], ["NAME or PATH", "--robot"]),
        (["run", "paper", "--name"], ["--name", "value must follow"]),
        (["run", "paper", "--name", "a b"], ["name = 'a b'"]),
        (["run", "paper", "--name", "a" * 300], ["name = 'aaa", "at most 100"]),
        (["run", "paper", "--out", "a" * 300], ["aaa", "cannot be written"]),
        (["run", "a" * 300 + ".toml"], ["aaa", "File name too long", "paper"]),
        (["run", "paper", "--robot", "a" * 300 + ".xml"], ["aaa", "two_link.xml"]),
        (["run", "paper", "--law.kind", "a" * 300 + ".py"], ["aaa"]),
        (["plot", "a" * 300], ["aaa"]),
        (["run", "paper", "--out", "a\0b"], ["NUL byte"]),
        (["run", "\udcff.toml"], ["udcff.toml", "does not exist"]),
        (["run", "/dev/zero"], ["/dev/zero", "device"]),
        (["run", "."], ["is a folder", "paper"]),
        (["run", "paper", "--law.beta", "9" * 5000], ["law.beta = '999", "number"]),
        (["run", "paper", "--law.beta", "[" * 5000], ["law.beta = '[[[", "number"]),
        (["run", "paper", "--law.beta", "1\nx = 2"], ["law.beta = '1\\nx = 2'", "number"]),
        (["run", "paper", "--" + "a." * 20_000 + "b", "1"], ["nested too deeply"]),
        (["run", "paper", "--simulation.timestep", "1e-9"], ["1e+09 time steps", "8 to 100000"]),
        (["run", "paper", "--motion.0.duration", "1e9"], ["duration 1e+09 s", "up to 1000000"]),
        (["x" * 100_000], ["COMMAND", "run"]),
    ],
)  # fmt: skip
def test_bad_input_exits_2_with_one_line_and_leaves_nothing(
    arguments, words, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").touch()
    assert cli.main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert [word for word in words if word not in line] == []
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_a_list_of_one_number_is_typed_without_brackets_and_a_name_is_an_option(
    tmp_path, monkeypatch, capsys
):
    pendulum = """<mujoco><worldbody><body><joint axis="0 1 0" damping="0.1"/><geom type="capsule"
        fromto="0 0 0 0 0 -0.4" size="0.02"/><site name="tool" pos="0 0 -0.4"/></body></worldbody>
        </mujoco>"""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(pendulum)
    options = (
        "run --robot arm.xml --name 2 --robot.home 0.3 --task.coordinates x --motion.0.center -0.1 "
        "--motion.0.shape line --motion.0.duration 9"
    )
    assert cli.main(options.split()) == 0
    (folder,) = (tmp_path / "runs").iterdir()
    run = rmj.Run.load(folder)
    assert run.experiment.name == folder.name == "2"
    assert run.experiment.robot.home == (0.3,)
    assert run.experiment.motion[0].center == (-0.1,)


def test_a_command_in_a_folder_that_is_gone_says_so(tmp_path):
    gone = tmp_path / "gone"
    gone.mkdir()
    code = "import os, resonance_mj.cli as c; os.rmdir(os.getcwd()); exit(c.main(['run', 'paper']))"
    command = [sys.executable, "-c", code]
    process = subprocess.run(command, cwd=gone, capture_output=True, text=True)
    assert process.returncode == 2
    (line,) = process.stderr.splitlines()
    assert "No such file or directory" in line
    assert "the working folder" in line or "runs/paper" in line


def test_a_process_with_bad_input_says_one_line_and_exits_2(tmp_path):
    process = resonance_mj("run", "papr", cwd=tmp_path)
    assert process.returncode == 2
    assert process.stdout == ""
    (line,) = process.stderr.splitlines()
    assert line.startswith("resonance-mj: ")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<mujoco", ["arm.xml", "MuJoCo rejects it", "XML"]),
        ("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>", ["arm.xml", "mass"]),
        ("<mujoco><worldbody><site name='tool'/></worldbody></mujoco>", ["no joint moves"]),
        (
            "<mujoco><worldbody><body><freejoint name='float'/><geom size='1'/><site name='tool'/>"
            "</body></worldbody></mujoco>",
            ["'float'", "free joint", "hinge and slide"],
        ),
    ],
)
def test_a_robot_that_cannot_be_driven_is_refused_with_its_file_and_element(
    text, words, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(text)
    assert cli.main(["run", "paper", "--robot.mjcf", "arm.xml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert [word for word in words if word not in line] == []


def test_help_and_lists_answer_without_loading_a_simulator(tmp_path):
    code = (
        "import sys, resonance_mj.cli as c; "
        "sys.exit(c.main(sys.argv[1:]) or 'mujoco' in sys.modules)"
    )
    for arguments in (["list"], ["keys"]):
        process = subprocess.run(
            [sys.executable, "-c", code, *arguments], cwd=tmp_path, capture_output=True, text=True
        )
        assert process.returncode == 0, process.stderr
    assert "paper-centered" in resonance_mj("list", cwd=tmp_path).stdout
    assert "law.gamma_qe" in resonance_mj("keys", cwd=tmp_path).stdout


@pytest.mark.slow
def test_a_wheel_made_of_the_source_archive_works_outside_the_checkout(tmp_path):
    """The robots and experiments travel inside the package, and outputs in runs/ do not."""
    checkout = Path(__file__).parents[1]
    build = [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path / "dist"]
    subprocess.run(build, cwd=checkout, check=True, timeout=300, capture_output=True)
    (archive,) = (tmp_path / "dist").iterdir()
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    site = tmp_path / "site"
    subprocess.run([*pip, "--target", site, archive], check=True, timeout=300)
    inside = site / "resonance_mj" / "runs"
    assert {path.name for path in inside.iterdir() if path.is_dir()} == {"sweeps", "validation"}
    assert {path.name for path in (inside / "sweeps").iterdir()} == {
        "gains.toml",
        "robustness.toml",
        "stability.toml",
        "tempo.toml",
    }
    here = tmp_path / "empty"
    here.mkdir()
    for command, said in (["optimum", "paper"], "29.950"), (["check", "two-link-transfer"], "none"):
        process = subprocess.run(
            [site / "bin" / "resonance-mj", *command],
            cwd=here,
            env=os.environ | {"PYTHONPATH": str(site)},
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert process.returncode == 0, process.stderr
        assert said in process.stdout
