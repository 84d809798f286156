"""The power of the runs' expectations: one thing is changed at a time, and they miss each.

What is changed is the robot, a gain or gravity. Terms of the equations are changed by
benchmarks/mutation.py; that the runs meet their expectations as they are is a test of its own.
"""

import mujoco
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.evaluation.checks.check import judge

slow = pytest.mark.sensitivity


def missed(experiment):
    """What a run misses of its expectations."""
    return [one.key for one in judge(rmj.simulate(experiment)) if not one.passed]


# The robot, the gains, gravity


def heavier(robot, body):
    robot.body(body).mass *= 1.05
    robot.body(body).inertia = robot.body(body).inertia * 1.05


def damped(robot, joint):
    robot.joint(joint).damping = robot.joint(joint).damping * 1.2


@pytest.mark.parametrize(
    ("name", "change", "part"),
    [
        ("paper", heavier, "link1"),
        ("paper", damped, "joint2"),
        pytest.param("paper", heavier, "link2", marks=slow),
        pytest.param("paper", damped, "joint1", marks=slow),
        pytest.param("paper-centered", heavier, "link1", marks=slow),
        pytest.param("paper-centered", heavier, "link2", marks=slow),
        pytest.param("paper-centered", damped, "joint1", marks=slow),
        pytest.param("paper-transpose", heavier, "link1", marks=slow),
        pytest.param("paper-transpose", heavier, "link2", marks=slow),
        pytest.param("paper-transpose", damped, "joint1", marks=slow),
        pytest.param("planar-three-link", heavier, "link1", marks=slow),
        pytest.param("planar-three-link", heavier, "link2", marks=slow),
        pytest.param("planar-three-link", heavier, "link3", marks=slow),
        pytest.param("scara", heavier, "link2", marks=slow),
        pytest.param("scara", heavier, "link3", marks=slow),
        pytest.param("scara", heavier, "link4", marks=slow),
        pytest.param("scara", damped, "lift", marks=slow),
        pytest.param("six-joint", heavier, "link2", marks=slow),
        pytest.param("six-joint", heavier, "link3", marks=slow),
        pytest.param("six-joint", heavier, "link4", marks=slow),
        pytest.param("six-joint", heavier, "link5", marks=slow),
        pytest.param("six-joint", heavier, "link6", marks=slow),
        pytest.param("six-joint", damped, "elbow", marks=slow),
        pytest.param("six-joint-pose", heavier, "link2", marks=slow),
        pytest.param("six-joint-pose", heavier, "link3", marks=slow),
        pytest.param("six-joint-pose", heavier, "link4", marks=slow),
        pytest.param("six-joint-pose", heavier, "link5", marks=slow),
        pytest.param("six-joint-pose", heavier, "link6", marks=slow),
        pytest.param("six-joint-pose", damped, "elbow", marks=slow),
        pytest.param("seven-joint", heavier, "link4", marks=slow),
        pytest.param("seven-joint", heavier, "link5", marks=slow),
        pytest.param("seven-joint", heavier, "link6", marks=slow),
        pytest.param("seven-joint", damped, "joint2", marks=slow),
        pytest.param("seven-joint-pose", heavier, "link3", marks=slow),
        pytest.param("seven-joint-pose", heavier, "link4", marks=slow),
        pytest.param("seven-joint-pose", heavier, "link5", marks=slow),
        pytest.param("seven-joint-pose", heavier, "link6", marks=slow),
        pytest.param("seven-joint-pose", damped, "joint4", marks=slow),
    ],
)
def test_a_link_5_percent_heavier_or_a_joint_20_percent_more_damped_is_noticed(
    name, change, part, tmp_path
):
    experiment = rmj.load(name)
    robot = mujoco.MjSpec.from_file(str(library.robots()[experiment.robot.mjcf]))
    change(robot, part)
    robot.compile()
    (tmp_path / "changed.xml").write_text(robot.to_xml())
    assert missed(experiment.replace({"robot.mjcf": str(tmp_path / "changed.xml")}))


@pytest.mark.parametrize(
    "change",
    [
        {"law.gamma_k": [25.0, 2.5]},
        pytest.param({"law.gamma_qe": [75.0, 5.0]}, marks=slow),
        pytest.param({"law.gamma_k": [25.0, 5.0]}, marks=slow),
        pytest.param({"law.gamma_k": [50.0, 2.5]}, marks=slow),
        pytest.param({"law.gamma_qe": [75.0, 10.0]}, marks=slow),
        pytest.param({"law.gamma_qe": [150.0, 5.0]}, marks=slow),
        pytest.param({"law.beta": 0.9}, marks=slow),
        pytest.param({"law.alpha": 9.0}, marks=slow),
        pytest.param({"law.k_v": 190.0}, marks=slow),
        pytest.param({"law.k_p": 1800.0}, marks=slow),
    ],
    ids=str,
)
@pytest.mark.parametrize(
    "name",
    [
        "paper",
        pytest.param("paper-centered", marks=slow),
        pytest.param("paper-transpose", marks=slow),
    ],
)
def test_half_an_adaptation_gain_or_another_feedback_is_noticed(name, change):
    assert missed(rmj.load(name).replace(change))


@pytest.mark.parametrize(
    "name", ["paper", *(pytest.param(n, marks=slow) for n in library.experiments() if n != "paper")]
)
def test_gravity_in_the_opposite_direction_is_noticed(name):
    assert missed(rmj.load(name).replace({"simulation.gravity": [0.0, 0.0, 9.8]}))
