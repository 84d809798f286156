"""The laws that users compare with: each does what it says, and no more."""

import numpy as np
import pytest
from two_link import first_motion, inertia, inverse_kinematics, jacobian, joint_motion

import resonance_mj as rmj
from resonance_mj.experiments.law_section import KINDS
from resonance_mj.experiments.loading import for_robot
from resonance_mj.laws import laws, learning
from resonance_mj.laws.gains import gains
from resonance_mj.motions.kinematics import Kinematics
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots.robot import build

STEPS = 1000


def run(kind, cycles=3, **changes):
    """The paper's first motion for a few cycles under a law."""
    return rmj.simulate(experiment(kind, cycles, **changes))


def experiment(kind, cycles=3, **changes):
    paper = rmj.load("paper")
    motion = paper.motion[0].model_dump() | {"duration": float(cycles)}
    centred = {"law.kind": kind, "law.q_c": "mean", "law.q_s": "mean"}
    return paper.replace({"motion": [motion], **centred, **changes})


def signals(found, *names):
    return (found.data[name].values for name in names)


def per_cycle(values):
    return values.reshape(-1, STEPS, values.shape[1])


def test_every_law_that_can_be_named_is_there():
    assert tuple(laws.LAWS) == KINDS
    told = {what for law in laws.LAWS.values() for what in law.told}
    assert told <= {"joints", "springs", "torque"}
    adapted = {name for law in laws.LAWS.values() for name in law.adapts}
    assert adapted == {"gamma_k", "gamma_qe"}


@pytest.mark.parametrize(
    ("kind", "integrator"),
    [
        ("feedback", "implicitfast"),
        ("learning", "implicitfast"),
        ("fixed", "implicitfast"),
        ("joint-space", "Euler"),
        ("joint-space", "RK4"),
        ("computed-torque", "implicitfast"),
    ],
)
def test_compiled_and_interpreted_law_agree_to_the_last_bit(kind, integrator):
    one = experiment(kind, 2, **{"motion.0.blend": 1, "simulation.integrator": integrator})
    compiled, interpreted = rmj.simulate(one), rmj.simulate(one, interpret=True)
    for name in ("q", "dq", "tau", "u", "y", "stiffness", "offset"):
        here, there = (each.data[name].values for each in (compiled, interpreted))
        np.testing.assert_array_equal(here, there, err_msg=name)
        np.testing.assert_array_equal(np.signbit(here), np.signbit(there), err_msg=name)


def test_every_law_steps_in_a_batch_with_others_as_it_does_alone():
    experiments = [experiment(kind, 2) for kind in KINDS]
    for one, together in zip(experiments, rmj.simulate_many(experiments), strict=True):
        np.testing.assert_array_equal(together.data["tau"], rmj.simulate(one).data["tau"])


# Feedback, learning, fixed springs: (4), and what is added to it


def test_feedback_is_4_without_learned_torque_and_without_springs():
    found = rmj.simulate(experiment("feedback", 3).replace({"law.velocity": "jacobian"}))
    q, dq, tau, u, k, offset = signals(found, "q", "dq", "tau", "u", "stiffness", "offset")
    for nothing in (u, k, offset):
        np.testing.assert_array_equal(nothing, 0.0)
    x, dx, _ = first_motion(np.arange(len(q)) / STEPS)
    miss, J = found.data["x"].values - x, jacobian(q)
    force = 200 * (np.einsum("tij,tj->ti", J, dq) - dx) + 2000 * np.sin(miss)
    np.testing.assert_allclose(tau, -np.einsum("tij,ti->tj", J, force), atol=1e-9)


def test_learning_learns_all_torque_and_leaves_the_springs_as_they_began():
    begun = {"springs.initial_stiffness": [2.0, 1.0], "springs.initial_equilibrium": [4.0, -2.0]}
    found = run("learning", **{"law.lead": 2, "law.harmonics": 15, "law.beta": 4.0, **begun})
    u, y, k, q_e = signals(found, "u", "y", "stiffness", "equilibrium")
    u, y = per_cycle(u), per_cycle(y)
    for i in range(2):
        taught = u[i] - 4.0 * np.roll(y[i], -2, axis=0)
        np.testing.assert_allclose(u[i + 1], learning.low_pass(taught, 15), atol=1e-12)
    assert np.abs(np.fft.rfft(u[2], axis=0)[16:]).max() < 1e-9
    np.testing.assert_array_equal(k, np.broadcast_to([2.0, 1.0], k.shape))
    np.testing.assert_allclose(q_e, np.broadcast_to([4.0, -2.0], q_e.shape), rtol=1e-12)


def test_fixed_springs_are_the_optimum_of_each_motion_and_learning_brings_its_torque():
    changes = {"law.kind": "fixed", "law.lead": None, "law.beta": 10.0}
    short = {"motion.0.duration": 15.0, "motion.1.duration": 15.0}
    found = rmj.simulate(rmj.load("paper").replace(changes | short))
    for number, segment in enumerate(found.summary()["segments"]):
        mine = found.data["stiffness"].values[15 * STEPS * number :][: 15 * STEPS]
        best = np.array(segment["stiffness_optimal"])
        np.testing.assert_array_equal(mine, np.broadcast_to(best, mine.shape))
        assert segment["torque_squared"] == pytest.approx(
            segment["torque_squared_optimal"], rel=0.05
        )


# Joint space: the law before the paper's


def test_joint_space_law_follows_the_desired_joint_angles():
    """Its y is Δq̇ + α s(Δq), with the joint motion of inverse kinematics."""
    found = run("joint-space", **{"simulation.integrator": "RK4"})
    q, dq, y = signals(found, "q", "dq", "y")
    q_d, dq_d, _ = joint_motion(*first_motion(np.arange(len(q)) / STEPS))
    error = q - q_d
    expected = dq - dq_d + 10.0 * np.where(np.abs(error) > np.pi / 2, np.sign(error), np.sin(error))
    np.testing.assert_allclose(y, expected, atol=1e-8)


def test_joint_space_gains_are_at_home_what_those_of_the_task_are():
    one = experiment("joint-space", **{"law.k_v": [150.0, 250.0], "law.k_p": [1000.0, 3000.0]})
    robot = build(one)
    found, J = gains(one, Kinematics(robot)), jacobian(robot.home)
    np.testing.assert_allclose(found.feedback, J.T @ np.diag([150.0, 250.0]) @ J, rtol=1e-9)
    np.testing.assert_allclose(found.feedback_p, J.T @ np.diag([1000.0, 3000.0]) @ J, rtol=1e-9)
    run_ = rmj.simulate(one.replace({"motion.0.duration": 1.0, "simulation.integrator": "RK4"}))
    q, dq, tau = signals(run_, "q", "dq", "tau")
    q_d, dq_d, _ = joint_motion(*first_motion(np.arange(len(q)) / STEPS))
    expected = -(dq - dq_d) @ found.feedback.T - np.sin(q - q_d) @ found.feedback_p.T
    np.testing.assert_allclose(tau, expected, atol=1e-6)


def test_feedback_is_the_inertia_where_the_motion_is_times_its_bandwidth():
    """The arm is folded at home and nearly stretched along the motion, where it is heavier."""
    motion = {"center": [-0.45, -0.1], "size": [0.02, 0.02]}
    changes = {"robot.home": [4.0, -2.7], "motion": [motion]}
    plan = plan_for(for_robot("two_link.xml").replace(changes))
    M = inertia(plan.joints[0].q.mean(axis=0))
    assert M[0, 0] > 1.5 * inertia(plan.robot.home)[0, 0]
    np.testing.assert_allclose(plan.gains.inertia, M, rtol=0.01)
    damping = plan.gains.feedback - plan.gains.omega * plan.gains.inertia
    np.testing.assert_allclose(damping, np.diag(np.diag(damping)), atol=1e-12)
    assert (np.diag(damping) > 0).all()


def test_joint_space_law_adapts_the_stiffness_alone():
    """By explicit Euler steps of (6); the equilibrium stays at q_c, where q̄_e is 0."""
    found = run("joint-space", **{"springs.initial_stiffness": [1.0, 0.5]})
    k, offset, q, y, q_c = signals(found, "stiffness", "offset", "q", "y", "center")
    np.testing.assert_array_equal(offset, 0.0)
    np.testing.assert_allclose(k[1:], (k + 1e-3 * np.array([50.0, 5.0]) * (q - q_c) * y)[:-1])
    assert np.abs(k[-1] - k[0]).min() > 0.1
    np.testing.assert_array_equal(found.data["equilibrium"], q_c)


def test_joint_space_law_does_not_learn_what_a_spring_could_exert_along_the_desired_motion():
    u = per_cycle(run("joint-space").data["u"].values)[2]
    q_d = inverse_kinematics(first_motion(np.arange(STEPS) / STEPS)[0])
    z = q_d - q_d.mean(axis=0)
    assert np.abs(u).max() > 0.01
    np.testing.assert_allclose((u * z).mean(axis=0), 0, atol=1e-9)


def test_an_equilibrium_that_the_joint_space_law_would_not_keep_is_refused():
    begun = {"springs.initial_stiffness": 1.0, "springs.initial_equilibrium": [1.0, 0.0]}
    with pytest.raises(rmj.ResonanceError, match=r"springs.initial_equilibrium = \[1.0, 0.0\]"):
        experiment("joint-space", **begun)


# Computed torque: the bound


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_computed_torque_makes_the_motion_with_the_optimums_torque(integrator):
    changes = {"law.kind": "computed-torque", "simulation.integrator": integrator}
    short = {"motion.0.duration": 4.0, "motion.1.duration": 4.0}
    found = rmj.simulate(rmj.load("paper").replace(changes | short))
    for segment in found.summary()["segments"]:
        assert segment["tracking_rms"] < 1e-4
        assert segment["torque_squared"] == pytest.approx(
            segment["torque_squared_optimal"], rel=2e-3
        )


def test_computed_torque_does_not_leave_the_path_in_a_passage():
    """It knows the joint motion and the torque of passages too, from rest and between motions."""
    changes = {"law.kind": "computed-torque", "simulation.integrator": "RK4"}
    passages = {f"motion.{i}.{key}": v for i in (0, 1) for key, v in PASSAGE.items()}
    found = rmj.simulate(rmj.load("paper").replace(changes | passages))
    assert found.data["tracking_rms"].max() < 1e-4


PASSAGE = {"blend": 2, "duration": 4.0}


@pytest.mark.parametrize("kind", ["joint-space", "computed-torque"])
def test_laws_in_joint_space_drive_arms_with_more_joints_than_coordinates(kind):
    plain = for_robot("planar_three_link.xml").replace({"law.kind": kind})
    found = rmj.simulate(plain.replace({"motion": [{"duration": 10.0}]}))
    assert found.status is rmj.Status.OK
    assert found.data["tracking_rms"][-1] < (1e-4 if kind == "computed-torque" else 0.03)


def test_a_passage_that_cannot_be_made_is_refused_before_the_first_step():
    """From one side of the base to the other the tool would pass through it."""
    paper = rmj.load("paper")
    motions = [
        one.model_dump() | {"blend": 1, "duration": 3.0, "sin": [[0.01], [0.01]], "cos": []}
        for one in paper.motion
    ]
    motions[0]["offset"], motions[1]["offset"] = (-0.3, 0.0), (0.3, 0.0)
    changed = paper.replace({"motion": motions})
    _ = plan_for(changed).notes
    with pytest.raises(rmj.ResonanceError, match=r"passage to motion.1: "):
        rmj.simulate(changed.replace({"law.kind": "computed-torque"}))


@pytest.mark.parametrize("kind", ["fedback", "Paper", ""])
def test_an_unknown_law_is_refused_with_those_there_are(kind):
    with pytest.raises(rmj.ResonanceError) as caught:
        rmj.load("paper").replace({"law.kind": kind})
    message = str(caught.value)
    assert "\n" not in message
    assert [name for name in KINDS if name not in message] == []
    assert "law.kind" in message


def test_the_printed_law_adapts_on_an_arm_whose_user_gives_no_gains():
    """With the paper's arm's inertia its gains are about the paper's, 50 and 5, 150 and 10."""
    arm = for_robot("two_link.xml").replace({"law.kind": "paper"})
    plan = plan_for(arm)
    mass = np.diag(inertia(plan.robot.home))
    np.testing.assert_allclose(plan.experiment.law.gamma_k, 200 * mass, rtol=1e-9)
    np.testing.assert_allclose(plan.experiment.law.gamma_qe, 500 * mass, rtol=1e-9)
    assert any("law.gamma_k = [" in note for note in plan.notes)
    given = plan_for(arm.replace({"law.gamma_k": 0.0}))
    assert given.experiment.law.gamma_qe == given.experiment.law.gamma_k == 0.0
    assert (np.abs(np.ptp(rmj.simulate(arm).data["stiffness"].values, axis=0)) > 0).all()
