"""An author's MJCF becomes an arm: what is found, what is changed, what is refused."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.experiments.loading import for_robot
from resonance_mj.experiments.sections import Robot
from resonance_mj.robots import mjcf
from resonance_mj.robots.compiling import compile_spec
from resonance_mj.robots.robot import build

ARM = """<mujoco><worldbody>
<body name="base"><site name="right_center"/><geom size=".05"/>
<body name="upper"><joint name="shoulder" axis="0 1 0" range="-2 2" limited="true"{spring}/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
<body name="lower" pos=".3 0 0"><joint name="elbow" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .25 0 0" size=".02"/>{tool}
</body></body></body>{scene}</worldbody>{rest}</mujoco>"""


BOTH = {"robot.joints": ("shoulder", "elbow")}


def written(tmp_path, tool="", scene="", rest="", spring=""):
    path = tmp_path / "arm.xml"
    path.write_text(ARM.format(tool=tool, scene=scene, rest=rest, spring=spring))
    return path


def read(path, **given):
    arm = mjcf.read(Robot(mjcf=str(path), **given))
    return arm, compile_spec(arm.spec, path)


def test_a_usual_name_on_the_base_is_not_the_tool(tmp_path):
    arm, _ = read(written(tmp_path, tool="<site name='tcp' pos='.25 0 0'/>"))
    assert arm.site == "tcp"
    arm, model = read(written(tmp_path))
    assert model.body(model.site(arm.site).bodyid[0]).name == "lower"
    assert any("deepest of the longest chain" in note for note in arm.notes)


def test_a_body_can_be_the_tool(tmp_path):
    arm, model = read(written(tmp_path), tool="upper")
    assert arm.joints == ("shoulder",)
    assert model.body(model.site(arm.site).bodyid[0]).name == "upper"


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
    assert model.body(model.site(arm.site).bodyid[0]).name == "hand"
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
    robot = build(for_robot(str(path)).replace(BOTH))
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
        read(path, tool="tip")
    with pytest.raises(rmj.ResonanceError, match=r"'nose'.*right_center, tip.*upper, lower"):
        read(path, tool="nose")
    with pytest.raises(rmj.ResonanceError, match=r"robot.home = 'up': no such keyframe"):
        read(path, home="up")


def moved(path, arm, model):
    """How far bodies are from where the file's keyframe has them: of positions and orientations."""
    original = mujoco.MjModel.from_xml_path(str(path))
    before, after = mujoco.MjData(original), mujoco.MjData(model)
    key = next((i for i in range(original.nkey) if original.key(i).name.endswith("home")), None)
    if key is not None:
        mujoco.mj_resetDataKeyframe(original, before, key)
        after.qpos[:] = arm.home
    mujoco.mj_kinematics(original, before)
    mujoco.mj_kinematics(model, after)
    away = []
    for body in range(1, original.nbody):
        same = model.body(original.body(body).name).id
        away.append(np.abs(before.xpos[body] - after.xpos[same]).max())
        away.append(np.abs(before.xmat[body] - after.xmat[same]).max())
    return max(away)


def home(*qpos, more=""):
    return f'<keyframe><key name="home" qpos="{" ".join(map(str, qpos))}"{more}/></keyframe>'


SECOND_ARM = """<frame pos="1 0 1" euler="0 0 40"><frame euler="10 0 0">
<body name="left1" pos=".1 0 0" euler="0 25 0"><geom size=".05"/>
<joint name="a" axis="0 1 0" ref="20" pos="0 0 .1"/>
<body name="left2" pos="0 0 .2"><geom size=".05"/><joint name="b" type="slide" ref=".1"/></body>
</body></frame></frame>"""


@pytest.mark.parametrize(
    ("parts", "joints"),
    [
        ({"scene": SECOND_ARM, "rest": home(0.3, -0.7, 0.4, 0.2)}, "a, b"),
        ({"scene": SECOND_ARM}, "a, b"),
        (
            {
                "scene": '<body name="ball"><joint name="swing" type="ball"/><geom size=".1"/>'
                '<body name="bob" pos="0 0 1"><geom size=".1"/></body></body>',
                "rest": home(0.3, -0.7, 0.5, -0.5, 0.5, 0.5),
            },
            "swing",
        ),
        (
            {
                "scene": '<replicate count="2" offset="0 0 1"><body name="box" pos="3 0 0">'
                '<freejoint name="free"/><geom size=".1"/></body></replicate>'
            },
            "free0, free1",
        ),
        (
            {
                "scene": '<frame pos="1 1 1" euler="0 0 30"><body name="box"><geom size=".1"/>'
                '<freejoint name="free"/></body></frame>',
                "rest": home(0.3, -0.7, 1, 2, 3, 0.8, 0, 0.6, 0),
            },
            "free",
        ),
        (
            {
                "scene": '<body name="goal" mocap="true" pos="1 1 1"><geom size=".1"/></body>',
                "rest": "<equality><weld body1='goal' body2='lower'/></equality>"
                + home(0.3, -0.7, more=' mpos="2 1 0" mquat="0 1 0 0"'),
            },
            "",
        ),
    ],
    ids=["frames and ref", "no keyframe", "ball", "replicate", "free in a frame", "mocap"],
)
def test_what_is_off_the_arm_stands_exactly_where_the_home_pose_has_it(tmp_path, parts, joints):
    path = written(tmp_path, **parts)
    arm, model = read(path)
    assert arm.joints == ("shoulder", "elbow")
    assert model.nq == model.nv == 2
    assert moved(path, arm, model) < 1e-12
    assert not joints or f"held where the home pose has them: joints {joints}" in arm.notes


def test_an_arm_that_is_attached_to_a_scene_brings_its_keyframe_limits_and_gripper(tmp_path):
    force = '<actuator><position name="servo" joint="elbow" kp="9" forcerange="-3 3"/>'
    force += '<motor joint="shoulder"/>'
    written(tmp_path, tool=HAND, rest=GRIP.replace("<actuator>", force))
    path = tmp_path / "scene.xml"
    path.write_text(
        "<mujoco><asset><model name='sub' file='arm.xml'/></asset><worldbody>"
        "<body name='post' pos='0 0 1'><geom size='.1'/><frame pos='0 0 .2' euler='0 0 90'>"
        "<attach model='sub' body='base' prefix='right_'/></frame></body>"
        "</worldbody></mujoco>"
    )
    arm, model = read(path)
    assert arm.joints == ("right_shoulder", "right_elbow")
    np.testing.assert_array_equal(arm.home, [0.3, -0.7])
    np.testing.assert_array_equal(model.actuator("motor_right_elbow").ctrlrange, [-3, 3])
    assert moved(path, arm, model) < 1e-12


def test_the_keyframe_that_is_named_is_home(tmp_path):
    keys = '<keyframe><key name="home" qpos="1 1"/><key name="up" qpos="0.5 -1.5"/></keyframe>'
    path = written(tmp_path, rest=keys)
    np.testing.assert_array_equal(read(path)[0].home, [1, 1])
    np.testing.assert_array_equal(read(path, home="up")[0].home, [0.5, -1.5])


@pytest.mark.parametrize(
    ("joint", "actuators", "limit"),
    [
        ('actuatorfrcrange="-5 5"', "", (-5, 5)),
        ('actuatorfrcrange="-5 5"', "<motor joint='elbow' ctrlrange='-9 3'/>", (-5, 3)),
        (
            "",
            "<motor joint='elbow' gear='10' ctrlrange='-1 1' forcerange='-.5 .5'/>",
            (-5, 5),
        ),
        (
            "",
            "<motor joint='elbow' gear='-2' ctrlrange='-1 3'/>"
            "<position joint='elbow' kp='9' forcerange='-4 4'/>",
            (-10, 6),
        ),
        (
            "",
            "<motor joint='elbow' ctrlrange='-1 1'/><position joint='elbow' kp='9'/>",
            (-np.inf, np.inf),
        ),
        ("", "<muscle joint='elbow' lengthrange='-1 1'/>", (-np.inf, np.inf)),
        ("", "<intvelocity joint='elbow' kp='1' actrange='-1 1'/>", (-np.inf, np.inf)),
        ("", "<motor site='right_center' ctrlrange='-1 1'/>", (-np.inf, np.inf)),
        ("", "<adhesion body='lower' ctrlrange='0 1'/>", (-np.inf, np.inf)),
    ],
)
def test_a_joint_keeps_what_all_its_actuators_can_give(tmp_path, joint, actuators, limit):
    path = written(tmp_path, rest=f"<actuator>{actuators}</actuator>")
    path.write_text(path.read_text().replace('name="elbow"', f'name="elbow" {joint}'))
    robot = build(for_robot(str(path)).replace(BOTH))
    np.testing.assert_array_equal(robot.torque_limit[1], limit)
    assert robot.model.nu == 2
    assert robot.model.na == 0


def test_rotor_inertia_and_damping_of_an_actuator_stay_on_its_joint(tmp_path):
    servo = '<general joint="elbow" gear="3" armature=".1" damping=".5 .2 .1"/>'
    path = written(tmp_path, rest=f"<actuator>{servo}</actuator>")
    _, model = read(path, joints=BOTH["robot.joints"])
    forces = []
    for one in (mujoco.MjModel.from_xml_path(str(path)), model):
        data = mujoco.MjData(one)
        data.qvel[:] = 1.5, -2.0
        mujoco.mj_forward(one, data)
        inertia = np.zeros((2, 2))
        mujoco.mj_fullM(one, data, inertia)
        forces.append([*data.qfrc_passive, *inertia.ravel()])
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-14)


def test_default_classes_change_neither_the_motors_nor_the_tool(tmp_path):
    path = written(tmp_path)
    default = """<mujoco><default><joint stiffness="3 2" damping="1" range="-1 1" limited="true"/>
    <general gear="7" ctrlrange="-.2 .2" forcerange="-3 3" dyntype="filter" dynprm="1" delay=".02"
    nsample="20" armature="1"/><site pos="1 2 3" euler="1 2 3"/></default>"""
    path.write_text(path.read_text().replace("<mujoco>", default))
    arm, model = read(path)
    np.testing.assert_array_equal(model.site(arm.site).pos, 0)
    np.testing.assert_array_equal(model.site(arm.site).quat, [1, 0, 0, 0])
    assert not model.jnt_stiffness.any()
    assert not model.jnt_stiffnesspoly.any()
    np.testing.assert_array_equal(model.dof_damping, 1)
    assert not model.dof_armature.any()
    data = mujoco.MjData(model)
    data.ctrl[:] = 40.0, -50.0
    mujoco.mj_forward(model, data)
    np.testing.assert_array_equal(data.qfrc_actuator, [40, -50])


def test_what_a_file_switches_off_and_the_law_needs_is_switched_on(tmp_path):
    path = written(tmp_path, spring=' stiffness="4"')
    option = (
        "<mujoco><option actuatorgroupdisable='0'>"
        "<flag spring='disable' actuation='disable' contact='disable'/></option>"
    )
    path.write_text(path.read_text().replace("<mujoco>", option))
    arm, model = read(path)
    model.jnt_stiffness[:] = 2.0
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = 0.5, 3.0
    mujoco.mj_forward(model, data)
    np.testing.assert_array_equal(data.qfrc_actuator, 3)
    np.testing.assert_array_equal(data.qfrc_spring, -1)
    assert "switched on, the law needs them: springs, actuation" in arm.notes
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT


def test_gravity_compensation_is_noted_and_is_no_part_of_the_motors_torque(tmp_path):
    path = written(tmp_path)
    text = path.read_text().replace('name="lower"', 'name="lower" gravcomp="1"')
    path.write_text(text.replace('name="elbow"', 'name="elbow" actuatorgravcomp="true"'))
    arm, model = read(path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert not data.qfrc_actuator.any()
    assert data.qfrc_gravcomp[1]
    assert any(note.endswith("(gravcomp): lower") for note in arm.notes)


def test_elements_that_refer_to_what_is_taken_out_do_not_break_the_model(tmp_path):
    more = """<contact><exclude body1="left" body2="right"/><pair geom1="g" geom2="h"/></contact>
    <custom><tuple name="t"><element objtype="joint" objname="l"/>
    <element objtype="actuator" objname="fingers"/></tuple></custom>
    <sensor><jointpos joint="l"/><tendonpos tendon="grip"/><actuatorfrc actuator="fingers"/>
    <framepos objtype="body" objname="left"/></sensor>"""
    scene = '<geom name="h" size=".1" pos="3 3 3"/>'
    hand = HAND.replace('<geom size=".01"/></body>', '<geom name="g" size=".01"/></body>', 1)
    arm, model = read(written(tmp_path, tool=hand, rest=GRIP + more, scene=scene))
    assert arm.joints == ("shoulder", "elbow")
    assert model.nsensor == model.ntendon == model.neq == 0
    assert model.nexclude == model.npair == 1


def test_joints_and_bodies_without_names_get_some_that_are_free(tmp_path):
    path = tmp_path / "arm.xml"
    link = "<geom type='capsule' fromto='0 0 0 .3 0 0' size='.02'/>"
    path.write_text(
        f"<mujoco><worldbody><body><joint name='unnamed_joint2' axis='0 1 0'/>{link}"
        f"<body pos='.3 0 0'><joint axis='0 1 0'/>{link}</body></body></worldbody></mujoco>"
    )
    arm, model = read(path)
    assert arm.joints == ("unnamed_joint2", "unnamed_joint2_")
    assert model.body(model.site(arm.site).bodyid[0]).name == "unnamed_body3"


def test_bodies_that_the_compiler_would_fuse_keep_their_places(tmp_path):
    scene = "<body name='table' pos='2 0 0'><geom size='.1'/></body>"
    flange = "<body name='flange' pos='.25 0 0'><geom size='.01'/></body>"
    path = written(tmp_path, tool=flange, scene=scene)
    path.write_text(path.read_text().replace("<mujoco>", "<mujoco><compiler fusestatic='true'/>"))
    arm, model = read(path)
    assert model.body(model.site(arm.site).bodyid[0]).name == "flange"
    np.testing.assert_array_equal(model.body("table").pos, [2, 0, 0])


@pytest.mark.filterwarnings("ignore:flex 'cloth'")
def test_a_cloth_in_the_scene_is_not_the_arm(tmp_path):
    cloth = (
        "<flexcomp name='cloth' type='grid' count='3 3 1' spacing='.1 .1 .1' pos='3 3 3' "
        "radius='.01' mass='1'><edge equality='true'/></flexcomp>"
    )
    arm, model = read(written(tmp_path, scene=cloth))
    assert arm.joints == ("shoulder", "elbow")
    assert model.nv == 2


def test_a_tool_that_no_joint_moves_is_refused(tmp_path):
    with pytest.raises(rmj.ResonanceError, match="no joint moves the tool 'right_center'"):
        read(written(tmp_path), tool="right_center")


@pytest.mark.parametrize("overlap", [False, True])
def test_a_home_that_is_found_is_well_conditioned_and_free_where_it_can_be(tmp_path, overlap):
    path = written(
        tmp_path,
        tool="<site name='tcp' pos='.25 0 0'/>",
        scene="<geom name='floor' type='plane' size='1 1 1' pos='0 0 -.1'/>",
    )
    if not overlap:
        # The upper link no longer sits inside the base.
        path.write_text(path.read_text().replace('<geom size=".05"/>', '<geom size=".05" '
                        'contype="0" conaffinity="0"/>', 1))  # fmt: skip
    robot = build(for_robot(str(path)))
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.qpos
    mujoco.mj_forward(robot.model, data)
    assert data.ncon == 0
    jacobian = np.zeros((3, 2))
    mujoco.mj_jacSite(robot.model, data, jacobian, None, robot.site)
    assert np.linalg.cond(jacobian[[0, 2]]) < 4
    assert robot.axes == ("x", "z")


# What ties joints to each other, and what drives them otherwise than a motor at a joint

CRANK = (
    '<body name="crank" pos="0 0 .1"><joint name="c" axis="0 1 0"/><geom size=".02"/>'
    '<site name="pin" pos=".3 0 0"/></body>'
)


@pytest.mark.parametrize(
    ("constraint", "words"),
    [
        ("<joint joint1='elbow' joint2='shoulder' polycoef='0 1 .2'/>", "'elbow' and 'should"),
        ("<joint name='stuck' joint1='elbow'/>", "'stuck' between 'elbow' and 'a constant'"),
        ("<connect name='rod' body1='crank' body2='lower' anchor='.1 0 0'/>", "'crank' and 'lower"),
        ("<connect body1='lower' anchor='.1 0 0'/>", "'lower' and 'world'"),
        ("<weld site1='pin' site2='tip'/>", "'crank' and 'lower'"),
        ("<tendon tendon1='sum'/>", "'sum' and 'a constant'"),
    ],
)
def test_joints_that_are_tied_are_refused_unless_those_that_move_are_asked_for(
    tmp_path, constraint, words
):
    sum_of = "<tendon><fixed name='sum'><joint joint='elbow' coef='1'/><joint joint='shoulder' "
    sum_of += "coef='1'/></fixed></tendon>"
    tip = "<site name='tip' pos='.2 0 0'/>"
    rest = f"{sum_of}<equality>{constraint}</equality>"
    path = written(tmp_path, tool=tip, scene=CRANK, rest=rest)
    with pytest.raises(rmj.ResonanceError, match=r"constraint .*robot.joints") as caught:
        read(path)
    assert words in str(caught.value)
    arm, model = read(path, joints=("shoulder",))
    assert model.neq == 0
    assert any(note.startswith("taken out: equality constraints") for note in arm.notes)
    path.write_text(path.read_text().replace("<joint joint1", "<joint active='false' joint1"))
    if "joint1='elbow' joint2" in constraint:
        assert read(path)[0].joints == ("shoulder", "elbow")


def test_a_linkage_within_a_hand_ties_no_joint_of_the_arm(tmp_path):
    rest = "<equality><connect body1='left' body2='right' anchor='0 0 0'/></equality>"
    assert read(written(tmp_path, tool=HAND, rest=rest))[0].joints == ("shoulder", "elbow")


def test_what_becomes_of_each_actuator_is_said(tmp_path):
    tendons = (
        "<tendon><fixed name='t'><joint joint='elbow' coef='.02'/></fixed></tendon><actuator>"
        "<muscle name='biceps' joint='shoulder' lengthrange='-1 1'/><motor name='rope' tendon='t' "
        "ctrlrange='-50 50'/><position name='servo' joint='elbow' forcerange='-5 5'/>"
        "<position name='finger' joint='l'/></actuator>"
    )
    arm, _ = read(written(tmp_path, tool=HAND, rest=tendons))
    assert "replaced by torque motors, limits kept: actuators servo" in arm.notes
    (without,) = [note for note in arm.notes if "without limits" in note]
    assert without.endswith("biceps (a muscle), rope (a tendon)")
    assert any(note.endswith("turn no joint of the arm: actuators finger") for note in arm.notes)


@pytest.mark.parametrize("limit", ["ctrlrange='0 20'", "gear='-1' ctrlrange='0 20'"])
def test_a_motor_that_turns_its_joint_one_way_only_is_said_and_one_that_does_not_is_none(
    tmp_path, limit
):
    rest = f"<actuator><motor joint='shoulder'/><motor joint='elbow' {limit}/></actuator>"
    robot = build(for_robot(str(written(tmp_path, rest=rest))))
    assert sorted(np.abs(robot.torque_limit[1])) == [0, 20]
    assert [note for note in robot.notes if "elbow" in note and "one way only" in note]
    arm, _ = read(written(tmp_path, rest=rest.replace(limit, "gear='0'")))
    assert arm.joints == ("shoulder",)


def test_a_time_step_or_integrator_that_the_file_gives_is_kept_or_the_change_is_said(tmp_path):
    path = written(tmp_path)
    path.write_text(
        path.read_text().replace("<mujoco>", '<mujoco><option timestep=".005" integrator="RK4"/>')
    )
    experiment = for_robot(str(path))
    said = [note for note in build(experiment).notes if note.startswith("simulation.")]
    assert said == [
        "simulation.timestep is 0.001; the file has 0.005",
        "simulation.integrator is implicitfast; the file has RK4",
    ]
    asked = experiment.replace({"simulation.timestep": 1e-3, "simulation.integrator": "RK4"})
    assert not [note for note in build(asked).notes if note.startswith("simulation.")]
