"""Joints that a file couples in proportion move together: one coordinate, one spring, one motor."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.experiments.loading import for_robot
from resonance_mj.motions.kinematics import JointMotion, Kinematics
from resonance_mj.robots.robot import build

PARALLEL = """<mujoco><compiler angle="radian"/><worldbody>
<body name="upper" pos="0 0 1"><joint name="shoulder" axis="0 -1 0" damping=".2" range="-2 2"/>
<geom type="capsule" fromto="0 0 0 .5 0 0" size=".03" mass="2"/>
<body name="lower" pos=".5 0 0"><joint name="elbow" axis="0 -1 0" damping=".1" range="{range}"/>
<geom type="capsule" fromto="0 0 0 .4 0 0" size=".02" mass="1"/><site name="tool" pos=".4 0 0"/>
</body></body></worldbody><equality>{equality}</equality>{rest}</mujoco>"""

OPPOSITE = '<joint joint1="elbow" joint2="shoulder" polycoef="0 -1 0 0 0"/>'


def written(tmp_path, equality=OPPOSITE, rest="", its_range="-2 2"):
    path = tmp_path / "arm.xml"
    path.write_text(PARALLEL.format(equality=equality, rest=rest, range=its_range))
    return str(path)


def test_an_arm_whose_second_link_stays_level_needs_the_torque_of_a_pendulum(tmp_path):
    robot = build(for_robot(written(tmp_path)).replace({"robot.home": [0.3]}))
    assert robot.joints == ("shoulder",)
    kinematics = Kinematics(robot)
    t = np.linspace(0, 2 * np.pi, 50, endpoint=False)[:, None]
    q, dq, ddq = 0.3 + 0.4 * np.sin(t), 0.4 * np.cos(t), -0.4 * np.sin(t)
    model = mujoco.MjModel.from_xml_path(written(tmp_path))
    upper, lower = (model.body(name) for name in ("upper", "lower"))
    # The lower link moves on a circle without turning: a point mass at the elbow, and no more.
    inertia = upper.inertia.max() + upper.mass * upper.ipos[0] ** 2 + lower.mass * 0.5**2
    weight = 9.81 * np.cos(q) * (upper.mass * upper.ipos[0] + lower.mass * 0.5)
    expected = inertia * ddq + weight + (0.2 + 0.1) * dq
    assert kinematics.torque(JointMotion(q, dq, ddq)) == pytest.approx(expected, abs=1e-9)
    for angle in q[:5]:
        x = np.array([0.5 * np.cos(angle) + 0.4, 1 + 0.5 * np.sin(angle)]).T[0]
        assert kinematics.position(angle) == pytest.approx(x[: robot.m], abs=1e-12)
    assert kinematics.inertia(q[0]) == pytest.approx(
        np.full((1, 1), inertia[0] if np.ndim(inertia) else inertia)
    )
    assert robot.damping == pytest.approx([0.3])


def test_the_law_finds_the_optimum_of_a_coupled_arm_and_the_coupling_holds(tmp_path):
    run = rmj.simulate(for_robot(written(tmp_path)).replace({"motion.0.duration": 20.0}))
    assert run.status is rmj.Status.OK
    motion = run.motions[0]
    assert motion.cycles_to_optimum is not None
    assert run.stiffness == pytest.approx(motion.stiffness_optimal, rel=0.01)
    # elbow = -shoulder keeps the lower link level, but for what MuJoCo's constraint gives way.
    q, z = run.data["q"].values[-500:, 0], run.data["x"].values[-500:, 0]
    assert z == pytest.approx(1 + 0.5 * np.sin(q), abs=2e-3)


@pytest.mark.parametrize(
    ("equality", "rest", "leads"),
    [
        (OPPOSITE, '<actuator><motor joint="elbow"/></actuator>', "elbow"),
        (OPPOSITE, '<actuator><motor joint="shoulder"/></actuator>', "shoulder"),
        ('<joint joint1="shoulder" joint2="elbow" polycoef="0 -1 0 0 0"/>', "", "elbow"),
    ],
)
def test_the_joint_leads_that_is_driven_or_that_the_file_lets_lead(tmp_path, equality, rest, leads):
    robot = build(for_robot(written(tmp_path, equality, rest)))
    assert robot.joints == (leads,)
    (follows,) = {"elbow", "shoulder"} - {leads}
    assert any(f"{follows} follows {leads} (-1)" in note for note in robot.notes)


def test_motors_of_both_add_up_and_the_range_of_a_joint_ends_where_its_followers_does(tmp_path):
    half = '<joint joint1="elbow" joint2="shoulder" polycoef="0.1 -0.5 0 0 0"/>'
    motors = (
        '<actuator><motor joint="shoulder" ctrlrange="-3 5"/>'
        '<motor joint="elbow" ctrlrange="-8 2"/></actuator>'
    )
    robot = build(for_robot(written(tmp_path, half, motors, its_range="-0.4 0.6")))
    assert robot.torque_limit.tolist() == [[-3 - 1, 5 + 4]]
    assert robot.model.jnt_range[robot.joint_id].tolist() == [[-1.0, 1.0]]
    assert robot.positions(np.array([0.2])) == pytest.approx([0.2, 0.1 - 0.5 * 0.2])
    assert robot.qpos[1] == pytest.approx(0.1 - 0.5 * robot.home[0])


def test_a_coupling_that_is_not_proportional_is_refused(tmp_path):
    bent = '<joint joint1="elbow" joint2="shoulder" polycoef="0 -1 0.3 0 0"/>'
    with pytest.raises(rmj.ResonanceError, match=r"joint constraint .*robot\.joints"):
        build(for_robot(written(tmp_path, bent)))


def test_both_joints_of_a_coupling_move_on_their_own_where_both_are_asked_for(tmp_path):
    experiment = for_robot(written(tmp_path)).replace({"robot.joints": ["shoulder", "elbow"]})
    off = OPPOSITE.replace("joint joint1", "joint active='false' joint1")
    for robot in (build(experiment), build(for_robot(written(tmp_path, off)))):
        assert robot.joints == ("shoulder", "elbow")
        assert robot.model.neq == 0


def test_a_urdf_joint_that_mimics_another_follows_it(tmp_path):
    link = (
        '<link name="{0}"><inertial><origin xyz=".2 0 0"/><mass value="1"/>'
        '<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )
    joint = (
        '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>'
        '<origin xyz="{3} 0 0"/><axis xyz="0 1 0"/>'
        '<limit lower="-2" upper="2" effort="20" velocity="3"/>{4}</joint>'
    )
    mimic = '<mimic joint="b" multiplier="-0.5" offset="0.2"/>'
    text = "".join(link.format(name) for name in ("base", "one", "two", "three"))
    text += joint.format("a", "base", "one", 0, "")
    text += joint.format("b", "one", "two", 0.4, "")
    text += joint.format("c", "two", "three", 0.4, mimic)
    path = tmp_path / "arm.urdf"
    path.write_text(f'<robot name="mimic">{text}</robot>')
    robot = build(for_robot(str(path)).replace({"robot.home": [0.3, 0.6]}))
    assert robot.joints == ("a", "b")
    assert robot.qpos == pytest.approx([0.3, 0.6, 0.2 - 0.3])
