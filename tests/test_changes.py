"""Motions and payloads that change during a run: the law keeps what it knows, and recovers."""

import numpy as np
import pytest
from two_link import G, jacobian, jacobian_rate

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.motions.kinematics import JointMotion, Kinematics
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots.robot import build

ELLIPSE = {"period": 1.0, "center": [-0.3, 0.0], "size": [0.05, 0.1]}


def arm(*motions, **changes):
    """The paper's arm under the transfer law, with springs that a device could have."""
    values = [ELLIPSE | {"duration": 15.0} | dict(motion) for motion in motions]
    law = {"kind": "transfer"}
    springs = {"stiffness": [0.0, np.inf], "equilibrium": [-np.pi, np.pi]}
    plain = rmj.load("paper").replace({"law": {}, "springs": {}})
    plain = plain.replace({"law": law, "springs": springs})
    return plain.replace({"motion": values, **changes})


CHANGES = {
    "amplitude": {"size": [0.06, 0.12]},
    "period": {"period": 0.8, "duration": 12.0},
    "shape": {"shape": "eight", "size": [0.05, 0.08]},
    "payload": {"payload": 1.0},
}


@pytest.fixture(scope="module")
def changed():
    """A run per change: the ellipse, and then what the change makes of it."""
    return dict(
        zip(CHANGES, rmj.simulate_many([arm({}, CHANGES[name]) for name in CHANGES]), strict=True)
    )


def spring_torque(run):
    k, offset, q, center = (
        run.data[name].values for name in ("stiffness", "offset", "q", "center")
    )
    return offset - k * (q - center)


# What is kept, and what comes of it


@pytest.mark.parametrize("name", CHANGES)
def test_every_change_moves_the_optimum_and_the_law_reaches_it_again(changed, name):
    before, after = changed[name].summary()["segments"]
    distance = np.abs(np.subtract(after["stiffness_optimal"], before["stiffness_optimal"]))
    assert (distance > 0.02 * np.abs(before["stiffness_optimal"])).any()
    assert before["cycles_to_optimum"] <= 12
    assert after["cycles_to_optimum"] <= 12
    assert after["torque_squared"] == pytest.approx(after["torque_squared_optimal"], rel=0.05)
    np.testing.assert_allclose(after["stiffness"], after["stiffness_optimal"], rtol=0.1, atol=0.3)


@pytest.mark.parametrize("name", CHANGES)
def test_the_springs_do_not_jump_at_the_change(changed, name):
    """From one control step to the next their torque moves no more than within a cycle."""
    run = changed[name]
    steps = np.abs(np.diff(spring_torque(run), axis=0))
    boundary = int(np.argmax(run.data["cycle_of_sample"].values == 16)) - 1
    assert run.data["time"].values[boundary + 1] == pytest.approx(15.0)
    assert (steps[boundary] <= 1.5 * steps[boundary - 999 : boundary].max(axis=0)).all()


@pytest.mark.parametrize("name", CHANGES)
def test_springs_stay_within_their_bounds_through_a_change(changed, name):
    k, offset = (changed[name].data[key].values for key in ("stiffness", "offset"))
    assert (k >= 0).all()
    assert (np.abs(offset) <= np.pi * k * (1 + 1e-12)).all()


def test_what_is_learned_is_kept_at_the_same_phases_when_the_period_changes(changed):
    """The passage begins with the torque of the last cycle, but for what that cycle taught."""
    data = changed["period"].data
    u, cycle = data["u"].values, data["cycle_of_sample"].values
    last, first = u[cycle == 15], u[cycle == 16]
    assert (len(last), len(first)) == (1000, 800)
    phases = np.arange(800) / 800
    for j in range(2):
        kept = np.interp(phases, np.arange(1001) / 1000, np.append(last[:, j], last[0, j]))
        assert np.abs(first[:, j] - kept).max() < 0.05 * np.ptp(last[:, j])


@pytest.mark.parametrize("name", ["amplitude", "period"])
def test_keeping_what_is_known_is_better_than_starting_over(changed, name):
    kept = changed[name]
    over = rmj.simulate(arm(CHANGES[name]))
    first, again = over.summary()["segments"][0], kept.summary()["segments"][1]
    assert again["torque_squared_optimal"] == pytest.approx(first["torque_squared_optimal"])
    assert again["cycles_to_optimum"] < first["cycles_to_optimum"]
    here, there = kept.data["tracking_rms"].values[16:], over.data["tracking_rms"].values[1:]
    assert (here[:5] < 0.5 * there[:5]).all()


# The payload


def test_payload_is_a_point_mass_at_the_tool():
    """By virtual work: its torque is Jᵀ m (ẍ + g), in closed form."""
    robot = build(arm({"payload": 0.7}))
    rng = np.random.default_rng(1)
    q, dq, ddq = rng.normal(size=(3, 50, 2))
    motion = JointMotion(q, dq, ddq)
    more = Kinematics(robot.carrying(0.7)).torque(motion)
    more = more - Kinematics(robot.carrying(0.0)).torque(motion)
    J = jacobian(q)
    ddx = np.einsum("tij,tj->ti", J, ddq) + np.einsum("tij,tj->ti", jacobian_rate(q, dq), dq)
    force = 0.7 * (ddx + np.array([0.0, G]))
    np.testing.assert_allclose(more, np.einsum("tij,ti->tj", J, force), atol=1e-12)


def test_a_payload_of_zero_is_no_payload():
    without = rmj.simulate(arm({"duration": 3.0})).data
    data = rmj.simulate(arm({"duration": 3.0}, {"duration": 2.0, "payload": 2.0})).data
    for name in ("q", "tau", "stiffness"):
        mine = data[name].values[:3000]
        np.testing.assert_allclose(mine, without[name], rtol=1e-9, atol=1e-9)


def test_the_law_is_not_told_of_a_payload():
    """No number that it is tuned by or remembers at the start knows it."""
    light, heavy = (plan_for(arm({"payload": mass})) for mass in (0.0, 1.5))
    for name in ("feedback", "learning", "k_v", "k_p"):
        np.testing.assert_array_equal(getattr(heavy.gains, name), getattr(light.gains, name))
    assert heavy.optima[0].cost_without_springs > 1.5 * light.optima[0].cost_without_springs


def test_a_law_that_knows_the_robot_knows_the_payload():
    run = rmj.simulate(arm({"duration": 3.0}, {"payload": 1.0}, **{"law.kind": "computed-torque"}))
    for segment in run.summary()["segments"]:
        assert segment["tracking_rms"] < 1e-4
        assert segment["torque_squared"] == pytest.approx(
            segment["torque_squared_optimal"], rel=2e-3
        )


def test_robots_of_a_batch_carry_payloads_of_their_own(changed):
    experiments = [arm({"duration": 3.0}, {"duration": 3.0, "payload": mass}) for mass in (0.5, 2)]
    together = rmj.simulate_many(experiments)
    for experiment, run in zip(experiments, together, strict=True):
        alone = rmj.simulate(experiment)
        np.testing.assert_array_equal(run.data["tau"], alone.data["tau"])
    assert not np.allclose(together[0].data["tau"][-500:], together[1].data["tau"][-500:])


def test_a_tool_whose_body_the_compiler_would_merge_carries_its_payload(tmp_path):
    """With fusestatic the compiler makes bodies without a joint one with their parents."""
    path = tmp_path / "fused.xml"
    text = library.robots()["two_link.xml"].read_text(encoding="utf-8")
    path.write_text(text.replace("<compiler ", '<compiler fusestatic="true" ', 1))
    experiment = arm({"payload": 1.0}, **{"robot.mjcf": str(path)})
    (mine,) = rmj.optimum(experiment)
    (plain,) = rmj.optimum(arm({"payload": 1.0}))
    assert mine.cost == pytest.approx(plain.cost)


@pytest.mark.parametrize("mass", [-0.1, float("nan"), float("inf"), "heavy"])
def test_a_payload_that_is_none_is_refused_in_one_line(mass):
    with pytest.raises(rmj.ResonanceError) as caught:
        arm({"payload": mass})
    message = str(caught.value)
    assert "motion.0.payload" in message
    assert "\n" not in message


# What is picked up and put down within a cycle

PICKED = {"payload": [[0.2, 0.7, 1.5]]}


def test_the_torque_of_a_part_is_that_of_its_load():
    carried, light, heavy = (plan_for(arm({"payload": load})).needed(0) for load in (
        PICKED["payload"], 0.0, 1.5
    ))  # fmt: skip
    meanwhile = slice(200, 700)
    np.testing.assert_array_equal(carried[meanwhile], heavy[meanwhile])
    np.testing.assert_array_equal(np.delete(carried, meanwhile, 0), np.delete(light, meanwhile, 0))


def test_a_whole_cycle_s_part_is_a_payload_and_a_part_may_go_on_into_the_next_cycle():
    short = {"duration": 3.0}
    number = rmj.simulate(arm(short | {"payload": 1.5})).data
    whole = rmj.simulate(arm(short | {"payload": [[0.0, 1.0, 1.5]]})).data
    np.testing.assert_array_equal(whole["tau"], number["tau"])
    split = rmj.simulate(arm(short | {"payload": [[0.0, 0.25, 1.5], [0.75, 1.0, 1.5]]})).data
    wrapped = rmj.simulate(arm(short | {"payload": [[0.75, 1.25, 1.5]]})).data
    np.testing.assert_array_equal(wrapped["tau"], split["tau"])
    assert np.abs(wrapped["tau"] - number["tau"]).max() > 1.0


def test_springs_come_to_their_optimum_and_the_motors_bear_what_changes_at_once():
    run = rmj.simulate(arm(PICKED))
    assert run.status is rmj.Status.OK
    (motion,) = run.motions
    # The optimum is of the motion desired; where the load changes, the arm gives way a little.
    assert motion.share[-1] == pytest.approx(1.0, abs=3e-3)
    assert motion.tracking_rms[-1] < 2e-3
    # An independent look at what was recorded: (1) with the load of the moment, between the
    # steps at which it changes.
    plan = plan_for(run.experiment)
    last = {name: run.data[name].values[-1000:] for name in ("q", "dq", "tau")}
    ddq = np.gradient(last["dq"], 1e-3, axis=0)
    made = JointMotion(last["q"], last["dq"], ddq)
    exerted = last["tau"] + spring_torque(run)[-1000:]
    for mass, part in ((0.0, slice(10, 190)), (1.5, slice(210, 690)), (0.0, slice(710, 990))):
        needed = Kinematics(plan.robot.carrying(mass)).torque(made)
        np.testing.assert_allclose(exerted[part], needed[part], atol=0.02 * np.ptp(needed))


def test_batches_pick_up_and_put_down_at_times_of_their_own():
    loads = ([[0.2, 0.7, 1.5]], [[0.2, 0.7, 0.5]], [[0.1, 0.4, 1.0], [0.5, 0.9, 2.0]], 1.0)
    experiments = [arm({"duration": 3.0, "payload": load}) for load in loads]
    for experiment, run in zip(experiments, rmj.simulate_many(experiments), strict=True):
        alone = rmj.simulate(experiment)
        np.testing.assert_array_equal(run.data["tau"], alone.data["tau"])


def test_friction_rubs_whatever_is_carried():
    bare, rubbing = (
        plan_for(arm(PICKED, **({"reality.friction": 0.1} if rubs else {}))).needed(0)
        for rubs in (False, True)
    )
    more = np.abs(rubbing - bare).max(axis=0)
    np.testing.assert_allclose(more, 0.1 * np.abs(bare).max(axis=0), rtol=1e-6)


def test_a_run_that_picks_up_goes_on_from_a_checkpoint_with_the_same_bits(tmp_path):
    experiment, cycles = arm(PICKED | {"duration": 6.0}), []
    whole = rmj.simulate(experiment)

    def stop():
        cycles.append(0)
        return len(cycles) == 3

    rmj.simulate(experiment, stop=stop).save(tmp_path / "run")
    resumed = rmj.simulate(experiment, resume=rmj.Run.load(tmp_path / "run"))
    assert resumed.data.equals(whole.data)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ([[0.2, 0.7]], ["rows of three numbers"]),
        ([0.2, 0.7, 1.0], ["rows of three numbers"]),
        ([[0.7, 0.2, 1.0]], ["from 0.7 to 0.2 s"]),
        ([[1.0, 1.5, 1.0]], ["from 1 to 1.5 s", "period of 1 s"]),
        ([[0.2, 1.3, 1.0]], ["at most a period later"]),
        ([[0.2, 0.7, -1.0]], ["-1 kg"]),
        ([[0.2, 0.2004, 1.0]], ["payload", "0.2004 s", "no time step of 0.001 s"]),
        ([[0.2, 0.7, 1.0], [0.6, 0.9, 1.0]], ["put down at 0.7 s", "picked up at 0.6 s"]),
        ([[0.2, 0.7, 1.0], [0.8, 1.3, 1.0]], ["put down at 1.3 s", "picked up at 1.2 s"]),
    ],
)
def test_parts_that_are_none_are_refused_in_one_line(load, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        arm({"payload": load})
    message = str(caught.value)
    assert all(word in message for word in ["motion.0", *words]), message
    assert "\n" not in message
