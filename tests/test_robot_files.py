"""What a robot's files say, and what MuJoCo says of them, is read whole and heard."""

import os
import subprocess
import sys
import threading
import zipfile

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.evaluation.inspection import inspect
from resonance_mj.experiments.loading import for_robot
from resonance_mj.robots import mjcf, source
from resonance_mj.robots.decompiling import spec_of
from resonance_mj.robots.robot import build
from resonance_mj.robots.warned import heard

ARM = """<mujoco>{head}<compiler angle="radian"/><option {option}/><worldbody>{scene}
<body name="upper" {upper}><joint name="shoulder" axis="0 1 0" {shoulder}/>
<geom name="link" type="capsule" fromto="0 0 0 .3 0 0" size=".02" {geom}/>
<body name="lower" pos=".3 0 0"><joint name="elbow" axis="0 1 0" range="-2 2" limited="true"/>
<geom type="capsule" fromto="0 0 0 .25 0 0" size=".02"/><site name="tool" pos=".25 0 0" {site}/>
</body></body></worldbody><actuator><motor name="drive" joint="shoulder" {drive}/>
<motor joint="elbow"/></actuator>
{rest}</mujoco>"""
NAMES = ("head", "option", "scene", "upper", "shoulder", "geom", "site", "drive", "rest")
PARTS = dict.fromkeys(NAMES, "")


def written(folder, name="arm.xml", **parts):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(ARM.format(**PARTS | parts), encoding="utf-8")
    return path


def refused(path):
    """The one line with which a robot is refused."""
    with np.errstate(all="raise"), pytest.raises(rmj.ResonanceError) as caught:
        build(for_robot(str(path)))
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    return message


# Numbers that are none


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"shoulder": 'damping="nan"'}, "joint 'shoulder': damping = 'nan'"),
        ({"shoulder": 'ref="inf"'}, "joint 'shoulder': ref = 'inf'"),
        ({"shoulder": 'range="-1 INF" limited="true"'}, "joint 'shoulder': range = '-1 INF'"),
        ({"geom": 'mass="nan"'}, "geom 'link': mass = 'nan'"),
        ({"geom": 'rgba="1 nan 0 1"'}, "geom 'link': rgba"),
        ({"site": 'quat="1 NaN 0 0"'}, "site 'tool': quat"),
        ({"drive": 'gear="-inf"'}, "motor 'drive': gear"),
        ({"option": 'gravity="0 0 nan"'}, "option: gravity"),
        ({"rest": '<keyframe><key name="up" qpos="0 nan"/></keyframe>'}, "key 'up': qpos"),
        ({"rest": '<visual><map znear="nan"/></visual>'}, "map: znear"),
    ],
)
def test_nan_and_infinity_are_named_by_file_and_element(tmp_path, parts, words):
    path = written(tmp_path, **parts)
    assert refused(path).startswith(f"{path}: {words}")


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"upper": 'pos="1e300 0 0"'}, "body 'upper': pos = 1e+300"),
        ({"upper": 'pos="1e18 0 0"'}, "body 'upper': pos = 1e+18"),
        ({"geom": 'mass="1e200"'}, "body 'upper': mass = 1e+200"),
        ({"shoulder": 'damping="1e300"'}, "joint 'shoulder': damping = 1e+300"),
        ({"shoulder": 'ref="1e300"'}, "joint 'shoulder': ref = 1e+300"),
        ({"shoulder": 'range="-1 1e300" limited="true"'}, "joint 'shoulder': range = 1e+300"),
        ({"scene": '<site name="far" pos="1e300 0 0"/>'}, "site 'far': pos = 1e+300"),
        ({"drive": 'gear="1e300" armature="1"'}, "actuator 'drive': gear = 1e+300"),
        ({"option": 'gravity="0 0 -1e300"'}, "option: gravity = [0.0, 0.0, -1e+300]"),
        ({"rest": '<keyframe><key name="home" qpos="0 1e300"/></keyframe>'}, "key 'home': qpos"),
    ],
)
def test_numbers_beyond_all_bounds_are_named_by_file_and_element(tmp_path, parts, words):
    path = written(tmp_path, **parts)
    message = refused(path)
    assert message.startswith(f"{path}: {words}")
    assert "1e+15 are valid" in message


def test_nan_in_an_included_file_is_named_by_that_file(tmp_path):
    path = written(tmp_path, rest='<include file="parts/more.xml"/>')
    (tmp_path / "parts").mkdir()
    part = tmp_path / "parts" / "more.xml"
    part.write_text('<mujoco><custom><numeric name="n" data="1 nan"/></custom></mujoco>')
    assert refused(path).startswith(f"{part}: numeric 'n': data = '1 nan'")


def test_a_joint_may_be_called_nan_or_inf(tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text().replace('"shoulder"', '"nan"').replace('"elbow"', '"inf"'))
    assert build(for_robot(str(path))).joints == ("nan", "inf")


@pytest.mark.parametrize("armature", ["0", "0.01"])
def test_two_joints_on_one_axis_are_refused_unless_their_motors_tell_them_apart(tmp_path, armature):
    twin = f'armature="{armature}"/><joint name="twin" axis="0 1 0"'
    driven = '<actuator><motor joint="twin"/></actuator>'
    path = written(tmp_path, shoulder=twin, rest=driven)
    if armature == "0":
        assert "joints 'shoulder' and 'twin' move the same masses" in refused(path)
    else:
        assert build(for_robot(str(path))).joints == ("shoulder", "twin", "elbow")


def test_names_that_are_not_utf_8_are_refused_and_comments_may_be(tmp_path):
    path = written(tmp_path, scene="<!-- drehgelenk -->")
    text = path.read_text()
    path.write_bytes(text.replace("drehgelenk", "Gelenk für").encode("latin-1"))
    assert build(for_robot(str(path))).joints == ("shoulder", "elbow")
    path.write_bytes(text.replace('"elbow"', '"grün"').encode("latin-1"))
    assert refused(path).endswith("which is not UTF-8: save it in UTF-8")


@pytest.mark.parametrize("letters", [300, 5000])
def test_names_of_any_length_and_letter_are_names(tmp_path, letters):
    path = written(tmp_path)
    name = "$\\bad$[red]肩" + "j" * letters
    path.write_text(path.read_text().replace('"shoulder"', f'"{name}"'), encoding="utf-8")
    assert build(for_robot(str(path))).joints == (name, "elbow")


def test_bodies_nested_too_deep_for_an_xml_reader_are_refused(tmp_path):
    path = written(tmp_path, scene="<body>" * 600 + "</body>" * 600)
    assert "nesting is too deep" in refused(path)


# What the file has and the law cannot use, and what it leaves out


def test_damping_that_mujoco_derives_from_springdamper_stays_when_the_spring_goes(tmp_path):
    path = written(tmp_path, shoulder='springdamper="0.5 1"')
    original = mujoco.MjModel.from_xml_path(str(path))
    robot = build(for_robot(str(path)))
    assert original.dof_damping[0] > 0
    assert robot.model.dof_damping[0] == original.dof_damping[0]
    assert not robot.model.jnt_stiffness.any()
    assert any("springs of shoulder" in note for note in robot.notes)


def test_a_site_of_the_file_may_be_called_as_the_one_that_is_added(tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text().replace('"tool"', '"resonance_mj_tool"'))
    robot = build(for_robot(str(path)).replace({"robot.tool": "lower"}))
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    np.testing.assert_array_equal(data.site_xpos[robot.site], data.body("lower").xpos)
    assert robot.tools[0].kind == "body"


HAND = """<body name="hand" pos=".25 0 0"><geom size=".02"/><site name="palm"/>
<body name="left" pos=".05 .01 0"><joint name="l" type="slide" axis="0 1 0"/><geom size=".02"/>
<site name="nail"/></body>
<body name="right" pos=".05 -.01 0"><joint name="r" type="slide" axis="0 1 0"/><geom size=".02"/>
</body></body>"""


def with_hand(folder, **parts):
    path = written(folder, **parts)
    text = path.read_text().replace('<site name="tool" pos=".25 0 0" />', HAND)
    path.write_text(text.replace(' range="-2 2" limited="true"', ""))
    return path


def test_what_could_be_the_tool_is_what_the_rule_that_finds_it_looks_among(tmp_path):
    found = inspect(for_robot(str(with_hand(tmp_path))))
    assert [tool.name for tool in found.tools] == ["hand", "palm", "lower"]
    given = inspect(for_robot(str(with_hand(tmp_path))).replace({"robot.tool": "palm"}))
    assert [tool.name for tool in given.tools] == ["palm", "lower", "hand"]


def test_fingers_that_touch_each_other_where_they_are_held_are_in_no_pose_s_way(tmp_path):
    """The best pose of all without the ceiling goes through it."""
    ceiling = '<geom type="plane" size="1 1 1" pos="0 0 .2" zaxis="0 0 -1"/>'
    robot = build(for_robot(str(with_hand(tmp_path, scene=ceiling))))
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.qpos
    mujoco.mj_forward(robot.model, data)
    assert data.ncon == 0


def test_an_arm_is_compiled_twice(tmp_path, monkeypatch):
    """As its author wrote it, and as the law drives it; also where bodies are held in frames."""
    compiled = mujoco.MjSpec.compile
    calls = []

    def counting(spec, *rest):
        calls.append(spec)
        return compiled(spec, *rest)

    monkeypatch.setattr(mujoco.MjSpec, "compile", counting)
    held = '<frame pos="1 0 0" euler="0 .5 0"><body><freejoint/><geom size=".1"/></body></frame>'
    path = written(tmp_path, scene=held)
    robot = build(for_robot(str(path)).replace({"motion.0.payload": 1.5}))
    assert len(calls) == 2
    assert robot.carrying(1.5) is robot.carrying(1.5)
    assert robot.carrying(0.0) is robot


VISUALS = """<asset><texture name="t" type="2d" builtin="flat" width="4" height="4"/>
<material name="steel" texture="t"/></asset>"""


def test_visuals_that_the_file_s_compiler_would_drop_are_kept_and_change_no_motion(tmp_path):
    shell = 'material="steel"/><geom name="shell" size=".05" contype="0" conaffinity="0"'
    kept, dropped = (
        build(for_robot(str(written(tmp_path, head=head + VISUALS, geom=shell)))).model
        for head in ("", '<compiler discardvisual="true"/>')
    )
    assert dropped.ngeom == kept.ngeom == 3
    assert dropped.nmat == dropped.ntex == 1
    np.testing.assert_array_equal(dropped.body_inertia, kept.body_inertia)


URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
<inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="../meshes/upper.obj"/></geometry></visual>
<visual><geometry><mesh filename="../meshes/gone.obj"/></geometry></visual>
<visual><geometry><mesh filename="../meshes/other.dae"/></geometry></visual></link>
<link name="lower"><inertial><origin xyz="0.2 0 0"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><sphere radius="0.1"/></geometry></visual></link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
<origin xyz="0.4 0 0"/><axis xyz="0 1 0"/></joint></robot>"""
CORNERS = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def mesh(path, size=0.1):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(CORNERS.format(size))
    return path


def urdf(folder):
    path = folder / "robot" / "arm.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(URDF)
    mesh(folder / "meshes" / "upper.obj")
    (folder / "meshes" / "other.dae").write_text("<COLLADA/>")
    return path


def test_a_urdf_is_seen_as_far_as_its_visuals_can_be_read(tmp_path):
    path = urdf(tmp_path)
    robot = build(for_robot(str(path)))
    assert robot.model.ngeom == 2
    assert robot.model.nmesh == 1
    original = mujoco.MjModel.from_xml_path(str(path))
    assert original.ngeom == 0
    np.testing.assert_array_equal(robot.model.body_mass[-2:], original.body_mass[-2:])
    path.write_text(URDF.replace("</robot>", "<xacro:unbound/></robot>"))
    assert build(for_robot(str(path))).model.ngeom == 0


# What MuJoCo warns of


CLOTH = """<flexcomp name="cloth" type="grid" count="3 3 1" spacing=".1 .1 .1" pos="3 3 3"
radius=".01" mass="1"><edge equality="true"/></flexcomp>"""


def command(folder, *arguments):
    line = [sys.executable, "-P", "-m", "resonance_mj.cli", *map(str, arguments)]
    paths = os.pathsep.join(filter(None, map(os.path.abspath, sys.path)))
    environment = os.environ | {"PYTHONPATH": paths}
    return subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True)


def test_a_warning_is_a_note_and_neither_a_log_file_nor_a_line_on_the_screen(tmp_path):
    path = written(tmp_path, scene=CLOTH)
    (note,) = (note for note in build(for_robot(str(path))).notes if "MuJoCo" in note)
    assert note.startswith("MuJoCo warns: flex 'cloth' is not rigid")
    done = command(tmp_path, "inspect", path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count(note) == 1
    assert list(tmp_path.iterdir()) == [path]


def test_what_mujoco_warns_of_while_robots_step_is_a_note_of_each_that_it_is_about(tmp_path):
    """One of a batch has no memory for its contacts: it steps in a thread that nobody hears."""
    tiny = written(tmp_path, "tiny.xml", head='<size memory="4K"/>', scene=FLOOR)
    roomy = written(tmp_path, "roomy.xml", head='<size memory="1M"/>', scene=FLOOR)
    small = {"motion.0.center": [0.45, -0.26], "motion.0.size": [0.01, 0.01]}
    changes = {"motion.0.duration": 2.0, "robot.home": [0.4, 0.3], **small}
    experiments = [for_robot(str(path)).replace(changes) for path in (tiny, roomy)]
    for runs in (rmj.simulate_many(experiments), list(map(rmj.simulate, experiments))):
        said = [[note for note in run.notes if "MuJoCo warns" in note] for run in runs]
        assert any("memory" in note for note in said[0])
        assert len(set(said[0])) == len(said[0])
        assert said[1] == []


FLOOR = '<geom name="floor" type="plane" size="1 1 1" pos="0 0 .0"/>'


def bad_step():
    model = mujoco.MjModel.from_xml_string(ARM.format(**PARTS))
    data = mujoco.MjData(model)
    data.qvel[:] = np.nan
    mujoco.mj_step(model, data)


def test_a_warning_is_heard_where_it_is_listened_for_and_the_user_s_handler_comes_back():
    mine = []
    mujoco.set_mju_user_warning(mine.append)
    try:
        with heard() as outer:
            with heard() as inner:
                bad_step()
                bad_step()
            others = threading.Thread(target=bad_step)
            others.start()
            others.join()
        assert len(inner) == 1
        assert "QVEL" in inner[0]
        assert "Time" not in inner[0]
        assert outer == mine == []
        bad_step()
        assert len(mine) == 1
    finally:
        mujoco.set_mju_user_warning(None)


# The files of a robot


def nested(folder):
    """An arm in a folder, what it includes below, and meshes above, below and beside that."""
    path = written(
        folder / "robot",
        head='<compiler meshdir="../meshes"/><include file="parts/assets.xml"/>',
        geom='/><geom type="mesh" mesh="a"/><geom type="mesh" mesh="b"/><geom type="mesh" mesh="c"',
    )
    parts = path.parent / "parts"
    parts.mkdir()
    (parts / "assets.xml").write_text(
        '<mujoco><asset><mesh name="a" file="a.obj"/><mesh name="b" file="b.obj"/></asset>'
        '<include file="deeper.xml"/></mujoco>'
    )
    (parts / "deeper.xml").write_text(
        '<mujoco><asset><mesh name="c" file="x/c.obj"/></asset></mujoco>'
    )
    made = [
        mesh(folder / "meshes" / "a.obj"),
        mesh(parts / "b.obj"),
        mesh(folder / "meshes/x/c.obj"),
    ]
    return path, [path, parts / "assets.xml", parts / "deeper.xml", *made]


def test_the_files_of_a_robot_are_all_that_mujoco_reads_it_from(tmp_path, monkeypatch):
    path, files = nested(tmp_path)
    assert source.files(path)[0] == path
    assert set(source.files(path)) == set(files)
    monkeypatch.chdir(tmp_path)
    relative = path.relative_to(tmp_path)
    assert set(source.files(relative)) == set(files)
    assert build(for_robot(str(relative))).model.nmesh == 3


def test_the_files_of_a_urdf_have_its_meshes_and_stripped_paths_lead_to_where_they_are(tmp_path):
    path = urdf(tmp_path)
    assert set(source.files(path)) == {path, tmp_path / "meshes" / "upper.obj"}
    stripped = written(
        tmp_path,
        head='<compiler strippath="true"/><asset><mesh name="a" file="c:/gone/a.obj"/></asset>',
        geom='/><geom type="mesh" mesh="a"',
    )
    there = mesh(tmp_path / "a.obj")
    assert set(source.files(stripped)) == {stripped, there}


def test_a_mesh_that_is_rewritten_within_a_second_is_read_anew(tmp_path):
    path = written(
        tmp_path,
        head='<asset><mesh name="a" file="a.obj"/></asset>',
        geom='/><geom type="mesh" mesh="a"',
    )
    masses = []
    for size in (0.1, 0.2):
        os.utime(mesh(tmp_path / "a.obj", size), (1, 1))
        masses.append(build(for_robot(str(path))).model.body("upper").mass[0])
    assert masses[1] > masses[0]


@pytest.mark.parametrize("ending", ["mjz", "zip"])
def test_an_archive_is_run_and_inspected_as_its_files_are(tmp_path, ending):
    path = written(tmp_path, rest='<include file="parts/more.xml"/>')
    mesh(tmp_path / "parts" / "more.xml").write_text("<mujoco><custom/></mujoco>")
    archive = tmp_path / f"arm.{ending}"
    with zipfile.ZipFile(archive, "w") as packed:
        for file in source.files(path):
            packed.write(file, file.relative_to(tmp_path))
    assert command(tmp_path, "inspect", archive).returncode == 0
    plain, packed = (build(for_robot(str(one))) for one in (path, archive))
    np.testing.assert_array_equal(plain.home, packed.home)
    np.testing.assert_array_equal(plain.inertia, packed.inertia)
    assert source.files(archive) == [archive]


def test_an_archive_is_never_unpacked_and_a_damaged_or_huge_one_is_refused(tmp_path, monkeypatch):
    hostile, inside = tmp_path / "a" / "arm.zip", ARM.format(**PARTS)
    hostile.parent.mkdir()
    with zipfile.ZipFile(hostile, "w") as packed:
        packed.writestr("model.xml", inside)
        packed.writestr("../evil.xml", inside)
        packed.writestr(str(tmp_path / "absolute.xml"), inside)
    assert build(for_robot(str(hostile))).joints == ("shoulder", "elbow")
    assert list(tmp_path.rglob("*")) == [hostile.parent, hostile]
    whole = hostile.read_bytes()
    monkeypatch.setattr(source, "LARGEST", 1000)
    assert "holds 0 MB" in refused(hostile)
    hostile.write_bytes(whole[: len(whole) // 2])
    assert "is no archive that can be read" in refused(hostile)
    hostile.write_bytes(b"PK")
    assert "is no archive that can be read" in refused(hostile)


def test_find_says_what_a_name_could_have_meant(tmp_path):
    with pytest.raises(rmj.ResonanceError, match=r"no such file.*two_link.xml"):
        mjcf.find(str(tmp_path))


def packaged(folder, mesh_at):
    """A URDF whose arm has a mesh in a package, for the eye and to touch."""
    shape = '<geometry><mesh filename="package://my_arm/meshes/upper.obj"/></geometry>'
    path = folder / "urdf" / "arm.urdf"
    path.parent.mkdir(parents=True)
    text = URDF.replace("../meshes/upper.obj", "package://my_arm/meshes/upper.obj")
    after = '</link>\n<link name="lower">'
    path.write_text(text.replace(after, f"<collision>{shape}</collision>{after}"))
    mesh(mesh_at / "meshes" / "upper.obj")
    return path


@pytest.mark.parametrize("place", ["own", "named by package.xml", "beside", "given", "ros", "deep"])
def test_a_package_is_found_around_the_file_in_given_roots_and_where_ros_looks(
    tmp_path, monkeypatch, place
):
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    root = tmp_path / {"own": "my_arm", "named by package.xml": "my_arm-main"}.get(place, "else")
    elsewhere = tmp_path / "ws" / "src" / ("deep/my_arm" if place == "deep" else "my_arm")
    where = {"beside": tmp_path / "my_arm"} | dict.fromkeys(("given", "ros", "deep"), elsewhere)
    path = packaged(root, where.get(place, root))
    if place.startswith("named"):
        (root / "package.xml").write_text("<package><name>my_arm</name></package>")
    if place == "ros":
        monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere{os.pathsep}{tmp_path / 'ws' / 'src'}")
    experiment = for_robot(str(path))
    if place in ("given", "deep"):
        with pytest.raises(rmj.ResonanceError, match=r"package://my_arm/.*robot.packages"):
            build(experiment)
        experiment = experiment.replace({"robot.packages": [str(tmp_path / "ws" / "src")]})
    robot = build(experiment)
    assert robot.model.nmesh == 1
    assert robot.model.ngeom == 3, "what is seen, what touches, and the sphere"
    assert len(source.files(path, experiment.robot.packages)) == 2


def test_a_urdf_keeps_its_efforts_as_limits_and_a_joint_that_mimics_follows(tmp_path):
    limits = '<limit lower="-2" upper="2" effort="{}" velocity="1"/>'
    text = URDF.replace("continuous", "revolute")
    text = text.replace(
        '<axis xyz="0 1 0"/></joint>\n', f'<axis xyz="0 1 0"/>{limits.format(30)}</joint>\n'
    )
    path = tmp_path / "arm.urdf"
    path.write_text(
        text.replace('"0 1 0"/></joint></robot>', f'"0 1 0"/>{limits.format(7)}</joint></robot>')
    )
    np.testing.assert_array_equal(build(for_robot(str(path))).torque_limit, [[-30, 30], [-7, 7]])
    path.write_text(path.read_text().replace("</joint></robot>", '<mimic joint="shoulder" '
                                             'multiplier="2"/></joint></robot>'))  # fmt: skip
    robot = build(for_robot(str(path)))
    assert any("elbow follows shoulder (+2)" in note for note in robot.notes)
    np.testing.assert_array_equal(robot.torque_limit, [[-30 - 2 * 7, 30 + 2 * 7]])


# Other forms of a robot than one file of text


def alike(one, other):
    """Whether two robots are the same arm."""
    assert one.joints == other.joints
    for field in ("home", "inertia", "jacobian", "torque_limit", "position"):
        np.testing.assert_allclose(getattr(one, field), getattr(other, field), atol=1e-12)


@pytest.mark.parametrize("form", ["mjb", "MjSpec", "MjModel", "folder", "scene", "named"])
def test_a_compiled_model_a_spec_and_a_folder_are_the_robot_that_they_hold(
    tmp_path, monkeypatch, form
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    home = '<keyframe><key name="home" qpos=".3 -.7"/></keyframe>'
    path = written(
        tmp_path / "robot", drive='ctrlrange="-3 3"', shoulder='damping=".4 .1"', rest=home
    )
    given = str(path.parent)
    if form == "mjb":
        given = str(tmp_path / "arm.mjb")
        mujoco.mj_saveModel(mujoco.MjModel.from_xml_path(str(path)), given)
    elif form == "MjSpec":
        given = mujoco.MjSpec.from_file(str(path))
    elif form == "MjModel":
        given = mujoco.MjModel.from_xml_path(str(path))
    elif form == "scene":
        scene = '<mujoco><include file="arm.xml"/></mujoco>'
        (path.parent / "scene.xml").write_text(scene)
    elif form == "named":
        written(tmp_path / "robot", "hand.xml")
        path.rename(path.with_name("robot.xml"))
        path = path.with_name("robot.xml")
    experiment = for_robot(given)
    alike(build(experiment), build(for_robot(str(path))))
    assert rmj.load("paper").replace({"robot.mjcf": given}).robot.mjcf == experiment.robot.mjcf
    assert rmj.Experiment(name="a", robot={"mjcf": given}).robot == experiment.robot
    run = rmj.simulate(experiment.replace({"motion.0.duration": 2.0}))
    assert run.status is not rmj.Status.DIVERGED
    assert len(inspect(experiment).joints) == 2


def test_a_compiled_model_is_taken_apart_whole(tmp_path):
    """The same accelerations, contacts included, of what is compiled anew from its parts."""
    more = (
        '<tendon><spatial name="rope" stiffness="9"><site site="tool"/><geom geom="bulb"/>'
        '<site site="peg"/></spatial>'
        '<fixed name="sum"><joint joint="elbow" coef="2"/></fixed></tendon>'
        '<equality><joint joint1="elbow" joint2="shoulder" polycoef="0 .5 0 0 0"/></equality>'
        '<actuator><muscle joint="elbow" lengthrange="-1 1"/><position tendon="sum" kp="3"/>'
        '<motor site="tool" refsite="peg" gear="1 0 0 0 0 0"/></actuator>'
        '<contact><exclude body1="upper" body2="ball"/></contact>'
    )
    mesh(tmp_path / "a.obj")
    path = written(
        tmp_path,
        head='<asset><mesh name="a" file="a.obj"/></asset>',
        scene=FLOOR + '<body name="ball" pos="0 0 .1"><freejoint/><geom size=".15"/></body>'
        '<site name="peg" pos="0 0 1"/><geom name="bulb" size=".1" pos="0 0 .6"/>',
        geom='/><geom type="mesh" mesh="a" pos=".1 0 0" euler=".1 .2 .3"',
        shoulder='stiffness="3 1" springref=".2" frictionloss=".1" ref=".1"',
        rest=more,
    )
    original = mujoco.MjModel.from_xml_path(str(path))
    again = spec_of(original, "arm").compile()
    found = []
    for model in (original, again):
        data = mujoco.MjData(model)
        rng = np.random.default_rng(3)
        data.qpos += 0.1 * rng.standard_normal(model.nq)
        data.qvel[:], data.ctrl[:] = rng.standard_normal(model.nv), 0.3
        mujoco.mj_forward(model, data)
        found.append((data.ncon, data.nefc, data.qacc))
    assert found[0][:2] == found[1][:2]
    assert found[0][0] > 0
    np.testing.assert_allclose(found[0][2], found[1][2], rtol=1e-6, atol=1e-6)


def test_a_damaged_or_incomplete_compiled_model_and_a_folder_of_several_robots_are_refused(
    tmp_path,
):
    (tmp_path / "arm.mjb").write_bytes(b"MJB" * 100)
    assert "arm.mjb: MuJoCo rejects it" in refused(tmp_path / "arm.mjb")
    path = written(tmp_path / "two", scene=CLOTH.replace("<edge equality='true'/>", ""))
    with heard():
        mujoco.mj_saveModel(mujoco.MjModel.from_xml_path(str(path)), str(tmp_path / "cloth.mjb"))
    assert "has flex, which cannot be taken out" in refused(tmp_path / "cloth.mjb")
    written(tmp_path / "two", "other.xml")
    assert "a folder with several robots" in refused(tmp_path / "two")


def test_an_inertia_that_no_body_can_have_becomes_the_nearest_possible_and_is_said(tmp_path):
    path = tmp_path / "arm.urdf"
    sane = 'ixx="0.01" iyy="0.02" izz="0.02"'
    path.write_text(URDF.replace(sane, 'ixx="-1e-9" iyy="0.02" izz="0.05"'))
    robot = build(for_robot(str(path)))
    assert any("inertias" in note and note.endswith(": lower") for note in robot.notes)
    np.testing.assert_allclose(robot.model.body("lower").inertia, [0.05, 0.035, 0.015], rtol=1e-3)
    path.write_text(URDF)
    assert not any("inertias" in note for note in build(for_robot(str(path))).notes)
