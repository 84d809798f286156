"""An author's MJCF becomes an arm: what is found, what is changed, what is refused."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import mjcf
from resonance_mj.experiment import for_robot
from resonance_mj.robot import build

ARM = """<mujoco><worldbody>
<body name="base"><site name="right_center"/><geom size=".05"/>
<body name="upper"><joint name="shoulder" axis="0 1 0" range="-2 2" limited="true"{spring}/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
<body name="lower" pos=".3 0 0"><joint name="elbow" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .25 0 0" size=".02"/>{tool}
</body></body></body>{scene}</worldbody>{rest}</mujoco>"""


def written(tmp_path, tool="", scene="", rest="", spring=""):
    path = tmp_path / "arm.xml"
    path.write_text(ARM.format(tool=tool, scene=scene, rest=rest, spring=spring))
    return path


def read(path, tool=None, home=None):
    arm = mjcf.read(str(path), tool, home)
    return arm, mjcf.compile_spec(arm.spec, path)


def test_a_usual_name_on_the_base_is_not_the_tool(tmp_path):
    arm, _ = read(written(tmp_path, tool="<site name='tcp' pos='.25 0 0'/>"))
    assert arm.tool == "tcp"
    arm, model = read(written(tmp_path))
    assert model.body(model.site(arm.tool).bodyid[0]).name == "lower"
    assert any("deepest of the longest chain" in note for note in arm.notes)


def test_a_body_can_be_the_tool(tmp_path):
    arm, model = read(written(tmp_path), tool="upper")
    assert arm.joints == ("shoulder",)
    assert model.body(model.site(arm.tool).bodyid[0]).name == "upper"


HAND = """<body name="hand" pos=".25 0 0"><geom size=".02"/>
<body name="left"><joint name="l" type="slide" axis="0 1 0" range="0 .1"/><geom size=".01"/></body>
<body name="right"><joint name="r" type="slide" axis="0 1 0" range="-.1 0"/>
<geom size=".01"/></body>
</body>"""
GRIP = """<tendon><fixed name="grip"><joint joint="l" coef="1"/></fixed></tendon>
<equality><joint name="mirror" joint1="l" joint2="r"/></equality>
<actuator><position name="fingers" tendon="grip"/></actuator>
<keyframe><key name="home" qpos="0.3 -0.7 0.04 -0.02"/></keyframe>"""


def test_a_gripper_is_held_exactly_where_the_home_keyframe_has_it(tmp_path):
    path = written(tmp_path, tool=HAND, rest=GRIP)
    arm, model = read(path)
    assert arm.joints == ("shoulder", "elbow")
    assert model.body(model.site(arm.tool).bodyid[0]).name == "hand"
    original = mujoco.MjModel.from_xml_path(str(path))
    before, after = mujoco.MjData(original), mujoco.MjData(model)
    before.qpos[:] = original.key("home").qpos
    after.qpos[:] = arm.home
    mujoco.mj_kinematics(original, before)
    mujoco.mj_kinematics(model, after)
    for name in ("hand", "left", "right"):
        at = [data.xpos[m.body(name).id] for m, data in ((original, before), (model, after))]
        np.testing.assert_allclose(at[0], at[1], atol=1e-12)
    noted = " ".join(arm.notes)
    for words in ("joints l, r", "tendons grip", "equality constraints mirror", "fingers"):
        assert words in noted


def test_a_free_object_in_the_scene_is_held(tmp_path):
    box = "<body name='box' pos='1 1 0'><freejoint name='f'/><geom size='.1'/></body>"
    arm, model = read(written(tmp_path, scene=box))
    assert model.nv == 2
    assert any("joints f" in note for note in arm.notes)


@pytest.mark.parametrize(
    ("actuator", "limit"),
    [
        ("<motor joint='elbow' ctrlrange='-3 2'/>", (-3, 2)),
        ("<motor joint='elbow' gear='50' ctrlrange='-1 1'/>", (-50, 50)),
        ("<position joint='elbow' kp='100' forcerange='-7 7'/>", (-7, 7)),
        ("<velocity joint='elbow' kv='10' gear='2' forcerange='-7 7'/>", (-14, 14)),
        ("<position joint='elbow' kp='100' ctrlrange='-1 1'/>", (-np.inf, np.inf)),
        ("", (-np.inf, np.inf)),
    ],
)
def test_actuators_become_torque_motors_that_keep_their_limits(tmp_path, actuator, limit):
    path = written(tmp_path, rest=f"<actuator>{actuator}</actuator>")
    robot = build(for_robot(str(path)))
    np.testing.assert_array_equal(robot.torque_limit[1], limit)
    data = mujoco.MjData(robot.model)
    data.ctrl[robot.actuator_id[1]] = 1.5
    mujoco.mj_forward(robot.model, data)
    assert data.qfrc_actuator[robot.dof_address[1]] == 1.5


@pytest.mark.parametrize(
    "spring", [' stiffness="5"', ' stiffness="1 2"', ' stiffness="5" springyield="1"']
)
def test_springs_of_the_file_are_taken_off_with_a_note(tmp_path, spring):
    arm, model = read(written(tmp_path, spring=spring))
    assert not model.jnt_stiffness.any()
    assert not model.jnt_stiffnesspoly.any()
    assert any("springs of shoulder" in note for note in arm.notes)


def test_the_file_is_left_as_it_is(tmp_path):
    path = written(tmp_path, tool=HAND, rest=GRIP)
    before = path.read_bytes()
    build(for_robot(str(path)))
    assert path.read_bytes() == before


def test_limits_and_contacts_stay_on_unless_the_experiment_says_otherwise(tmp_path):
    path = written(tmp_path)
    flags = mujoco.mjtDisableBit
    on = build(for_robot(str(path))).model.opt.disableflags
    off = build(
        for_robot(str(path)).replace({"robot.limits": False, "robot.contacts": False})
    ).model.opt.disableflags
    for bit in (flags.mjDSBL_LIMIT, flags.mjDSBL_CONTACT):
        assert not on & bit
        assert off & bit


def test_a_home_that_is_found_is_the_same_each_time_and_within_the_limits(tmp_path):
    path = written(tmp_path)
    first, second = (build(for_robot(str(path))) for _ in range(2))
    np.testing.assert_array_equal(first.home, second.home)
    assert abs(first.home[0]) < 2
    assert any(note.startswith("home: found") for note in first.notes)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>", ["no hinge or slide joint"]),
        (
            "<mujoco><worldbody><body><joint type='ball' name='b'/><geom size='1'/>"
            "<site name='tip'/></body></worldbody></mujoco>",
            ["no hinge or slide joint"],
        ),
        ("<mujoco><include file='gone.xml'/></mujoco>", ["MuJoCo rejects it", "gone.xml"]),
        (
            "<mujoco><asset><mesh name='m' file='gone.stl'/></asset><worldbody><body>"
            "<joint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>",
            ["MuJoCo rejects it", "gone.stl"],
        ),
    ],
)
def test_a_file_without_a_usable_arm_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "arm.xml"
    path.write_text(text)
    with pytest.raises(rmj.ResonanceError) as caught:
        build(for_robot(str(path)))
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


def test_a_ball_joint_before_the_tool_and_an_unknown_tool_are_named(tmp_path):
    ball = "<body><joint name='wrist' type='ball'/><geom size='.02'/><site name='tip'/></body>"
    path = written(tmp_path, tool=ball)
    with pytest.raises(rmj.ResonanceError, match=r"'wrist'.*'tip' is a ball joint"):
        mjcf.read(str(path), "tip", None)
    with pytest.raises(rmj.ResonanceError, match=r"'nose'.*right_center, tip.*upper, lower"):
        mjcf.read(str(path), "nose", None)
    with pytest.raises(rmj.ResonanceError, match=r"robot.home = 'up': no such keyframe"):
        mjcf.read(str(path), None, "up")
