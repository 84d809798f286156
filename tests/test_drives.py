"""Motors with a rate and a speed, stiffness that is set in steps, a base that leans."""

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.errors import ResonanceError
from resonance_mj.springs.fit import fit


def arm(reality, cycles=30, name="two-link-transfer", **changes):
    experiment = rmj.load(name)
    changes = {"law": {}, "springs": {}, "expect": {}, "reality": reality} | changes
    for index, motion in enumerate(experiment.motion):
        changes[f"motion.{index}.duration"] = cycles * motion.period
    return experiment.replace(changes)


def at_the_optimum(run):
    assert run.status == "ok", run.message
    for motion in run.motions:
        assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)
        assert motion.tracking_rms[-1] < 1e-5


def test_motors_change_their_torque_no_faster_than_they_can():
    rate = [3000.0, 1500.0]
    run = rmj.simulate(arm({"torque_rate": rate}))
    tau, dt = run.data["tau"].values, run.experiment.simulation.timestep
    steps = np.abs(np.diff(np.vstack([np.zeros(2), tau]), axis=0))
    assert (steps <= np.array(rate) * dt * (1 + 1e-9)).all()
    assert (steps.max(axis=0) > 0.99 * np.array(rate) * dt).all()  # as the first motion begins
    at_the_optimum(run)


def test_motors_that_turn_have_less_torque_in_the_direction_in_which_they_turn():
    most, fastest = 40.0, 6.0
    run = rmj.simulate(arm({"motor_torque": most, "motor_speed": fastest}))
    tau, dq = run.data["tau"].values, run.data["dq"].values
    left = most * np.maximum(1 - np.abs(dq) / fastest, 0.0)
    drives, brakes = tau * dq > 0, tau * dq < 0
    assert (np.abs(tau)[drives] <= left[drives] + 1e-9).all()
    assert (np.abs(tau)[drives] > 0.999 * left[drives]).any()
    assert np.abs(tau)[brakes].max() > left[brakes].min()
    at_the_optimum(run)


@pytest.mark.parametrize(
    "reality", [{"motor_torque": 20.0, "motor_speed": 4.0}, {"torque_rate": 300.0}]
)
def test_motors_that_are_too_slow_are_said_to_be(reality):
    run = rmj.simulate(arm(reality, 12))
    assert run.status in ("not tracking", "diverged")
    assert "motor gives less than it is asked for, by its rate or speed" in run.message


def test_stiffness_is_set_in_steps_and_the_optimum_is_the_best_of_these():
    step = 2.0
    run = rmj.simulate(arm({"stiffness_resolution": step}))
    k = run.data["stiffness_per_cycle"].values
    np.testing.assert_allclose(k, step * np.round(k / step), atol=1e-12)
    at_the_optimum(run)
    for index, best in enumerate(run.plan.optima):
        bounds = run.plan.gains.bounds._replace(resolution=0.0)
        free = fit(best.q, best.torque_without_springs, bounds, best.center)
        for j in range(2):
            costs = {}
            for k in (best.stiffness[j] - step, best.stiffness[j], best.stiffness[j] + step):
                if k < 0:
                    continue
                fixed = np.array([k, k])
                one = fit(
                    best.q,
                    best.torque_without_springs,
                    bounds._replace(stiffness=(fixed, fixed)),
                    best.center,
                )
                left = best.torque_without_springs - one.torque(best.q)
                costs[k] = (left[:, j] ** 2).mean()
            assert min(costs, key=costs.get) == best.stiffness[j], (index, j, free.stiffness)


def test_the_range_within_which_cost_hardly_changes_is_about_the_step_that_is_best():
    """At its ends torque² has risen by what is said, whichever side the best of all is on."""
    for step in (7.0, 11.0):
        _, best = rmj.optimum(arm({"stiffness_resolution": step}))
        bounds = best.bounds._replace(resolution=0.0)
        allowed = 0.01 * best.torque_squared_without_springs
        for j, ends in enumerate(best.stiffness_range(0.01)):
            assert ends[0] <= best.stiffness[j] <= ends[1] < 1e3
            for k in ends:
                fixed = best.stiffness.copy()
                fixed[j] = k
                within = bounds._replace(stiffness=(fixed, fixed))
                one = fit(best.q, best.torque_without_springs, within, best.center)
                left = ((best.torque_without_springs - one.torque(best.q)) ** 2).mean(axis=0)
                rise = left[j] - (best.torque[:, j] ** 2).mean()
                assert rise == pytest.approx(allowed, rel=0.02) or k == 0


def test_a_base_that_leans_has_gravity_from_the_side():
    """About x, and then y: as if gravity had been given by hand, to the last bit."""
    a, b = 0.3, -0.2
    down = np.array(rmj.simulate(arm({}, 2)).plan.robot.model.opt.gravity)
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    seen = np.linalg.inv(about_y @ about_x) @ down
    leans = rmj.simulate(arm({"base_tilt": [a, b]}, 2))
    by_hand = rmj.simulate(arm({}, 2, **{"simulation.gravity": seen.tolist()}))
    np.testing.assert_allclose(leans.plan.robot.model.opt.gravity, seen, atol=1e-12)
    np.testing.assert_allclose(leans.data["q"], by_hand.data["q"], atol=1e-7)
    assert np.abs(leans.data["tau"] - rmj.simulate(arm({}, 2)).data["tau"]).max() > 0.1


@pytest.mark.slow
def test_they_step_together_and_interpreted_with_the_same_bits():
    reality = {"torque_rate": 2000.0, "motor_torque": 40.0, "motor_speed": 6.0}
    asked = arm(reality | {"stiffness_resolution": 1.0}, 3)
    whole = rmj.simulate(asked)
    together = rmj.simulate_many([arm({}, 3), asked])[1]
    interpreted = rmj.simulate(asked, interpret=True)
    for other in (together, interpreted):
        for name in ("q", "tau", "stiffness"):
            assert np.array_equal(other.data[name], whole.data[name])


@pytest.mark.parametrize(
    ("reality", "words"),
    [
        ({"motor_speed": 5.0}, ["reality.motor_speed = 5.0", "reality.motor_torque"]),
        ({"torque_rate": 0.0}, ["reality.torque_rate", "greater than 0"]),
        ({"torque_rate": [1.0, 2.0, 3.0]}, ["reality.torque_rate", "2 are needed"]),
        ({"base_tilt": [4.0, 0.0]}, ["reality.base_tilt", "3.2"]),
        ({"base_tilt": [0.1]}, ["reality.base_tilt"]),
        ({"stiffness_resolution": -1.0}, ["reality.stiffness_resolution", "greater than 0"]),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(reality, words):
    with pytest.raises(ResonanceError) as caught:
        rmj.simulate(arm(reality, 2))
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []
