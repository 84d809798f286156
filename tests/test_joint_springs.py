"""Springs that differ from joint to joint: none, of a given rest angle or stiffness, own bounds."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import resonance_mj as rmj

BASE = rmj.load("planar-three-link").replace({"motion.0.duration": 20.0})
MIXED = {
    "joint1": {"rest": 1.3},
    "joint2": {"kind": "none"},
    "joint3": {"stiffness": [0.0, 0.4], "equilibrium": [-0.2, 0.3]},
}


def with_springs(joint, **springs):
    return BASE.replace({"springs": springs | {"joint": joint}})


def test_each_joint_gets_the_best_spring_that_it_may_have():
    ((free,), (best,)) = (rmj.optimum(one) for one in (BASE, with_springs(MIXED)))
    torque, q = best.torque_without_springs, best.q
    # Of a given rest angle: least squares in k alone.
    k = lsq_linear((1.3 - q[:, 0])[:, None], torque[:, 0], (0, np.inf)).x[0]
    assert best.stiffness[0] == pytest.approx(k, rel=1e-6)
    assert best.equilibrium[0] == pytest.approx(1.3)
    assert best.torque[:, 1] == pytest.approx(torque[:, 1])
    # In the polygon of the bounds: no step of either parameter into it leaves less.
    assert 0 < best.stiffness[2] <= 0.4
    middle = q[:, 2].mean()
    for dk, angle in ((0.01, 0.0), (-0.01, 0.0), (0.0, 0.02), (0.0, -0.02)):
        other = np.clip(best.stiffness[2] + dk, 0, 0.4)
        rest = np.clip(best.equilibrium[2] - middle + angle, -0.2, 0.3) + middle
        left = torque[:, 2] - other * (rest - q[:, 2])
        assert (left**2).sum() >= (best.torque[:, 2] ** 2).sum() - 1e-9
    assert free.torque_squared < best.torque_squared < free.torque_squared_without_springs


def test_the_law_reaches_the_optimum_of_springs_that_differ():
    run = rmj.simulate(with_springs(MIXED))
    motion = run.motions[0]
    assert run.status is rmj.Status.OK
    assert motion.cycles_to_optimum is not None
    assert run.stiffness.values == pytest.approx(motion.stiffness_optimal, rel=0.01, abs=1e-6)
    assert (run.data["stiffness"].values[:, 1] == 0).all()
    assert (run.data["offset"].values[:, 1] == 0).all()
    acting = run.data["stiffness"].values[:, 0] > 0
    assert run.data["equilibrium"].values[acting, 0] == pytest.approx(1.3)


def test_a_bought_spring_of_given_rate_and_rest_stays_as_it_is():
    run = rmj.simulate(with_springs({"joint1": {"stiffness": [30.0, 30.0], "rest": 1.2}}))
    assert run.data["stiffness"].values[:, 0] == pytest.approx(30.0)
    assert run.data["equilibrium"].values[:, 0] == pytest.approx(1.2)
    assert run.motions[0].verdict == "at optimum"


def test_an_arm_without_any_spring_has_the_torque_without_springs_as_its_optimum():
    (best,) = rmj.optimum(with_springs({name: {"kind": "none"} for name in MIXED}))
    assert best.torque_squared == best.torque_squared_without_springs


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        ({"joint9": {"rest": 0.0}}, ["springs.joint.joint9", "no such joint", "joint1"]),
        ({"joint1": {"rest": 0.0, "equilibrium": [0.0, 1.0]}}, ["joint.joint1", "rest"]),
        ({"joint1": {"kind": "none", "rest": 0.0}}, ["joint1", '"none" has neither']),
        ({"joint1": {"stiffness": [-1.0, 5.0], "rest": 0.2}}, ["rest = 0.2", "stiffness >= 0"]),
        ({"joint1": {"stiffness": [5.0, 1.0]}}, ["joint1.stiffness", "lower <= upper"]),
        ({"joint1": {"rset": 1.0}}, ["rset", "rest"]),
    ],
)
def test_a_spring_that_cannot_be_is_refused_with_its_joint(joint, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        rmj.optimum(with_springs(joint))
    message = str(caught.value)
    assert all(word in message for word in words), message
    assert "\n" not in message


def test_springs_of_joints_are_written_to_the_file_of_a_run_and_read_from_it(tmp_path):
    experiment = with_springs(MIXED)
    path = tmp_path / "mixed.toml"
    path.write_text(experiment.to_toml())
    assert "[springs.joint.joint1]" in path.read_text()
    read = rmj.load(path)
    assert read.springs == experiment.springs
    changed = read.replace({"springs.joint.joint1.rest": 1.0})
    assert changed.springs.joint["joint1"].rest == 1.0
