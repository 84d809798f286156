"""The inspection of an arm: its numbers in closed form, its units, and the file that it writes."""

import numpy as np
import pytest
import two_link

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.evaluation.inspection import inspect
from resonance_mj.experiments.loading import for_robot
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots.robot import build

SERVOS = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" range="-2 2" damping="0.3"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03"/>
      <body name="lower" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0" damping="0.1"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/>
        <site name="camera"/>
        <body name="flange" pos="0.3 0 0"><geom size="0.02"/><site name="tcp"/></body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="a" joint="shoulder" kp="500" forcerange="-30 25"/>
    <position name="b" joint="elbow" kp="200" gear="2" forcerange="-0.1 0.1"/>
  </actuator>
  <keyframe>
    <key name="home" qpos="-0.5 1.2"/>
    <key name="raised" qpos="-1.0 1.5"/>
  </keyframe>
</mujoco>
"""

LIFT = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="carriage">
      <joint name="lift" type="slide" axis="0 0 1" range="-0.4 0.6" damping="7"/>
      <inertial pos="0 0 0" mass="3" diaginertia="0.1 0.1 0.1"/>
      <body name="boom" pos="0.1 0 0">
        <joint name="swing" axis="0 0 1" damping="0.2"/>
        <inertial pos="0.2 0 0" mass="2" diaginertia="0.02 0.02 0.03"/>
        <site name="tool" pos="0.5 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="lift" ctrlrange="-90 90"/><motor joint="swing"/></actuator>
  <keyframe><key name="home" qpos="0.1 0.3"/></keyframe>
</mujoco>
"""


@pytest.fixture(scope="module")
def paper():
    return inspect(for_robot("two_link.xml"))


@pytest.fixture
def servos(tmp_path):
    path = tmp_path / "servos.xml"
    path.write_text(SERVOS)
    return path


@pytest.fixture
def lift(tmp_path):
    path = tmp_path / "lift.xml"
    path.write_text(LIFT)
    return path


def command(capsys, *arguments):
    status = cli.main(["inspect", *map(str, arguments)])
    return status, *capsys.readouterr()


def test_inertia_damping_and_reach_are_those_of_the_papers_arm(paper):
    q = np.array([joint.home for joint in paper.joints])
    inertia = [joint.inertia for joint in paper.joints]
    assert np.allclose(inertia, np.diag(two_link.inertia(q)), rtol=1e-12)
    assert [joint.damping for joint in paper.joints] == list(two_link.D)
    assert np.isclose(paper.reach, two_link.L1 + two_link.L2, rtol=1e-12)
    assert all(joint.range is None and joint.share == 0.0 for joint in paper.joints)


def test_peak_speed_and_torque_are_those_of_the_papers_equations_of_motion(paper):
    experiment = for_robot("two_link.xml")
    (joints,) = plan_for(experiment).joints
    torque = two_link.inverse_dynamics(joints.q, joints.dq, joints.ddq)
    peaks = [(joint.peak_speed, joint.peak_torque) for joint in paper.joints]
    assert np.allclose(peaks, np.abs([joints.dq, torque]).max(axis=1).T, rtol=1e-6)
    assert paper.torque_reduction == rmj.optimum(experiment)[0].torque_reduction


def test_the_conditioning_is_the_jacobians_ratio_of_singular_values_along_the_motion(paper):
    q = build(paper.experiment).home
    first, both = q[0], q[0] + q[1]
    far = two_link.L2 * np.array([-np.sin(both), np.cos(both)])
    near = two_link.L1 * np.array([-np.sin(first), np.cos(first)])
    at_home = 1 / np.linalg.cond(np.stack([near + far, far], axis=1))
    assert len(paper.conditioning) == 1000
    # The ellipse is about the tool at home, so that home lies between its extremes.
    assert paper.conditioning.min() < at_home < paper.conditioning.max()


def test_motor_limits_are_those_of_position_servos_through_their_gears(servos):
    shoulder, elbow = inspect(for_robot(str(servos))).joints
    assert (shoulder.torque_limit, elbow.torque_limit) == ((-30.0, 25.0), (-0.2, 0.2))
    assert shoulder.share == shoulder.peak_torque / 25.0
    assert (shoulder.range, elbow.range) == ((-2.0, 2.0), None)


def test_the_tools_are_the_named_sites_and_bodies_of_the_longest_chain(servos):
    found = inspect(for_robot(str(servos)))
    names = [(tool.name, tool.kind, tool.body) for tool in found.tools]
    assert names == [
        ("tcp", "site", "flange"),
        ("camera", "site", "lower"),
        ("lower", "body", "lower"),
        ("flange", "body", "flange"),
    ]
    assert (found.tool.name, found.tool_reason) == ("tcp", "found by its usual name")
    given = inspect(for_robot(str(servos)).replace({"robot.tool": "flange"}))
    assert (given.tool.name, given.tool.kind, given.tool_reason) == ("flange", "body", "given")


def test_the_fingers_of_a_gripper_are_no_tools_and_the_sites_of_its_hand_are(servos):
    fingers = """<site name="palm"/>
      <body name="left"><joint name="l" type="slide" axis="0 1 0"/><geom size="0.01"/></body>
      <body name="right"><joint name="r" type="slide" axis="0 1 0"/><geom size="0.01"/></body>"""
    servos.write_text(
        SERVOS.replace('<site name="tcp"/>', fingers)
        .replace("-0.5 1.2", "-0.5 1.2 0 0")
        .replace("-1.0 1.5", "-1.0 1.5 0 0")
    )
    found = inspect(for_robot(str(servos)))
    assert {tool.name for tool in found.tools} == {"palm", "camera", "lower", "flange"}
    assert found.tool == found.tools[0]


def test_a_motor_that_is_too_weak_is_in_the_notes(servos):
    quick = [{"duration": 5.0, "period": 0.5, "size": [0.1, 0.1]}]
    notes = inspect(for_robot(str(servos)).replace({"motion": quick})).notes
    assert any("asks elbow for" in note and "motor gives 0.2" in note for note in notes)


@pytest.mark.parametrize("robot", ["two_link.xml", "scara.xml", "servos"])
def test_the_file_that_toml_prints_holds_what_would_be_found_without_it(
    robot, servos, tmp_path, capsys
):
    robot = str(servos) if robot == "servos" else robot
    status, text, said = command(capsys, robot, "--toml")
    assert (status, said) == (0, "")
    path = tmp_path / "elsewhere" / "arm.toml"
    path.parent.mkdir()
    path.write_text(text)
    loaded, plain = rmj.load(path), for_robot(robot)
    assert loaded == inspect(plain).experiment
    given, found = build(loaded), build(plain)
    assert plan_for(plain).experiment.motion == loaded.motion
    assert (given.joints, given.axes) == (found.joints, found.axes)
    assert np.array_equal(given.home, found.home)
    assert np.array_equal(given.inertia, found.inertia)


def test_the_file_that_toml_prints_runs_to_the_same_result_as_the_robot_alone(tmp_path, capsys):
    path = tmp_path / "arm.toml"
    path.write_text(command(capsys, "two_link.xml", "--toml")[1])
    short = {"motion.0.duration": 2.0}
    written = rmj.simulate(rmj.load(path).replace(short), interpret=True)
    alone = rmj.simulate(for_robot("two_link.xml").replace(short), interpret=True)
    assert written.status is alone.status
    for name in ("q", "tau", "stiffness", "offset"):
        assert np.array_equal(written.data[name], alone.data[name])


def test_the_comments_of_the_file_give_units_and_every_line_fits(capsys):
    text = command(capsys, "scara.xml", "--toml")[1]
    for words in ("shoulder [rad], elbow [rad], lift [m]", "[N m/rad]. [N/m] for slide", "T [s]"):
        assert words in " ".join(text.replace("\n#", "").split())
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert max(map(len, comments)) <= 100
    assert "if not given" not in text.replace("where beta is not given", "")


def test_a_slide_joint_is_told_in_metres_newtons_and_kilograms(lift, capsys):
    slide, hinge = inspect(for_robot(str(lift))).joints
    assert (slide.slides, hinge.slides) == (True, False)
    # What slides is the whole mass; what swings turns about its own axis.
    assert np.isclose(slide.inertia, 3.0 + 2.0)
    assert np.isclose(hinge.inertia, 0.03 + 2.0 * 0.2**2)
    assert (slide.torque_limit, slide.damping) == ((-90.0, 90.0), 7.0)
    status, text, said = command(capsys, lift)
    assert (status, said) == (0, "")
    hinges, slides = text.split("lift: slide joints")
    for unit in ("[rad]", "[N m s/rad]", "[kg m²]", "[N m]", "[rad/s]"):
        assert unit in hinges
    tables = slides.split("what could be the tool")[0]
    for unit in ("[m]", "[N s/m]", "[kg]", "[N]", "[m/s]"):
        assert unit in tables
    assert "rad" not in tables
    assert "N m" not in tables


def test_a_keyframe_or_angles_can_be_the_home(servos, capsys):
    status, text, _ = command(capsys, servos, "--home", "raised", "--toml")
    assert status == 0
    assert 'home = "raised"' in text
    status, text, _ = command(capsys, servos, "--home=-1.0,1.5", "--toml")
    assert status == 0
    assert "home = [-1.0, 1.5]" in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["MJCF"]),
        (["nothing.xml"], ["nothing.xml", "no such file", "two_link.xml"]),
        (["two_link.xml", "--tool", "hand"], ["robot.tool = 'hand'", "link2"]),
        (["two_link.xml", "--home", "1"], ["robot.home", "1 angles", "2 joints"]),
        (["two_link.xml", "--home", "up"], ["robot.home = 'up'", "keyframe", "home"]),
        (["two_link.xml", "--home=1,up"], ["robot.home", "valid number"]),
        (["two_link.xml", "--law.beta", "1"], ["law.beta"]),
    ],
)
def test_bad_input_exits_2_with_one_line(arguments, words, capsys):
    status, printed, said = command(capsys, *arguments)
    assert (status, printed) == (2, "")
    (line,) = said.splitlines()
    for word in words:
        assert word in line
