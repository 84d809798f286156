"""Motions given in joint angles: what is made, learned, judged, recorded and refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import resonance_mj as rmj
from resonance_mj.errors import ExperimentError
from resonance_mj.experiments.experiment import Experiment
from resonance_mj.motions.kinematics import Kinematics
from resonance_mj.plan.plan import plan_for
from resonance_mj.results.cycles import kept

SWING = {
    "motion.0": {
        "duration": 15.0,
        "shape": "fourier",
        "offset": [-0.5, -2.0],
        "sin": [[0.3, 0.05], [0.2]],
        "cos": [[0.0], [0.1]],
    }
}


def swinging(robot="two_link.xml", **changes):
    given = {"name": "swing", "robot": {"mjcf": robot}, "task": {"space": "joint"}}
    return Experiment(**given).replace(SWING | changes)


@pytest.fixture(scope="module")
def run():
    return rmj.simulate(swinging())


def test_joints_come_to_follow_and_springs_to_their_optimum(run):
    (motion,) = run.motions
    assert run.status == "ok"
    assert motion.cycles_to_optimum <= 10
    assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)
    last = kept(run)[-1]
    t = np.arange(1000) / 1000 * 2 * np.pi
    first = -0.5 + 0.3 * np.sin(t) + 0.05 * np.sin(2 * t)
    second = -2.0 + 0.2 * np.sin(t) + 0.1 * np.cos(t)
    error = last.q - np.stack([first, second], axis=1)
    assert np.sqrt((error**2).sum(axis=1).mean()) < 1e-4
    assert motion.joint_rms[-1] == pytest.approx(np.sqrt((error**2).sum(axis=1).mean()), rel=1e-6)
    assert motion.swing == pytest.approx(np.ptp(first), rel=1e-4)


def test_the_desired_path_is_what_the_tool_does_at_the_desired_angles(run):
    kinematics, joints = Kinematics(run.plan.robot), run.plan.joints[0]
    last = kept(run)[-1]
    for i in range(0, 1000, 97):
        assert np.allclose(last.x_desired[i], kinematics.position(joints.q[i]), atol=1e-12)
    path = kinematics.tool_path(joints)
    moved = np.gradient(path.x, 1e-3, axis=0)[1:-1]
    assert np.allclose(moved, path.dx[1:-1], atol=1e-4)
    faster = np.gradient(path.dx, 1e-3, axis=0)[1:-1]
    assert np.allclose(faster, path.ddx[1:-1], atol=1e-2)


def test_compiled_and_interpreted_agree_to_the_last_bit_and_so_do_batches():
    experiment = swinging(**{"motion.0.duration": 3.0})
    alone = rmj.simulate(experiment)
    assert alone.data.identical(rmj.simulate(experiment, interpret=True).data)
    other = experiment.replace({"law.beta": 3.0})
    for one in rmj.simulate_many([other, experiment], progress=False)[1:]:
        assert alone.data.identical(one.data)


@pytest.mark.parametrize("kind", ["feedback", "learning", "fixed", "paper", "computed-torque"])
def test_every_law_acts_in_joint_space(kind):
    run = rmj.simulate(swinging(**{"law.kind": kind, "motion.0.duration": 6.0}))
    assert run.status in ("ok", "not tracking")
    assert run.data.sizes["cycle"] == 6


def test_the_law_finds_the_springs_of_a_real_arm_in_joint_space():
    run = rmj.simulate(swinging(reality="lab", **{"motion.0.duration": 30.0}))
    (motion,) = run.motions
    assert run.status == "ok"
    assert motion.torque_share[-5:].mean() > 0.98


def test_seven_joints_pass_a_singular_pose_which_is_no_error():
    straight = {"shape": "fourier", "offset": [0.0] * 7, "sin": [[0.2]] * 7, "duration": 15.0}
    experiment = swinging("seven_joint.xml", **{"motion.0": straight})
    run = rmj.simulate(experiment)
    (motion,) = run.motions
    assert run.status == "ok"
    assert motion.optimum_of == "desired"
    assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)
    assert not any("singular" in note for note in run.notes)


def test_a_motion_in_the_plane_of_two_joints_gets_a_size_within_the_ranges():
    for shape in ("ellipse", "line", "eight", "polygon"):
        plan = plan_for(swinging(**{"motion.0": {"shape": shape, "duration": 3.0}}))
        motion, q = plan.experiment.motion[0], plan.joints[0].q
        assert motion.plane == ("joint1", "joint2")
        assert np.allclose(motion.center, plan.robot.home)
        assert np.abs(q - plan.robot.home).max(axis=0) == pytest.approx(motion.size, rel=0.1)


def test_points_and_waypoints_are_joint_angles(tmp_path):
    stops = {"shape": "points", "points": [[-0.5, -2.0], [0.1, -1.5]], "rests": [0.2, 0.1]}
    q = plan_for(swinging(**{"motion.0": stops | {"duration": 3.0}})).joints[0].q
    assert np.allclose(q[:200], [-0.5, -2.0])
    assert np.allclose(q[650], [0.1, -1.5], atol=0.05)
    rows = "joint2,joint1\n-2.0,-0.5\n-1.9,-0.4\n-2.0,-0.3\n-2.1,-0.4\n"
    (tmp_path / "angles.csv").write_text(rows)
    given = {"shape": "csv", "file": str(tmp_path / "angles.csv"), "duration": 3.0}
    q = plan_for(swinging(**{"motion.0": given})).joints[0].q
    assert np.allclose(q[[0, 250, 500, 750]], [[-0.5, -2], [-0.4, -1.9], [-0.3, -2], [-0.4, -2.1]])


def test_from_one_motion_into_the_next_joints_pass_smoothly():
    first = swinging().motion[0].model_dump(exclude_unset=True)
    second = first | {"offset": [-0.3, -1.8], "blend": 2}
    plan = plan_for(swinging(**{"motion": [first, second]}))
    cycles = [plan.joint_motion(cycle).q for cycle in range(13, 18)]
    q = np.concatenate(cycles)
    assert np.abs(np.diff(q, n=2, axis=0)).max() < 1e-4  # about 1e-6 times an acceleration
    assert np.allclose(cycles[-1], plan.joints[1].q)


def test_joints_that_are_off_are_said_to_be_and_not_the_tool(tmp_path):
    run = rmj.simulate(swinging(**{"law.kind": "feedback", "law.omega": 5.0}))
    assert run.status == "not tracking"
    assert "of the joints, which swing by" in run.message
    assert run.motions[0].off.startswith("the joints are ")
    page = rmj.report([run], tmp_path / "page.html", video=False, progress=False)
    assert "The joints are " in page.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_whole_run_is_saved_read_and_drawn(run, tmp_path):
    again = rmj.Run.load(run.save(tmp_path / "run"))
    assert again.data.identical(run.data)
    assert rmj.simulate(rmj.load(tmp_path / "run" / "experiment.toml")).data.identical(run.data)
    assert all(path.exists() for path in rmj.plot(run, tmp_path, figures=["cycles", "path"]))
    page = rmj.report([run], tmp_path / "page.html", video=False, progress=False)
    assert "tracking RMS of the joints" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"motion.0.offset": [0.0] * 3, "motion.0.sin": (), "motion.0.cos": ()},
            "one per joint of",
        ),
        ({"motion.0.frame": "tool"}, "frame = 'tool': task.space = 'joint'"),
        ({"motion.0.rotation_sin": [[0.1]] * 3}, "rotation_sin is given, and task.space = 'joint'"),
        ({"motion.0": {"plane": ["x", "z"]}}, "x is not one of the arm's joints: joint1, joint2"),
        ({"motion.0": {"shape": "points", "points": [[1, 1, 1], [0, 0, 0]]}}, "the arm's joints"),
        ({"task.space": "cartesian"}, "task.space = 'cartesian'"),
    ],
)
def test_what_does_not_fit_the_joints_is_refused_in_one_line(changes, words):
    with pytest.raises(ExperimentError) as refused:
        plan_for(swinging(**changes))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_keys_of_the_tool_s_law_are_said_to_have_no_effect():
    changes = {"law.jacobian": "transpose", "law.alpha_0": 3.0, "motion.0.duration": 1.0}
    notes = " ".join(rmj.simulate(swinging(**changes)).notes)
    assert "law.jacobian = 'transpose' has no effect: task.space = 'joint'" in notes
    assert "law.alpha_0 = 3.0 has no effect: task.space = 'joint'" in notes


def pendulum(t, state):
    """The double pendulum of Wotte et al. with its spring of 10 N m/rad, by its equations."""
    (q1, q2, d1, d2), m, g = state, 0.4, 9.81
    c, h = np.cos(q2), -m * np.sin(q2)
    M = m * np.array([[3 + 2 * c, 1 + c], [1 + c, 1.0]])
    bias = np.array([h * (2 * d1 * d2 + d2**2), -h * d1**2])
    weight = m * g * np.array([2 * np.sin(q1) + np.sin(q1 + q2), np.sin(q1 + q2)])
    return [d1, d2, *np.linalg.solve(M, -bias - weight - np.array([0.0, 10.0 * q2]))]


def test_an_eigenmode_needs_the_spring_that_makes_it_and_no_motor():
    run = rmj.simulate(rmj.load("double-pendulum"))
    (motion,) = run.motions
    assert run.status == "ok"
    assert np.allclose(run.stiffness, [0.0, 10.0], atol=1e-3)
    assert motion.torque_squared[-1] < 1e-7 * motion.torque_squared_without_springs
    # The motion is the published one: from rest at (0.5, 0.0326) rad, T = 2.638 s.
    last, T = kept(run)[-1], motion.period
    assert round(T, 3) == 2.638
    t = np.arange(len(last.q)) / len(last.q) * T
    exact = solve_ivp(pendulum, (0, T), [0.5, 0.032569495, 0, 0], t_eval=t, rtol=1e-11, atol=1e-12)
    assert np.abs(last.q - exact.y[:2].T).max() < 1e-4
