"""The power of the runs' expectations: one thing is changed at a time, and they miss each.

What is changed is the robot, a gain, gravity, or one term of an equation in the source itself. A
change of (4)-(8) is run through the interpreter, because compiled code is cached by its sources.
"""

import inspect

import mujoco
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.evaluation.checks.check import judge
from resonance_mj.laws import equations, learning

slow = pytest.mark.sensitivity


def missed(experiment, interpret=False):
    """What a run misses of its expectations, as keys, `expect.` left out."""
    run = rmj.simulate(experiment, interpret=interpret)
    return {one.key.removeprefix("expect.") for one in judge(run) if not one.passed}


def first_motion(name):
    """A run's first motion alone, with what is expected of it."""
    experiment = rmj.load(name)
    expect = experiment.expect.model_dump(exclude_none=True)
    return experiment.replace(
        {
            "motion": [experiment.motion[0].model_dump()],
            "expect": expect | {"motion": expect["motion"][:1]},
        }
    )


@pytest.fixture
def substituted(monkeypatch):
    """Replace a text that stands once in a function's body by another, in the running package."""

    def substitute(module, function, old, new):
        source = inspect.getsource(getattr(module, function)).replace("@step_function\n", "")
        head, quotes, body = source.rpartition('"""')
        assert body.count(old) == 1, f"{function} has {old!r} {body.count(old)} times"
        names = dict(vars(module))
        exec(head + quotes + body.replace(old, new), names)
        monkeypatch.setattr(module, function, names[function])

    return substitute


# Nothing changed


@pytest.mark.parametrize("interpret", [False, pytest.param(True, marks=slow)])
def test_first_motion_alone_meets_what_is_expected_of_it(interpret):
    """So that what is missed below is missed because of the change; whole runs are tests too."""
    assert missed(first_motion("paper"), interpret) == set()


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


# The equations


@pytest.mark.parametrize(
    ("function", "term", "changed"),
    [
        pytest.param("motor_torque", "u[j] - force", "u[j] + force", id="(4) feedback"),
        pytest.param(
            "motor_torque", "u[j] - force", "-u[j] - force", id="(4) learned torque", marks=slow
        ),
        pytest.param("motor_torque", "k_v[i] * rate", "-k_v[i] * rate", id="(4) velocity"),
        pytest.param("motor_torque", "+ k_p[i]", "- k_p[i]", id="(4) position", marks=slow),
        pytest.param("saturation", "= math.sin", "= -math.sin", id="(5)"),
        pytest.param("stiffness_rate", "return gamma", "return -gamma", id="(6)"),
        pytest.param("stiffness_rate", "q - q_c", "q + q_c", id="(6) centre", marks=slow),
        pytest.param("offset_rate", "return -gamma", "return gamma", id="(7)"),
        pytest.param("error_inverse", "rate[i] +", "-rate[i] +", id="(8) velocity"),
        pytest.param("error_inverse", "+ alpha", "- alpha", id="(8) position"),
    ],
)
def test_a_changed_sign_in_4_to_8_is_noticed(substituted, function, term, changed):
    substituted(equations, function, term, changed)
    assert missed(first_motion("paper"), interpret=True)


@pytest.mark.parametrize(
    ("name", "function", "term", "changed"),
    [
        pytest.param("paper", "learn", "v - spring", "v + spring", id="(9) w"),
        pytest.param("paper", "learn", "u - corrected", "-u - corrected", id="(9) u", marks=slow),
        pytest.param("paper", "learn", "u - corrected", "u + corrected", id="(9) y", marks=slow),
        pytest.param("paper-centered", "learn", "q - np", "q + np", id="(9) q_s", marks=slow),
        pytest.param(
            "paper", "spring_like_part", '", v, q_bar', '", -v, q_bar', id="(10) numerator"
        ),
    ],
)
def test_a_changed_sign_in_9_and_10_is_noticed(substituted, name, function, term, changed):
    substituted(learning, function, term, changed)
    assert missed(rmj.load(name))


@pytest.mark.parametrize(
    ("function", "term", "changed"),
    [
        pytest.param("corrected", "-lead", "1 - lead", id="y a step late"),
        pytest.param("corrected", "-lead", "-lead - 1", id="y a step early", marks=slow),
        pytest.param("learn", "(u - ", "(np.roll(u, -1, -2) - ", id="u a step early", marks=slow),
        pytest.param("learn", "(u - ", "(np.roll(u, 1, -2) - ", id="u a step late", marks=slow),
    ],
)
@pytest.mark.parametrize("name", ["paper", pytest.param("paper-centered", marks=slow)])
def test_a_shifted_time_index_in_9_is_noticed(substituted, name, function, term, changed):
    substituted(learning, function, term, changed)
    assert missed(rmj.load(name))


@pytest.mark.parametrize(
    ("term", "changed"),
    [
        pytest.param("total - best", "total + best", id="what the springs took"),
        pytest.param("v + springs", "v - springs", id="total torque", marks=slow),
    ],
)
@pytest.mark.parametrize(
    "name",
    [
        "scara",
        pytest.param("planar-three-link", marks=slow),
        pytest.param("six-joint", marks=slow),
        pytest.param("six-joint-pose", marks=slow),
        pytest.param("seven-joint", marks=slow),
        pytest.param("seven-joint-pose", marks=slow),
    ],
)
def test_a_changed_sign_of_the_transfer_is_noticed(substituted, name, term, changed):
    substituted(learning, "transfer", term, changed)
    assert missed(rmj.load(name))
