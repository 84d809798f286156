"""An arm's files: what they consist of, and numbers in them that no simulation can work with."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.evaluation.inspection import inspect
from resonance_mj.experiments.loading import for_robot
from resonance_mj.robots import source
from resonance_mj.robots.robot import build

LINKS = """<mujoco><option gravity="0 0 -9.8"/><worldbody><body name="upper">
<joint name="shoulder" axis="0 1 0" {shoulder}/>
<geom name="arm" type="capsule" fromto="0 0 0 .3 0 0" size=".02" {geom}/><body name="lower" pos=".3 0 0"><joint name="elbow" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .25 0 0" size=".02"/><site name="tool" pos=".25 0 {site}"/>{more}
</body></body></worldbody></mujoco>"""


def arm(folder, shoulder="", geom="", site="0", more=""):
    path = folder / "arm.xml"
    path.write_text(LINKS.format(shoulder=shoulder, geom=geom, site=site, more=more))
    return for_robot(str(path))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"shoulder": 'damping="nan"'}, ["joint 'shoulder'", "damping = nan"]),
        ({"shoulder": 'armature="1e300"'}, ["joint 'shoulder'", "armature = 1e+300"]),
        ({"site": "nan"}, ["site 'tool'", "pos = nan"]),
        ({"geom": 'mass="1e300"'}, ["body 'upper'", "mass = 1e+300"]),
    ],
)
def test_a_number_that_no_simulation_can_work_with_is_named(tmp_path, changes, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        rmj.simulate(arm(tmp_path, **changes))
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in ["arm.xml", *words] if word not in message] == []


def test_joints_that_nothing_tells_apart_are_named(tmp_path):
    twin = '<joint name="twin" axis="0 1 0"/>'
    text = LINKS.format(shoulder="", geom="", site="0", more="")
    path = tmp_path / "arm.xml"
    path.write_text(text.replace('<joint name="elbow"', f'{twin}<joint name="elbow"'))
    with pytest.raises(rmj.ResonanceError, match=r"'twin' and 'elbow' move the same masses"):
        build(for_robot(str(path)))


def test_damping_that_the_file_derives_from_its_springs_stays(tmp_path):
    experiment = arm(tmp_path, shoulder='springdamper="0.5 1"')
    (tmp_path / "plain").mkdir()
    written = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml")).dof_damping
    robot = build(experiment)
    assert written[0] > 0
    np.testing.assert_allclose(robot.model.dof_damping[robot.dof_address], written, rtol=1e-12)
    assert not robot.model.jnt_stiffness.any()


def test_a_grippers_fingers_are_no_tools(tmp_path):
    fingers = "".join(
        f'<body name="{name}"><joint type="slide" axis="0 1 0"/><geom size=".01"/></body>'
        for name in ("left", "right")
    )
    found = inspect(arm(tmp_path, more=fingers))
    assert found.tool.name == "tool"
    assert {tool.name for tool in found.tools} == {"tool", "lower"}


def test_a_site_called_as_the_one_that_is_added_is_no_obstacle(tmp_path):
    path = tmp_path / "arm.xml"
    text = LINKS.format(shoulder="", geom="", site="0", more="")
    path.write_text(text.replace('site name="tool"', 'site name="resonance_mj_tool"'))
    robot = build(for_robot(str(path)).replace({"robot.tool": "lower"}))
    assert robot.model.site(robot.site).name == "resonance_mj_tool_"


def test_every_file_of_a_robot_counts(tmp_path):
    folder = tmp_path / "robot"
    (folder / "parts").mkdir(parents=True)
    (tmp_path / "meshes").mkdir()
    mesh = tmp_path / "meshes" / "m.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    part = folder / "parts" / "links.xml"
    part.write_text(LINKS.format(shoulder="", geom="", site="0", more=""))
    main = folder / "arm.xml"
    main.write_text(
        '<mujoco><compiler meshdir="../meshes"/><include file="parts/links.xml"/>'
        '<asset><mesh name="m" file="m.obj"/></asset><worldbody><geom type="mesh" mesh="m" '
        'contype="0" conaffinity="0"/></worldbody></mujoco>'
    )
    assert source.files(main) == [main, *sorted((mesh, part))]
    digests = {source.digest(main)}
    for file in (main, part, mesh):
        file.write_text(file.read_text() + "\n")
        digests.add(source.digest(main))
    assert len(digests) == 4


@pytest.mark.parametrize("command", ["run", "inspect"])
def test_nothing_of_mujocos_own_appears_in_the_folder_or_on_the_screen(tmp_path, command):
    experiment = arm(tmp_path)
    options = ["--robot", experiment.robot.mjcf, "--motion.0.duration", "2", "--out", "out"]
    line = [sys.executable, "-P", "-m", "resonance_mj.cli", command]
    line += options if command == "run" else [experiment.robot.mjcf]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()


def test_what_mujoco_warns_of_is_heard_once():
    from resonance_mj.robots.warned import heard

    model = mujoco.MjModel.from_xml_path(str(library.robots()["two_link.xml"]))
    data = mujoco.MjData(model)
    with heard() as said:
        for _ in range(3):
            data.qvel[:] = np.nan
            mujoco.mj_step(model, data)
    assert len(said) == 1
    assert "Nan" in said[0]
