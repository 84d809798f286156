"""Robots of MuJoCo Menagerie by name: from a local copy, and each way in which it can fail."""

import builtins
import importlib

import pytest

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.errors import RobotError
from resonance_mj.experiments.loading import for_robot
from resonance_mj.robots import menagerie, mjcf
from resonance_mj.robots.robot import build

NAME = "menagerie:franka_emika_panda"
ARM = """
<mujoco>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
      <body name="lower" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
        <site name="tool" pos="0.3 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def package():
    return pytest.importorskip("mujoco_menagerie")


@pytest.fixture
def copy(package, tmp_path, monkeypatch):
    """A local copy with one robot, laid out as in the Menagerie: NAME/MODEL.xml and a scene."""
    folder = tmp_path / "franka_emika_panda"
    folder.mkdir()
    (folder / "panda.xml").write_text(ARM)
    (folder / "panda_nohand.xml").write_text(ARM.replace("elbow", "wrist"))
    (folder / "scene.xml").write_text('<mujoco><include file="panda.xml"/></mujoco>')
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    return folder


@pytest.fixture
def alone(package, tmp_path, monkeypatch):
    """No local copy, an empty cache, and a place to download from where there is nothing."""
    monkeypatch.delenv("MENAGERIE_ROOT", raising=False)
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("MENAGERIE_BASE_URL", (tmp_path / "nothing").as_uri())


def test_a_name_means_the_robot_itself_in_the_local_copy_and_not_its_scene(copy):
    assert mjcf.find(NAME) == copy / "panda.xml"
    assert build(for_robot(NAME)).joints == ("shoulder", "elbow")


def test_a_name_with_a_model_means_that_model(copy):
    assert build(for_robot(f"{NAME}/panda_nohand")).joints == ("shoulder", "wrist")


def test_an_experiment_keeps_the_name_and_runs_from_anywhere(copy, tmp_path, capsys):
    assert cli.main(["inspect", NAME, "--toml"]) == 0
    path = tmp_path / "arm.toml"
    path.write_text(capsys.readouterr().out)
    assert rmj.load(path).robot.mjcf == NAME
    assert rmj.load(path).name == for_robot(NAME).name == "menagerie-franka_emika_panda"
    assert len(rmj.optimum(rmj.load(path))) == 1


def test_without_the_package_the_error_says_how_to_install_it(monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(menagerie, "import_module", missing)
    with pytest.raises(RobotError, match=r'pip install "resonance-mj\[menagerie\]"') as caught:
        mjcf.find(NAME)
    assert NAME in str(caught.value)


def test_the_package_is_imported_only_for_a_robot_of_the_menagerie(monkeypatch):
    def refuse(name, *rest):
        assert name != "mujoco_menagerie"
        return imported(name, *rest)

    imported = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", refuse)
    monkeypatch.setattr(menagerie, "import_module", refuse)
    importlib.reload(mjcf)
    assert mjcf.find("two_link.xml").name == "two_link.xml"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("menagerie:panda", ["did you mean 'franka_emika_panda'?", "universal_robots_ur5e"]),
        ("menagerie:franka_emika_pnda", ["did you mean 'franka_emika_panda'"]),
        ("menagerie:", ["no robot", "''", "kuka_iiwa_14"]),
        (f"{NAME}/hand2", ["no model 'hand2'", "panda_nohand"]),
    ],
)
def test_an_unknown_name_exits_2_with_one_line_of_those_that_exist(alone, name, words, capsys):
    assert cli.main(["inspect", name]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    for word in (repr(name), *words):
        assert word in line


def test_a_failed_download_exits_2_and_says_how_to_use_a_local_copy(alone, capsys):
    assert cli.main(["inspect", NAME]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    for word in (NAME, "cannot be downloaded", "not found", "MENAGERIE_ROOT", "local copy"):
        assert word in line


def test_a_local_copy_without_the_robot_or_its_file_is_named(copy, capsys):
    for name, words in (
        ("menagerie:kuka_iiwa_14", ["kuka_iiwa_14", str(copy.parent)]),
        (f"{NAME}/mjx_panda", ["mjx_panda.xml", "no such file"]),
    ):
        assert cli.main(["inspect", name]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        for word in (*words, "MENAGERIE_ROOT"):
            assert word in line
