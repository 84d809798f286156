"""A controller that takes the arm's dimensions for others, and springs whose mechanism lags."""

import mujoco
import numpy as np
import pytest
from test_drives import arm

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.errors import ResonanceError
from resonance_mj.laws.memory import Memory
from resonance_mj.laws.misjudging import misjudge
from resonance_mj.motions.kinematics import Kinematics
from resonance_mj.plan.plan import plan_for
from resonance_mj.simulation.loading import load_law


def errors(n):
    return np.random.default_rng(n).uniform(-0.2, 0.3, n)


@pytest.mark.parametrize("name", ["two-link-transfer", "scara", "six-joint-pose", "seven-joint"])
def test_the_controller_sees_an_arm_whose_links_are_as_long_as_it_takes_them_to_be(name):
    n = plan_for(rmj.load(name)).robot.n
    offset, error = (0.03, -0.02, 0.05), errors(n)
    plan = plan_for(arm({"tool_offset": offset, "link_error": error.tolist()}, name=name))
    robot = plan.robot
    userdata = np.zeros((1, plan.layout.size))
    memory = Memory(userdata, plan.layout)
    load_law(memory, 0, plan)
    # Of these arms each link is one body, with its joint at its origin and the tool on the last.
    other = mujoco.MjModel.from_binary_path(saved(robot.model))
    for j, joint in enumerate(robot.joint_id):
        body = int(other.jnt_bodyid[joint])
        following = np.flatnonzero(other.body_parentid == body)
        other.body_pos[following] *= 1 + error[j]
    other.site_pos[robot.site] *= 1 + error[-1]
    other.site_pos[robot.site] += offset
    believed, truth = mujoco.MjData(other), mujoco.MjData(robot.model)
    rng = np.random.default_rng(0)
    for q in robot.home + rng.normal(size=(10, n)):
        J = np.zeros((6, robot.model.nv))
        for model, data in ((other, believed), (robot.model, truth)):
            data.qpos[:] = robot.qpos
            data.qpos[robot.qpos_address] = q
            mujoco.mj_forward(model, data)
        seen = memory["jacobian"][0]
        mujoco.mj_jacSite(robot.model, truth, seen[:3], seen[3:], robot.site)
        mujoco.mj_jacSite(other, believed, J[:3], J[3:], robot.site)
        at = truth.site_xpos[robot.site].copy()
        orientation = truth.site_xmat[robot.site].reshape(3, 3)
        misjudge(memory.block(0), truth.qpos, truth.xanchor, at, orientation)
        assert seen == pytest.approx(J, abs=1e-12)
        taken = memory["tool_taken"][0]
        assert taken == pytest.approx(believed.site_xpos[robot.site], abs=1e-12)
        away = Kinematics(robot).misjudged(q[None], plan.experiment.reality)[0]
        assert away == pytest.approx(taken - at, abs=1e-12)


def saved(model):
    import tempfile

    path = tempfile.mkstemp(suffix=".mjb")[1]
    mujoco.mj_saveModel(model, path)
    return path


def test_a_tool_that_is_taken_to_be_elsewhere_is_driven_as_if_it_were_there(tmp_path):
    offset = np.array([-0.02, 0.0, 0.03])
    spec = mujoco.MjSpec.from_file(str(library.robots()["two_link.xml"]))
    spec.site("tool").pos = spec.site("tool").pos + offset
    (tmp_path / "arm.xml").write_text(spec.to_xml())
    there = {"robot.mjcf": str(tmp_path / "arm.xml")}
    told = rmj.simulate(arm({}, 60, **there))
    untold = rmj.simulate(arm({"tool_offset": offset.tolist()}, 60))
    for run_of in ("q", "tau", "stiffness"):
        last = [run.data[run_of].values[-1000:] for run in (told, untold)]
        assert last[0] == pytest.approx(last[1], abs=1e-3 * np.abs(last[0]).max()), run_of
    assert told.status == "ok"
    assert told.motions[0].tracking_rms[-1] < 1e-6
    off = np.linalg.norm(offset)
    assert untold.motions[0].tracking_rms[-1] == pytest.approx(off, rel=1e-4)
    # The tool of a person who looks at it is not on its path.
    assert untold.status == "not tracking"
    for words in ("reality.tool_offset", "36.1", "its own dimensions"):
        assert words in untold.message, untold.message


def test_what_is_measured_late_and_noisily_is_misjudged_too():
    reality = {"measurement_delay": 0.002, "encoder_noise": 1e-5, "control_period": 0.002}
    run = rmj.simulate(arm(reality | {"tool_offset": [0.003, 0.0, 0.0]}))
    assert run.status == "ok"
    speed = {}
    for motion in run.motions:
        dx = run.plan.desired(run.plan.schedule.index(motion.number - 1)).dx
        speed[motion.number] = np.sqrt((dx**2).sum(axis=1).mean())
        late = motion.tracking_rms[-1] ** 2 - 0.003**2
        assert late == pytest.approx((0.002 * speed[motion.number]) ** 2, rel=0.1)
        assert motion.torque_squared[-1] < 1.1 * motion.torque_squared_optimal


@pytest.mark.parametrize("lag", [0.2, 1.0])
@pytest.mark.parametrize("name", ["two-link-transfer", "seven-joint"])
def test_springs_that_lag_go_the_same_share_of_what_is_left_in_each_step(lag, name):
    run = rmj.simulate(arm({"stiffness_lag": lag}, name=name))
    dt, motion = run.experiment.simulation.timestep, run.motions[0]
    steps = run.plan.steps(0)
    k = run.data["stiffness"].values[3 * steps : 4 * steps]
    moved = np.diff(k, axis=0)
    some = np.abs(moved[0]) > 1e-6
    assert some.any()
    assert moved[1:, some] == pytest.approx(moved[:-1, some] * np.exp(-dt / lag), rel=1e-6)
    for motion in run.motions:
        assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)
        assert motion.tracking_rms[-1] < 1e-5
    # On the way the motors bear what the springs do not yet.
    assert run.motions[0].tracking_rms[6:].max() < 1e-3


@pytest.mark.parametrize(
    "reality",
    [
        {"stiffness_lag": 1.0, "spring_stiffening": 2.0},
        pytest.param({"stiffness_rate": 1.0, "spring_hysteresis": 0.1}, marks=pytest.mark.slow),
    ],
)
def test_springs_that_take_time_and_are_not_linear_come_to_the_best_of_their_kind(reality):
    run = rmj.simulate(arm(reality, 60))
    assert run.status == "ok"
    for motion in run.motions:
        assert motion.torque_squared[-1] <= 1.03 * motion.torque_squared_optimal
        assert motion.tracking_rms[-1] < 1e-4


def test_they_step_together_interpreted_and_by_differences_with_the_same_bits():
    reality = {"tool_offset": [0.001, 0.0, 0.002], "link_error": [0.01, -0.01]}
    asked = arm(reality | {"stiffness_lag": 0.3}, 3, **{"law.velocity": "difference"})
    whole = rmj.simulate(asked)
    together = rmj.simulate_many([arm({}, 3), asked])[1]
    for other in (together, rmj.simulate(asked, interpret=True)):
        for name in ("q", "tau", "stiffness", "x"):
            assert np.array_equal(other.data[name], whole.data[name])
    # It does not take itself to have jumped as the run begins.
    first = whole.data["tau"].values[0]
    ideal = rmj.simulate(arm({}, 3, **{"law.velocity": "difference"})).data["tau"].values[0]
    assert np.abs(first - ideal).max() < 0.5 * np.abs(ideal).max()


@pytest.mark.parametrize(
    ("reality", "words"),
    [
        ({"tool_offset": [0.1]}, ["reality.tool_offset"]),
        ({"tool_offset": [0.1, 0.0, 50.0]}, ["reality.tool_offset", "10"]),
        ({"link_error": [0.1, 0.1, 0.1]}, ["reality.link_error", "2 are needed"]),
        ({"link_error": -1.0}, ["reality.link_error", "greater than -1"]),
        ({"stiffness_lag": -0.1}, ["reality.stiffness_lag"]),
        ({"stiffness_lag": 0.1, "stiffness_rate": 1.0}, ["stiffness_lag = 0.1", "together"]),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(reality, words):
    with pytest.raises(ResonanceError) as caught:
        rmj.simulate(arm(reality, 2))
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


def test_a_law_that_acts_on_joint_angles_says_that_it_does_not_care():
    run = rmj.simulate(arm({"tool_offset": [0.01, 0, 0]}, 2, **{"law.kind": "joint-space"}))
    assert any("reality.tool_offset" in note and "no effect" in note for note in run.notes)
