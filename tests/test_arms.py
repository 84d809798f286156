"""Which arm, tool and joints are meant in models of whole robots."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.evaluation.inspection import inspect
from resonance_mj.experiments.loading import for_robot
from resonance_mj.robots.names import usual
from resonance_mj.robots.robot import build

LINK = '<geom type="capsule" fromto="0 0 0 {x} 0 0" size=".01" mass="1"/>'


def link(name, joint, inside="", x=0.3, axis="0 1 0", kind="hinge", more=""):
    """A body on a joint, and what it carries at its far end."""
    return (
        f'<body name="{name}"><joint name="{joint}" type="{kind}" axis="{axis}" {more}/>'
        f'{LINK.format(x=x)}<frame pos="{x} 0 0">{inside}</frame></body>'
    )


def limb(side, end='<site name="{side}_tcp"/>'):
    end = end.format(side=side)
    elbow = link(f"{side}_lower", f"{side}_elbow", end)
    return link(f"{side}_upper", f"{side}_shoulder", elbow, axis="0 0 1")


def written(folder, world, rest="", name="robot.xml"):
    path = folder / name
    path.write_text(
        f'<mujoco><option><flag contact="disable"/></option><compiler angle="radian"/>'
        f"<worldbody>{world}</worldbody>{rest}</mujoco>"
    )
    return path


def built(path, **given):
    return build(for_robot(str(path)).replace({f"robot.{k}": v for k, v in given.items()}))


def humanoid(folder):
    """Floating, with two arms of two joints, legs of three and a neck, and a pose."""
    leg = "".join(
        f'<body name="{s}_leg"><joint name="{s}_hip" axis="1 0 0"/>{LINK.format(x=0.1)}'
        f"{link(f'{s}_shin', f'{s}_knee', link(f'{s}_foot', f'{s}_ankle'))}</body>"
        for s in ("left", "right")
    )
    arms = f'{limb("left")}<frame pos="0 1 0">{limb("right")}</frame>'
    neck = link("head", "neck", "<camera/>")
    pelvis = (
        f'<body name="pelvis"><freejoint name="root"/><geom size=".1"/>{arms}{leg}{neck}</body>'
    )
    key = f'<keyframe><key name="home" qpos="1 2 3 0 1 0 0 .1 .4 .2 .5 {"0 " * 7}"/></keyframe>'
    return written(folder, pelvis, key)


def test_a_floating_base_is_held_where_the_home_pose_has_it_and_said(tmp_path):
    path = humanoid(tmp_path)
    robot = built(path)
    original = mujoco.MjModel.from_xml_path(str(path))
    there, data = mujoco.MjData(original), mujoco.MjData(robot.model)
    mujoco.mj_resetDataKeyframe(original, there, 0)
    mujoco.mj_kinematics(original, there)
    data.qpos[:] = robot.qpos
    mujoco.mj_kinematics(robot.model, data)
    assert robot.model.nv == 2
    tool = robot.tools[0].name
    np.testing.assert_allclose(data.site(tool).xpos, there.site(tool).xpos, atol=1e-12)
    assert [note for note in robot.notes if "root" in note and "robot.base" in note]
    assert built(path, base="hold").joints == robot.joints


def test_of_several_arms_one_is_chosen_by_a_word_of_its_names_or_by_its_tool(tmp_path):
    path = humanoid(tmp_path)
    left, right = ("left_shoulder", "left_elbow"), ("right_shoulder", "right_elbow")
    assert built(path).joints == left, "an arm, though the legs have more joints"
    assert built(path, arm="right").joints == built(path, arm="Right_elb").joints == right
    assert built(path, arm="right_tcp").joints == built(path, tool="right_tcp").joints == right
    assert built(path, arm="foot").joints[-1].endswith("ankle")
    (said,) = [note for note in built(path).notes if note.startswith("arms: ")]
    for words in (
        "left_elbow (2 joints)",
        "right_elbow (2",
        "left_ankle (3",
        "robot.arm",
    ):
        assert words in said
    assert {"left_tcp", "right_tcp"} <= {tool.name for tool in built(path).tools}
    with pytest.raises(rmj.ResonanceError, match=r"robot.arm = 'third'.*right_elbow") as caught:
        built(path, arm="third")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "is_usual"),
    [
        *((name, True) for name in ("tool0", "left_tool0", "robot/ee_link", "EndEffector", "TCP")),
        *((name, True) for name in ("r:attachment_site", "finger-tip", "tool_tip", "gripper_tcp")),
        *((name, True) for name in ("eef_r", "robot0:grip", "pinch", "flange", "arm2_tip_1")),
        *((name, False) for name in ("link6", "tooling_plate", "coffee", "elbow", "tiptoe", "")),
    ],
)
def test_usual_names_are_found_behind_prefixes_in_any_case(name, is_usual):
    assert (usual(name) is not None) == is_usual


@pytest.mark.parametrize(
    ("end", "tool"),
    [
        ('<site name="a"/><site name="p_TCP" pos=".1 0 0"/>', "p_TCP"),
        ('<body name="wrist"><geom size=".01"/><site name="spot" pos=".1 0 0"/></body>', "spot"),
        ('<body name="tool0"/><site name="spot"/>', "tool0"),
        (
            '<body name="gripper_link"><body name="gripper_frame" pos=".1 0 0"/></body>',
            "gripper_frame",
        ),
        ('<site name="near" pos=".1 0 0"/><site name="out" pos=".2 0 0"/>', "out"),
        ('<body name="tip_"><site pos=".1 0 0"/></body>', "tip_"),
        ('<body name="plate"><site pos=".1 0 0"/></body>', "unnamed_site1"),
        ('<body name="flange"/><body name="cam_tool"><body name="tool_camera"/></body>', "flange"),
        ('<site name="wrist_camera"/><body name="plate"><geom size=".01"/></body>', "plate"),
    ],
)
def test_a_site_or_a_usual_name_is_the_tool_before_an_origin_and_no_camera_is(tmp_path, end, tool):
    path = written(tmp_path, limb("a", end.replace("{", "").replace("}", "")))
    assert built(path).tools[0].name == tool


@pytest.mark.parametrize(
    "jaw",
    [
        link("moving_jaw", "j3", x=0.05),
        link("part", "Gripper", x=0.05),
        link("part", "grip_slide", x=0.05, kind="slide", more='range="0 .05"'),
        link("f1", "a", link("f2", "b", x=0.02), x=0.02) + link("f3", "c", x=0.02),
    ],
)
def test_a_gripper_of_one_jaw_or_of_several_fingers_is_no_part_of_the_arm(tmp_path, jaw):
    robot = built(written(tmp_path, limb("a", jaw)))
    assert robot.joints == ("a_shoulder", "a_elbow")
    turned = link("gripper_link", "gripper_roll", '<site name="tcp" pos="0 .1 0"/>', axis="1 0 0")
    assert built(written(tmp_path, limb("a", turned))).n == 3


def base(inside):
    return (
        '<body name="cart"><joint name="x" type="slide" axis="1 0 0"/>'
        '<joint name="y" type="slide" axis="0 1 0"/><joint name="yaw" axis="0 0 1"/>'
        f'<geom size=".2"/>{inside}</body>'
    )


def test_a_mobile_base_s_joints_are_held_unless_they_are_asked_for(tmp_path):
    path = written(tmp_path, base(limb("a")))
    robot = built(path)
    assert robot.joints == ("a_shoulder", "a_elbow")
    assert any("x, y, yaw move the arm's base" in note for note in robot.notes)
    assert built(path, joints=["a_elbow", "x"]).joints == ("x", "a_elbow")
    with pytest.raises(rmj.ResonanceError, match=r"robot.joints = .*'z' is no joint .*x, y, yaw"):
        built(path, joints=["z"])


def test_the_axes_of_a_gantry_are_its_arm_s(tmp_path):
    hand = link("c", "z", '<site name="tcp"/>', axis="0 0 1", kind="slide")
    bridge = link("a", "x", link("b", "y", hand, kind="slide"), axis="1 0 0", kind="slide")
    assert built(written(tmp_path, bridge)).joints == ("x", "y", "z")


def test_joints_without_an_actuator_are_held_where_others_have_one_unless_asked_for(tmp_path):
    arm = limb("a", link("hand", "wrist", '<site name="tcp" pos=".1 0 0"/>'))
    free = built(written(tmp_path, arm))
    assert free.n == 3
    motors = "<motor joint='a_shoulder'/><motor joint='wrist'/>"
    path = written(tmp_path, arm, f"<actuator>{motors}</actuator>")
    robot = built(path)
    assert robot.joints == ("a_shoulder", "wrist")
    (said,) = [note for note in robot.notes if "a_elbow are turned by no actuator" in note]
    assert "robot.joints" in said
    assert built(path, joints=free.joints).joints == free.joints
    drive = "<tendon><fixed name='t'><joint joint='a_elbow' coef='2'/></fixed></tendon>"
    more = f"<actuator>{motors}<motor tendon='t'/></actuator>"
    assert built(written(tmp_path, arm, drive + more)).n == 3


def test_a_last_joint_that_cannot_move_the_tool_is_said_with_the_tools_that_exist(tmp_path):
    roll = link("hand", "roll", '<site name="tcp"/><site name="edge" pos="0 .1 0"/>', axis="1 0 0")
    path = written(tmp_path, limb("a", roll))
    (said,) = [note for note in built(path).notes if "roll cannot move" in note]
    assert "'tcp'" in said
    assert "edge" in said
    assert not any("cannot move" in note for note in built(path, tool="edge").notes)
    pole = '<body name="pole"><joint name="j" axis="0 1 0"/><geom size=".1"/></body>'
    bare = written(tmp_path, pole)
    with pytest.raises(rmj.ResonanceError, match=r"tool 'pole' cannot be moved.*robot.tool"):
        built(bare)


KEYS = (
    '<keyframe><key name="home" qpos="0 {home}"/><key name="bent" qpos="0 1"/>'
    '<key name="folded" qpos="0 2.5"/></keyframe>'
)


def ranged(folder, home):
    elbow = link("lower", "elbow", '<site name="tcp"/>', more='range="-2 2"')
    world = link("upper", "shoulder", elbow)
    return written(folder, world, KEYS.format(home=home))


@pytest.mark.parametrize("home", [2.0, 2.5])
def test_no_home_is_at_a_joint_s_limit_or_beyond(tmp_path, home):
    path = ranged(tmp_path, home)
    robot = built(path)
    assert abs(robot.home[1]) < 2
    (said,) = [note for note in robot.notes if note.startswith("home: found")]
    assert "not the keyframe 'home': joint elbow is at" in said
    assert any(note.endswith("bent, folded") for note in robot.notes), "all keyframes"
    for given in ("folded", (0.0, home)):
        with pytest.raises(rmj.ResonanceError, match=r"elbow is at 2.*range is -2 to 2"):
            built(path, home=given)
    np.testing.assert_array_equal(built(path, home="bent").home, [0, 1])
    np.testing.assert_array_equal(built(path, limits=False).home, [0, home])
    np.testing.assert_array_equal(built(ranged(tmp_path, 1.5)).home, [0, 1.5])


@pytest.mark.parametrize(
    "joints", [("yaw",), ("y", "yaw"), ("yaw", "a_shoulder", "a_elbow"), ("x",)]
)
def test_joints_of_one_body_of_which_some_are_held_move_as_in_the_file(tmp_path, joints):
    key = '<keyframe><key name="home" qpos=".4 -.3 .9 .2 .5"/></keyframe>'
    path = written(tmp_path, base(limb("a")), key)
    robot = built(path, joints=list(joints))
    original = mujoco.MjModel.from_xml_path(str(path))
    data, there = mujoco.MjData(robot.model), mujoco.MjData(original)
    for shift in (0.0, 0.6):
        mujoco.mj_resetDataKeyframe(original, there, 0)
        for joint in joints:
            there.joint(joint).qpos += shift
        data.qpos[:] = robot.qpos + shift
        mujoco.mj_kinematics(original, there)
        mujoco.mj_kinematics(robot.model, data)
        np.testing.assert_allclose(
            data.site("a_tcp").xpos, there.site("a_tcp").xpos, atol=1e-12, err_msg=str(shift)
        )


@pytest.mark.parametrize(
    "given", [{"arm": "right"}, {"joints": ["left_elbow", "left_shoulder"]}, {}]
)
def test_a_suggested_experiment_has_the_arm_that_was_found(tmp_path, given):
    path = humanoid(tmp_path)
    changes = {f"robot.{key}": value for key, value in given.items()}
    found = inspect(for_robot(str(path)).replace(changes))
    written_out = tmp_path / "found.toml"
    written_out.write_text(found.to_toml())
    again, robot = build(rmj.load(written_out)), built(path, **given)
    assert again.joints == robot.joints
    np.testing.assert_array_equal(again.home, robot.home)
    np.testing.assert_allclose(again.position, robot.position, atol=1e-15)


def test_the_task_is_in_the_coordinates_that_the_arm_is_good_at(tmp_path):
    """A pan and tilt beside the x axis moves in x only as it moves in z."""
    tilt = link("tilt", "j2", '<site name="tcp"/>')
    path = written(tmp_path, link("pan", "j1", tilt, axis="0 0 1", x=0.01))
    assert built(path, home=[0.02, 0.7]).axes == ("x", "y")
    assert built(path, home=[1.2, 0.7]).axes == ("x", "z")


PENDULUM = """<mujoco><worldbody><body name="bob" pos="0 0 2"><joint name="x" axis="1 0 0"/>
<joint name="y" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.25" size=".02"/></body>
</worldbody></mujoco>"""


def test_the_tool_of_a_pendulum_without_a_site_is_its_center_of_mass(tmp_path):
    """No joint moves the origin of its body."""
    (tmp_path / "arm.xml").write_text(PENDULUM)
    arm = for_robot(str(tmp_path / "arm.xml"))
    robot = build(arm)
    assert robot.tools[0].name == "com:bob"
    assert len(robot.axes) == 2
    assert any("whose origin no joint moves" in note for note in robot.notes)
    given = build(arm.replace({"robot.tool": "com:bob", "robot.home": robot.home.tolist()}))
    np.testing.assert_array_equal(given.position, robot.position)
    run = rmj.simulate(arm)
    assert (run.status, run.motions[0].verdict) == (rmj.Status.OK, "at optimum")
