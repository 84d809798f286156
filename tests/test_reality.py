"""Imperfections of a real arm are what they say, and the law finds its optimum in spite of them."""

import json
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.errors import ResonanceError
from resonance_mj.experiments.loading import for_robot
from resonance_mj.experiments.reality_section import PRESETS
from resonance_mj.laws import listening
from resonance_mj.motions.motion import sample
from resonance_mj.plan.plan import plan_for
from resonance_mj.results.cycles import kept
from resonance_mj.springs.fit import LinearSprings, fit

ARMS = Path(__file__).parents[1] / "benchmarks" / "random_arms.py"

DEFAULTS = {
    "motion.0.blend": None,
    "motion.1.blend": None,
    "law": {},
    "law.kind": "transfer",
}
"""The paper's arm and motions with default gains and passages."""


def arm(reality, name="two-link-transfer", cycles=60, **changes):
    experiment = rmj.load(name)
    if name == "two-link-transfer":
        changes = DEFAULTS | changes
    lasting = {
        f"motion.{i}.duration": cycles * motion.period for i, motion in enumerate(experiment.motion)
    }
    return experiment.replace({"reality": reality} | lasting | changes)


def feedback(reality, kind="feedback"):
    """A few cycles with feedback alone, of which every signal follows from the state."""
    return rmj.simulate(
        arm(
            reality,
            cycles=3,
            **{"law.kind": kind, "law.jacobian": "inverse", "law.velocity": "jacobian"},
        )
    )


def test_the_law_acts_on_what_was_a_delay_ago():
    run = feedback({"measurement_delay": 0.006})
    data, plan = run.data, run.plan
    alpha, D = plan.gains.alpha, 6
    x, x_d, q, dq = (data[name].values for name in ("x", "x_desired", "q", "dq"))
    dt = run.experiment.simulation.timestep
    start = 1500  # well inside the second cycle, where x_d is smooth
    for step in range(start, start + 200, 20):
        then = step - D
        J = plan.kinematics.jacobian(q[then])
        rate = J @ dq[then] - (x_d[step + 1] - x_d[step - 1]) / (2 * dt)
        y = np.linalg.solve(J, rate + alpha * np.sin(x[then] - x_d[step]))
        assert data["y"].values[step] == pytest.approx(y, rel=1e-3, abs=1e-3)


def test_motors_exert_what_was_asked_a_delay_ago():
    run = feedback({"torque_delay": 0.004})
    tau, y = run.data["tau"].values, run.data["y"].values
    asked = -y @ run.plan.gains.feedback.T
    assert np.allclose(tau[4:], asked[:-4], atol=1e-9)
    assert (tau[:4] == 0).all()


def test_torque_is_held_between_the_laws_own_steps():
    run = feedback({"control_period": 0.005})
    for name in ("tau", "y"):
        held = run.data[name].values.reshape(-1, 5, 2)
        assert (held == held[:, :1]).all()
        assert (np.diff(held[:, 0], axis=0) != 0).any(axis=1).mean() > 0.99


def measured(run):
    """The joint angles that a law of joint errors has seen, from its y = Δq̇ + α Δq."""
    data, alpha = run.data, run.plan.gains.alpha
    dt = run.experiment.simulation.timestep
    q_d = np.concatenate([run.plan.joint_motion(c).q for c in range(len(run.plan.schedule))])
    dq_d = np.concatenate([run.plan.joint_motion(c).dq for c in range(len(run.plan.schedule))])
    ddq_d = np.concatenate([run.plan.joint_motion(c).ddq for c in range(len(run.plan.schedule))])
    rate = data["dq"].values - (dq_d - dt / 2 * ddq_d)
    return q_d + np.arcsin((data["y"].values - rate) / alpha)


def joint_law(reality):
    law = {"law.kind": "computed-torque", "law.alpha": 50.0}
    return rmj.simulate(arm({"velocity": "sensor"} | reality, cycles=4, **law))


def test_encoder_noise_has_its_standard_deviation_and_is_white():
    run = joint_law({"encoder_noise": 2e-4})
    noise = measured(run) - run.data["q"].values
    assert noise.std(axis=0) == pytest.approx([2e-4, 2e-4], rel=0.03)
    assert np.abs(noise.mean(axis=0)).max() < 2e-5
    assert np.abs((noise[1:] * noise[:-1]).mean(axis=0)).max() < 0.05 * 4e-8


def test_encoders_have_steps():
    run = joint_law({"encoder_resolution": 1e-3})
    seen = measured(run) / 1e-3
    assert np.abs(seen - np.round(seen)).max() < 1e-4
    assert np.abs(measured(run) - run.data["q"].values).max() <= 5.0001e-4


def test_friction_is_a_share_of_the_peak_torque():
    without, rubbing = arm({}), arm({"friction": 0.2})
    ideal, real = rmj.optimum(without)[1], rmj.optimum(rubbing)[1]
    peaks = [np.abs(best.torque_without_springs).max(axis=0) for best in rmj.optimum(without)]
    # Dry friction is a square wave of its size, but for the soft flip that MuJoCo gives it.
    added = real.torque_without_springs - ideal.torque_without_springs
    assert np.median(np.abs(added), axis=0) == pytest.approx(0.2 * np.max(peaks, axis=0), rel=0.02)


def test_a_seed_gives_the_same_bits_alone_and_in_a_batch():
    each = [arm("lab", cycles=6, **{"reality.seed": seed}) for seed in (3, 4, 3)]
    one, other, same = rmj.simulate_many(each)
    alone = rmj.simulate(each[0])
    for name in alone.data.variables:
        assert np.array_equal(one.data[name], alone.data[name]), name
        assert np.array_equal(one.data[name], same.data[name]), name
    assert not np.array_equal(one.data["tau"], other.data["tau"])


def test_compiled_and_interpreted_agree_to_the_last_bit():
    experiment = arm({"preset": "cheap", "torque_delay": 0.003}, cycles=3)
    compiled, plain = rmj.simulate(experiment), rmj.simulate(experiment, interpret=True)
    for name in ("q", "tau", "y", "x"):
        assert np.array_equal(compiled.data[name], plain.data[name]), name


def share(run, index):
    """Of the reduction that springs can give, what those of the last cycle would give alone."""
    best, motion = run.plan.optima[index], run.motions[index]
    k, offset, center = motion.stiffness[-1], motion.offset[-1], motion.center[-1]
    left = best.torque_without_springs + k * (best.q - center) - offset
    without = best.torque_squared_without_springs
    saved = without - (left**2).sum(axis=1).mean()
    return saved / (without - best.torque_squared)


ROWS = {
    "lab": ("lab", 0.99, 0.98),
    "noise of 1e-3 rad": ({"encoder_noise": 1e-3}, 0.95, 0.80),
    "delay of 5 ms": ({"measurement_delay": 0.005}, 0.99, 0.95),
    "delay of 10 ms": ({"measurement_delay": 0.01}, 0.99, 0.90),
    "torque 10 ms late": ({"torque_delay": 0.01}, 0.99, 0.90),
    "cheap": ("cheap", 0.99, 0.95),
    "control at 100 Hz": ({"control_period": 0.01}, 0.99, 0.95),
}
"""What the arm has, the least share found, and the least reduction of what is possible."""


@pytest.mark.parametrize("name", ["two-link-transfer", "seven-joint"])
@pytest.mark.parametrize(
    "row",
    [
        *("lab", "noise of 1e-3 rad", "delay of 10 ms", "control at 100 Hz"),
        pytest.param("cheap", marks=pytest.mark.slow),
        pytest.param("delay of 5 ms", marks=pytest.mark.slow),
        pytest.param("torque 10 ms late", marks=pytest.mark.slow),
    ],
)
def test_the_law_finds_the_springs_of_a_real_arm_and_its_motors_give_little_more(row, name):
    reality, least_share, least_reduction = ROWS[row]
    run = rmj.simulate(arm(reality, name))
    for index, motion in enumerate(run.motions):
        if name == "two-link-transfer":
            assert share(run, index) >= least_share
        # In the mean of the last cycles: noise differs from one to the next.
        without = motion.torque_squared_without_springs
        reduction = 1 - motion.torque_squared[-5:].mean() / without
        assert reduction >= least_reduction * motion.torque_reduction_optimal
    judged(run)


def judged(run):
    """Recompute from the recorded signals what a run says of itself, and see that OK means it."""
    dt = run.experiment.simulation.timestep
    off = False
    for motion in run.motions:
        last = motion.samples.isel(
            time=motion.samples["cycle_of_sample"].values == motion.cycles[-1]
        )
        steps = round(motion.period / dt)
        assert last.sizes["time"] == steps
        miss = np.linalg.norm(last["x"].values - last["x_desired"].values, axis=1)
        rms = np.sqrt((miss**2).mean())
        assert rms == pytest.approx(motion.tracking_rms[-1], rel=1e-9)
        assert (last["tau"].values ** 2).sum(axis=1).mean() == pytest.approx(
            motion.torque_squared[-1], rel=1e-9
        )
        off |= rms > 0.02 * motion.size
    assert (run.status == "ok") == (not off)


@pytest.mark.parametrize("rate", [1.0, pytest.param(5.0, marks=pytest.mark.slow)])
def test_springs_that_take_time_arrive_at_the_optimum_and_never_jump(rate):
    run = rmj.simulate(arm({"stiffness_rate": rate}))
    dt = run.experiment.simulation.timestep
    moved = np.abs(np.diff(run.data["stiffness"].values, axis=0)).max()
    assert moved <= rate * dt * (1 + 1e-9)
    for motion in run.motions:
        assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.03)
        assert motion.tracking_rms[-1] < 1e-6
    # On the way tool and torque are as they would be: the motors bear what springs have not.
    assert run.data["tracking_rms"].values[5:60].max() < 1e-3


@pytest.mark.parametrize("payload", [pytest.param(2.0, marks=pytest.mark.slow), 4.0])
@pytest.mark.parametrize("name", ["two-link-transfer", "seven-joint"])
def test_a_payload_that_nobody_announced_settles_within_a_millimetre(payload, name):
    motions = len(rmj.load(name).motion)
    loads = {f"motion.{i}.payload": payload for i in range(motions)}
    run = rmj.simulate(arm({}, name, **loads))
    assert run.status == "ok"
    for motion in run.motions:
        assert motion.tracking_rms[-1] < 1e-3
        assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)


@pytest.mark.parametrize(
    "share_of_need",
    [pytest.param(0.9, marks=pytest.mark.slow), 0.7, pytest.param(0.5, marks=pytest.mark.slow)],
)
def test_motors_below_what_the_best_springs_leave_settle_and_are_said(share_of_need):
    (best,) = rmj.optimum(arm({}, "seven-joint"))
    limit = share_of_need * np.abs(best.torque).max(axis=0)
    run = rmj.simulate(arm({"motor_torque": np.maximum(limit, 0.01).tolist()}, "seven-joint"))
    (motion,) = run.motions
    assert np.ptp(motion.tracking_rms[-5:]) < 0.02 * motion.tracking_rms[-1]
    assert any("motor is at its limit" in note for note in run.notes)
    assert (np.abs(run.data["tau"].values).max(axis=0) <= limit + 1e-2 + 1e-12).all()
    # Along the motion made: of what springs could take of its torque, what these take.
    last = kept(run)[-1]
    acting = LinearSprings(last.stiffness, last.offset, last.center)
    total = last.tau + acting.torque(last.q)
    left = total - fit(last.q, total, run.plan.gains.bounds, last.center).torque(last.q)
    needed, given, possible = ((torque**2).sum() for torque in (total, last.tau, left))
    assert (needed - given) / (needed - possible) >= 0.95
    judged(run)


def test_what_was_found_of_the_loop_is_said():
    late = rmj.simulate(arm({"measurement_delay": 0.01}, "seven-joint"))
    assert any("the loop answers 0.01 s late" in note for note in late.notes)
    assert late.status == "not tracking"
    assert "reality.measurement_delay" in late.message
    noisy = rmj.simulate(arm({"encoder_noise": 1e-3}, "seven-joint", cycles=20))
    assert any("the error is noisy" in note for note in noisy.notes)
    heavy = rmj.simulate(arm({}, **{"motion.0.payload": 4.0, "motion.1.payload": 4.0}))
    assert any("heavier than its file" in note for note in heavy.notes)
    ideal = rmj.simulate(arm({}, cycles=10))
    assert not any("late" in note or "noisy" in note or "heavier" in note for note in ideal.notes)


def test_times_that_are_no_whole_steps_are_said():
    notes = plan_for(arm({"measurement_delay": 0.0024})).notes
    assert any("is simulated as 0.002 s" in note for note in notes)
    assert not any("simulated as" in note for note in plan_for(arm("lab")).notes)


def test_a_late_arm_that_is_lost_for_another_reason_is_not_said_to_be_late():
    weak = {"measurement_delay": 0.001, "motor_torque": 1.0}
    run = rmj.simulate(arm(weak, cycles=15))
    assert run.status != "ok"
    assert "by what was measured" not in run.message


def test_presets_and_keys_read_the_same_everywhere(tmp_path):
    named = rmj.load("paper").replace({"reality": "lab"})
    assert named.reality.measurement_delay == PRESETS["lab"]["measurement_delay"]
    more = rmj.load("paper").replace({"reality.preset": "lab", "reality.encoder_noise": 5e-4})
    assert more.reality.encoder_noise == 5e-4
    assert more.reality.friction == 0.01
    (tmp_path / "mine.toml").write_text(named.to_toml())
    assert rmj.load(tmp_path / "mine.toml").reality == named.reality
    lasting = ["--motion.0.duration", "6", "--motion.1.duration", "6"]
    options = ["--reality", "encoder", *lasting, "--out", str(tmp_path / "run"), "--quiet"]
    done = subprocess.run(
        [sys.executable, "-P", "-m", "resonance_mj.cli", "run", "two-link-transfer", *options],
        capture_output=True,
        text=True,
    )
    assert done.returncode in (0, 1), done.stderr
    kept = rmj.Run.load(tmp_path / "run").experiment.reality
    assert kept.encoder_resolution == PRESETS["encoder"]["encoder_resolution"]
    assert "Traceback" not in done.stderr
    json.loads((tmp_path / "run" / "summary.json").read_text())


@pytest.mark.parametrize(
    ("reality", "says"),
    [
        ("labb", "encoder, lab, cheap"),
        ({"encoder_noise": -1.0}, "reality.encoder_noise"),
        ({"delay": 0.1}, "unknown key"),
        ({"measurement_delay": 5.0}, "reality.measurement_delay"),
        ({"motor_torque": [1.0, 2.0, 3.0]}, "one per joint"),
        ({"control_period": 0.003}, "a whole number of control periods"),
        ({"control_period": 1.0, "measurement_delay": 2.0}, "reality.measurement_delay"),
    ],
)
def test_what_reality_cannot_be_is_refused_in_one_line(reality, says):
    with pytest.raises(ResonanceError) as error:
        rmj.optimum(arm(reality))
    assert says in str(error.value)
    assert "\n" not in str(error.value)


# What a late loop bears


def test_feedback_of_a_late_loop_is_as_strong_as_asked_in_the_mean_over_the_motion(tmp_path):
    """M̂ is the M whose inverse is the mean of M⁻¹: that of M⁻¹ M̂ along the motion is 1."""
    (tmp_path / "arm.xml").write_text(runpy.run_path(str(ARMS))["mjcf"](np.random.default_rng(7)))
    light = for_robot(str(tmp_path / "arm.xml"))
    plan, ideal = plan_for(light.replace({"reality": "lab"})), plan_for(light)
    M = [plan.kinematics.inertia(q) for q in along(plan)]
    strength, usual = (
        np.linalg.solve(M, np.broadcast_to(one, (len(M), 7, 7)))
        for one in (plan.gains.inertia, plan.robot.inertia)
    )
    np.testing.assert_allclose(strength.mean(axis=0), np.eye(7), atol=1e-9)
    strongest, at_home = (np.linalg.eigvals(each).real.max() for each in (strength, usual))
    assert strongest < 0.5 * at_home
    # An ideal loop bears more, and has that of the joint motion where home's would be too much.
    q = ideal.joints[0].q
    inverse = [np.linalg.inv(ideal.kinematics.inertia(each)) for each in q[:: len(q) // 16]]
    mean = np.linalg.inv(np.mean(inverse, axis=0))
    np.testing.assert_allclose(ideal.gains.inertia, mean, rtol=1e-9)
    paper = plan_for(rmj.load("seven-joint").replace({"law": {}}))
    np.testing.assert_array_equal(paper.gains.inertia, paper.robot.inertia)


@pytest.mark.parametrize("number", [525, pytest.param(194, marks=pytest.mark.slow)])
def test_an_ideal_arm_that_is_light_in_some_pose_comes_to_its_optimum(number, tmp_path):
    """By the inertia of its home pose the feedback is 8 to 15 times as strong as asked."""
    (tmp_path / "arm.xml").write_text(
        runpy.run_path(str(ARMS))["mjcf"](np.random.default_rng(number))
    )
    run = rmj.simulate(for_robot(str(tmp_path / "arm.xml")).replace({"motion.0.duration": 25.0}))
    assert run.status == "ok"
    assert run.motions[0].cycles_to_optimum <= 15
    assert run.motions[0].tracking_rms[-1] < 1e-3


def along(plan):
    """Joint angles with the tool at sixteen points of its path, each the nearest to the last."""
    (motion,) = plan.experiment.motion
    points = sample(motion, 48, plan.robot).x
    q, found = plan.kinematics.solve(points.mean(axis=0), plan.robot.home), []
    for x in points[::3]:
        q = plan.kinematics.solve(x, q)
        found.append(q)
    return found


@pytest.mark.parametrize("number", [7, 20])
def test_arms_that_are_light_in_some_pose_come_to_their_optimum_in_a_laboratory(number, tmp_path):
    """Seven joints about random axes, whose M⁻¹ M(home) goes up to 13 along the motion."""
    text = runpy.run_path(str(ARMS))["mjcf"](np.random.default_rng(number))
    (tmp_path / "arm.xml").write_text(text)
    run = rmj.simulate(
        for_robot(str(tmp_path / "arm.xml")).replace({"motion.0.duration": 40.0, "reality": "lab"})
    )
    assert run.status is rmj.Status.OK, run.message
    assert run.motions[0].share[-1] > 0.99


@pytest.mark.slow
def test_a_motion_that_follows_another_grows_where_the_loop_is_late():
    def passages(**changes):
        return [one.blend for one in plan_for(arm({}, **changes)).experiment.motion]

    assert passages() == [1, 1]
    for key in ("encoder_noise", "measurement_delay", "control_period"):
        assert passages(**{f"reality.{key}": 0.002}) == [1, 12], key
    assert passages(**{"reality.friction": 0.1}) == [1, 1]
    late = {"reality.torque_delay": 0.002}
    assert passages(**late, **{"motion.1.blend": 1}) == [1, 1]
    assert passages(**late, **{"law.kind": "feedback"}) == [1, 1]
    assert passages(**late, **{"motion.1.duration": 8.0}) == [1, 4]
    run = rmj.simulate(arm("lab", cycles=24))
    away = run.motions[1].tracking_rms
    assert away.max() < 0.1 * run.motions[1].size
    # And one that goes on from a run of another motion.
    first, second = (
        arm("lab", cycles=24).replace({"motion": [one.model_dump(exclude_unset=True)]})
        for one in rmj.load("two-link-transfer").replace(DEFAULTS).motion
    )
    after = rmj.simulate(second, after=rmj.simulate(first))
    assert after.experiment.motion[0].blend == 12


def test_no_spring_has_a_joint_swing_faster_than_a_late_loop_can_damp():
    period = 0.005
    plan = plan_for(rmj.load("seven-joint").replace({"reality.control_period": period}))
    most = np.broadcast_to(plan.gains.bounds.stiffness[1], 7)
    # Of a joint alone, the others free: ω² = k (M⁻¹)_jj.
    swings = np.sqrt(most * np.diag(np.linalg.inv(plan.robot.inertia)))
    np.testing.assert_allclose(swings, 0.2 / period)
    assert not any("at most" in line for line in plan.notes)  # the best springs are below
    ideal = plan_for(rmj.load("seven-joint"))
    assert np.isinf(ideal.gains.bounds.stiffness[1]).all()


def test_it_is_said_where_a_late_loop_asks_for_softer_springs_than_the_best():
    plan = plan_for(arm({"control_period": 0.02}))
    line = next(line for line in plan.notes if "at most" in line)
    assert "control period of 0.02 s" in line
    unlimited = plan_for(arm({}))
    best, found = (max(o.stiffness[0] for o in one.optima) for one in (unlimited, plan))
    assert found < best


@pytest.mark.parametrize("name", ["two-link-transfer", "seven-joint"])
def test_learning_that_was_calmed_without_need_goes_faster_again(name, monkeypatch):
    """A tenth of its pace would take it more than these 40 cycles to the optimum."""
    begun = listening.begun
    monkeypatch.setattr(listening, "begun", lambda *given: begun(*given)._replace(pace=0.1))
    changes = {f"motion.{i}.duration": 40.0 for i in range(len(rmj.load(name).motion))}
    run = rmj.simulate(rmj.load(name).replace({"law": {}, "expect": {}} | changes))
    for motion in run.motions:
        assert motion.cycles_to_optimum <= 30
        assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)
    assert not any("10\u202f% of its pace" in note for note in run.notes)
