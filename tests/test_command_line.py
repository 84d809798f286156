"""What every command has: help, versions, JSON, silence, near misses, completion."""

import json
import re
import subprocess
import sys

import imageio.v3 as iio
import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import cli, library
from resonance_mj.cli.entry import COMMANDS
from resonance_mj.errors import ExperimentError

SHORT = ["--motion.0.duration=12", "--motion.1.duration=12"]


def said(capsys, *arguments):
    status = cli.main([str(one) for one in arguments])
    out, err = capsys.readouterr()
    return status, out, err


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    experiment = rmj.load("two-link-transfer")
    changes = {"motion.0.duration": 12.0, "motion.1.duration": 12.0}
    return rmj.simulate(experiment.replace(changes)).save(tmp_path_factory.mktemp("r") / "run")


@pytest.mark.parametrize("module", ["resonance_mj", "resonance_mj.cli"])
def test_the_module_is_the_program(module):
    line = [sys.executable, "-m", module, "--version"]
    done = subprocess.run(line, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(r"resonance-mj \d+\.\d+\.\d+\n", done.stdout)


def test_nothing_given_is_help(capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main([])
    out = capsys.readouterr().out
    assert not ended.value.code
    assert all(re.search(rf"\n    {name}\s", out) for name in COMMANDS)


def test_a_near_miss_of_a_command_an_option_or_a_key_is_named(capsys):
    assert "did you mean 'render'" in said(capsys, "rendr", "x")[2]
    assert "did you mean '--label'" in said(capsys, "render", "x", "--lable", "y")[2]
    assert "did you mean 'law.harmonics'" in said(capsys, "keys", "law.harmonix")[2]


def test_keys_are_found_by_words_of_name_and_meaning(capsys):
    _, out, _ = said(capsys, "keys", "null", "space", "--json")
    assert [row["key"] for row in json.loads(out)] == ["law.jacobian", "law.alpha_0"]


def test_names_are_listed_in_order_the_shorter_first(capsys):
    found = json.loads(said(capsys, "list", "--json")[1])
    assert list(found["runs"]) == sorted(library.experiments())
    assert "seven_joint.xml" in found["robots"]


def test_the_optimum_as_data_is_the_optimum(capsys):
    found = json.loads(said(capsys, "optimum", "paper", "--json")[1])
    for mine, best in zip(found["motions"], rmj.optimum(rmj.load("paper")), strict=True):
        np.testing.assert_array_equal(mine["stiffness"], best.stiffness)
        assert mine["torque_reduction"] == best.torque_reduction
    assert found["joints"] == ["joint1", "joint2"]


def test_a_run_as_data_is_its_summary_and_its_certificates(capsys, tmp_path):
    line = ("run", "two-link-transfer", *SHORT, "--certify", "--json", "--out", tmp_path)
    status, out, err = said(capsys, *line)
    found = json.loads(out)
    assert (status, err) == (0, "")
    held = [item for item in found.pop("certificates") if item["equation"] == "(12)"]
    assert [item["motion"] for item in held] == [1, 2]
    assert found == json.loads((tmp_path / "summary.json").read_text())


def test_certificates_checks_and_arms_as_data(capsys, folder, tmp_path):
    found = json.loads(said(capsys, "certify", folder, "--out", tmp_path, "--json")[1])
    assert {item["equation"] for item in found} >= {"(9)", "(12)", "(22)"}
    status, out, _ = said(capsys, "check", folder / "experiment.toml", "--json")
    judged = json.loads(out)
    assert status == (not all(one["passed"] for one in judged))
    assert all(one["run"] == "two-link-transfer" for one in judged)
    assert {one["figure"] for one in judged} >= {"tracking_rms", "stiffness"}
    arm = json.loads(said(capsys, "inspect", "two_link.xml", "--json")[1])
    assert [joint["name"] for joint in arm["joints"]] == ["joint1", "joint2"]
    assert arm["tool"]["name"] == "tool"


def test_quiet_prints_nothing_but_what_goes_wrong(capsys, tmp_path):
    line = ("two-link-transfer", "--out", tmp_path, "--quiet")
    assert said(capsys, "run", *line, *SHORT) == (0, "", "")
    status, out, err = said(capsys, "run", *line, "--motion.0.duration=1", "--motion.1.duration=1")
    assert (status, out, err.count("\n")) == (1, "", 1)


def test_a_warning_comes_before_notes_and_each_says_which_it_is(capsys, tmp_path):
    text = library.robots()["two_link.xml"].read_text()
    weak = text.replace('<motor name="motor1"', '<motor ctrlrange="-0.5 0.5" name="motor1"')
    (tmp_path / "weak.xml").write_text(weak)
    line = ("run", "paper", "--robot", tmp_path / "weak.xml", "--law.lead=1", "--out", tmp_path)
    _, out, _ = said(capsys, *line, "--motion.0.duration=1", "--motion.1.duration=1")
    notes = json.loads((tmp_path / "summary.json").read_text())["notes"]
    kinds = re.findall(r"^  (note|warning): ", out, re.MULTILINE)
    assert kinds.count("warning") >= 2
    assert len(kinds) == len(notes)
    assert any("warning: motion.0 asks joint1 for" in line for line in out.splitlines())


def test_completion_is_a_script_of_all_commands(capsys):
    status, out, _ = said(capsys, "completion", "bash")
    assert status == 0
    assert subprocess.run(["bash", "-n"], input=out, text=True).returncode == 0
    assert all(name in out for name in (*COMMANDS, "--certify"))


def test_an_arm_is_an_experiment_wherever_one_is_named(capsys, tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(library.robots()["two_link.xml"].read_text())
    spec = mujoco.MjSpec.from_file(str(path))
    named, of_spec, of_model = map(rmj.load, (path, spec, spec.compile()))
    for one in (named, of_spec, of_model):
        (best,) = rmj.optimum(one)
        assert best.torque_reduction == rmj.optimum(named)[0].torque_reduction
    found = json.loads(said(capsys, "optimum", path, "--json")[1])
    assert found["name"] == "arm"
    with pytest.raises(ExperimentError, match=r"5 is no arm: give a path, an MjSpec"):
        rmj.load(5)


def test_dir_shows_the_interface_and_help_lists_it():
    assert dir(rmj) == sorted(rmj.__all__)
    line = [sys.executable, "-c", "import resonance_mj; help(resonance_mj)"]
    text = subprocess.run(line, capture_output=True, text=True).stdout
    assert all(name in text for name in ("simulate_many(", "class Run", "optimum("))


def test_the_schema_is_json_of_every_key(capsys):
    found = json.loads(said(capsys, "schema")[1])
    law = found["$defs"]["Law"]["properties"]
    assert {"kind", "k_v", "eta", "gamma_qe"} <= set(law)
    assert found["additionalProperties"] is False
    assert {"robot", "task", "motion", "law", "springs", "expect"} <= set(found["properties"])


@pytest.mark.opengl
@pytest.mark.slow
def test_an_arm_is_drawn_into_a_folder_that_is_made(capsys, tmp_path):
    path = tmp_path / "new" / "arm.png"
    status, out, _ = said(capsys, "inspect", "two_link.xml", "-o", path)
    assert status == 0
    assert out.splitlines()[-1] == str(path)
    picture = iio.imread(path)
    assert picture.shape == (720, 1280, 3)
    red, green, blue = np.moveaxis(picture.astype(int), -1, 0)
    assert ((red - blue > 60) & (green - blue > 30)).sum() > 500, "springs that push, in amber"
    assert ((blue - red > 60) & (green - red > 30)).sum() > 100, "the tool's way, in blue"


def test_a_picture_of_an_arm_in_no_known_format_is_refused(capsys, tmp_path):
    status, _, err = said(capsys, "inspect", "two_link.xml", "-o", tmp_path / "arm.tiff")
    assert (status, list(tmp_path.iterdir())) == (2, [])
    assert "'.tiff'" in err
