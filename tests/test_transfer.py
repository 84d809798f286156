"""Transfer between two cycles: the spring takes over, the total torque stays as it is."""

import math
from collections import namedtuple

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.experiments.springs_section import Springs
from resonance_mj.laws import learning
from resonance_mj.springs import spring as springs
from resonance_mj.springs.fit import LinearSprings, fit

Found = namedtuple("Found", "u stiffness offset center")

UNBOUNDED = ((-math.inf, math.inf), (-math.inf, math.inf))
PHYSICAL = ((0.0, math.inf), (-math.pi, math.pi))


def cycle(seed, n=3, steps=200):
    """Signals of a cycle and springs at its end."""
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * np.arange(steps)[:, None] / steps
    q = rng.normal(size=n) + sum(
        rng.normal(size=n) * np.sin(h * phase + rng.uniform(0, 6, n)) / h for h in (1, 2, 3)
    )
    u, y = rng.normal(size=(2, steps, n))
    k, offset, center = rng.uniform(0, 5, n), rng.normal(size=n), rng.normal(size=n)
    return u, y, q, k, offset, center


def transfer(signals, bounds=UNBOUNDED, **options):
    u, y, q, *springs = signals
    gain = np.diag(np.linspace(0.5, 2.0, u.shape[1]))
    options = {"gain": gain, "lead": 1, "harmonics": None} | options
    v = learning.learned_torque(u, y, **options)
    u, springs = learning.transfer(
        v,
        q,
        LinearSprings(*springs),
        Springs.model_construct(stiffness=bounds[0], equilibrium=bounds[1]),
    )
    return Found(u, *springs), options


@pytest.mark.parametrize("bounds", [UNBOUNDED, PHYSICAL])
@pytest.mark.parametrize("harmonics", [None, 5])
@pytest.mark.parametrize("seed", range(5))
def test_motor_and_spring_together_exert_what_they_would_have_without_transfer(
    seed, harmonics, bounds
):
    u, y, q, k, offset, center = cycle(seed)
    found, options = transfer((u, y, q, k, offset, center), bounds, harmonics=harmonics)
    learned = learning.low_pass(u - learning.corrected(y, options["gain"], 1), harmonics)
    before = learned + springs.torque(k, offset, q, center)
    after = found.u + springs.torque(found.stiffness, found.offset, q, found.center)
    np.testing.assert_allclose(after, before, atol=1e-11)


@pytest.mark.parametrize("seed", range(5))
def test_without_bounds_nothing_that_a_spring_could_exert_is_left_to_the_motor(seed):
    u, y, q, *rest = cycle(seed)
    found, _ = transfer((u, y, q, *rest))
    np.testing.assert_allclose(found.u.mean(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose((found.u * (q - q.mean(axis=0))).mean(axis=0), 0, atol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_bounded_springs_stay_within_what_they_can_do(seed):
    found, _ = transfer(cycle(seed), PHYSICAL)
    k, offset = found.stiffness, found.offset
    assert (k >= 0).all()
    assert (np.abs(offset) <= k * math.pi * (1 + 1e-12)).all()


def test_bounded_springs_leave_the_least_torque_that_the_bounds_allow():
    """No other feasible spring would leave less torque², by a search around each joint's."""
    u, y, q, k, offset, center = cycle(7)
    found, options = transfer((u, y, q, k, offset, center), PHYSICAL)
    mean = q.mean(axis=0)
    total = u - learning.corrected(y, options["gain"], 1) + springs.torque(k, offset, q, center)
    rng = np.random.default_rng(0)
    for j in range(len(k)):
        left = (found.u[:, j] ** 2).mean()
        for _ in range(500):
            other = abs(found.stiffness[j] + rng.normal())
            push = other * rng.uniform(-math.pi, math.pi)
            tau = total[:, j] - springs.torque(other, push, q[:, j], mean[j])
            assert (tau**2).mean() >= left - 1e-12


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("most", [3.0, math.inf])
def test_springs_that_meet_their_bounds_leave_the_least_torque_along_them(seed, most):
    """Against the least torque² for each stiffness of a fine grid, with the best offset for it."""
    bounds = ((0.5, most), (-0.2, 0.1))
    u, y, q, k, offset, center = cycle(seed)
    found, options = transfer((u, y, q, k, offset, center), bounds)
    mean = q.mean(axis=0)
    total = u - learning.corrected(y, options["gain"], 1) + springs.torque(k, offset, q, center)
    met = 0
    for j in range(len(k)):
        stiffness = np.linspace(0.5, min(most, 30.0), 2001)
        push = np.clip(total[:, j].mean(), -0.2 * stiffness, 0.1 * stiffness)
        z = q[:, j] - mean[j]
        left = total[:, j, None] + stiffness * z[:, None] - push
        least = (left**2).mean(axis=0).min()
        assert (found.u[:, j] ** 2).mean() <= least * (1 + 1e-9)
        assert bounds[0][0] <= found.stiffness[j] <= most
        at = found.offset[j] / found.stiffness[j]
        met += np.isclose(at, (-0.2, 0.1)).any()
    assert met  # an edge of the cone, where stiffness and offset depend on each other


@pytest.mark.parametrize("steps", [240, 241])
def test_low_pass_of_all_harmonics_is_the_torque_itself_whatever_the_number_of_samples(steps):
    v = np.random.default_rng(steps).normal(size=(steps, 2))
    assert learning.low_pass(v, steps // 2) is v
    for harmonics in (1, 100, steps // 2 - 1):
        kept = learning.low_pass(v, harmonics)
        assert kept.shape == v.shape
        spectrum, given = np.fft.rfft(kept, axis=0), np.fft.rfft(v, axis=0)
        np.testing.assert_allclose(
            spectrum[: harmonics + 1], given[: harmonics + 1], rtol=0, atol=1e-11
        )
        np.testing.assert_allclose(spectrum[harmonics + 1 :], 0.0, rtol=0, atol=1e-11)


def test_low_pass_keeps_the_first_harmonics_in_phase_and_nothing_else():
    steps = 240
    phase = 2 * np.pi * np.arange(steps)[:, None] / steps
    kept = 0.3 + np.sin(3 * phase + 0.4) + 0.2 * np.cos(5 * phase)
    np.testing.assert_allclose(
        learning.low_pass(kept + np.sin(6 * phase) + np.cos(40 * phase), 5), kept, atol=1e-12
    )
    assert learning.low_pass(kept, None) is kept


def test_the_default_law_reaches_the_optimum_of_the_papers_arm_and_stays():
    """A fixed point of the transfer is the optimum: what is left is orthogonal to q and to 1."""
    run = rmj.simulate(
        rmj.load("paper").replace(
            {
                "law": {},
                "law.kind": "transfer",
                "motion.0.blend": 1,
                "motion.0.duration": 25.0,
                "motion.1.blend": 1,
                "motion.1.duration": 25.0,
            }
        )
    )
    for segment in run.summary()["segments"]:
        assert segment["cycles_to_optimum"] <= 12
        np.testing.assert_allclose(segment["stiffness"], segment["stiffness_optimal"], rtol=0.02)
        assert segment["tracking_rms"] < 0.5e-3


def test_a_joint_that_stands_still_gives_up_its_stiffness_and_keeps_its_torque():
    """Torque over angle is arbitrary there: only the offset is handed over."""
    phase = 2 * np.pi * np.arange(100)[:, None] / 100
    q, u = 1e-6 * np.sin(phase), 3.0 + np.sin(phase)
    k, offset, center = np.array([5.0]), np.array([0.25]), np.array([0.0])
    found, _ = transfer((u, np.zeros_like(u), q, k, offset, center))
    np.testing.assert_array_equal(found.stiffness, 0.0)
    np.testing.assert_allclose(found.offset, 3.25)
    before = u + offset - k * (q - center)
    after = found.u + found.offset - found.stiffness * (q - found.center)
    np.testing.assert_allclose(after, before, atol=1e-12)


# The fit that the transfer, the optimum and the certificates share


def test_springs_about_another_centre_exert_the_same_torque():
    _, _, q, *given = cycle(0)
    acting = LinearSprings(*given)
    np.testing.assert_allclose(acting.about(given[2] + 0.7).torque(q), acting.torque(q), atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_equilibrium_angles_are_bounded_about_the_centre_that_is_asked_for(seed):
    """Far from the mean angle too: of all springs within the bounds none leaves less torque."""
    u, _, q, *_ = cycle(seed)
    center = q.mean(axis=0) + np.array([-0.4, 0.0, 0.9])
    reach = (-0.2, 0.6)
    bounds = Springs.model_construct(stiffness=(0.5, 4.0), equilibrium=reach)
    torque = u - 2.0 * q
    best = fit(q, torque, bounds, center)
    np.testing.assert_array_equal(best.center, center)
    within = best.offset / best.stiffness
    assert (within >= reach[0] - 1e-12).all()
    assert (within <= reach[1] + 1e-12).all()
    left = ((torque - best.torque(q)) ** 2).sum(axis=0)
    for k in np.linspace(0.5, 4.0, 15):
        for angle in np.linspace(*reach, 15):
            other = LinearSprings(np.full(3, k), np.full(3, k * angle), center)
            assert (left <= ((torque - other.torque(q)) ** 2).sum(axis=0) + 1e-9).all()


def test_a_joint_that_stands_still_gets_no_stiffness_beside_others_that_move():
    u, _, q, *_ = cycle(0)
    q[:, 1] = 0.3 + 1e-6 * np.sin(np.arange(len(q)))
    free = Springs.model_construct(stiffness=UNBOUNDED[0], equilibrium=UNBOUNDED[1])
    k = fit(q, u - 2.0 * q, free, np.zeros(3)).stiffness
    assert k[1] == 0
    assert (np.abs(k[[0, 2]]) > 0.1).all()


RANGE = {
    "springs.stiffness": [0.0, math.inf],
    "springs.equilibrium": [-2.0, 2.5],
    "springs.equilibrium_about": "zero",
}
"""A device's: of the joint's own angle, wherever that moves."""


def test_transfer_ends_at_the_optimum_within_a_range_of_the_joints_own_angle():
    experiment = rmj.load("two-link-transfer")
    second = experiment.motion[1].model_dump() | {"duration": 25.0}
    run = rmj.simulate(experiment.replace(RANGE | {"motion": [second]}))
    found, best = run.summary()["segments"][0], run.data.isel(segment=0)
    np.testing.assert_allclose(found["stiffness"], found["stiffness_optimal"], rtol=0.01)
    assert found["torque_squared"] == pytest.approx(found["torque_squared_optimal"], rel=0.02)
    assert best["equilibrium_optimal"].values[0] == pytest.approx(2.5, abs=1e-9)
    assert run.data["equilibrium"].values[-1, 0] == pytest.approx(2.5, abs=1e-9)
    acts = run.data["stiffness"].values[:, 0] > 0
    assert run.data["equilibrium"].values[acts, 0].max() < 2.5 + 1e-9


@pytest.mark.parametrize("q_c", ["mean", "running", [-0.5, -2.0]])
def test_adaptation_stays_within_a_range_of_the_joints_own_angle_wherever_q_c_is(q_c):
    experiment = rmj.load("paper")
    motion = experiment.motion[1].model_dump() | {"duration": 6.0}
    changes = {"motion": [motion], "law.q_c": q_c, "springs.stiffness": [1.0, 40.0]}
    changes |= {"law.gamma_k": 40.0, "law.gamma_qe": 40.0}
    data = rmj.simulate(experiment.replace(RANGE | changes)).data
    q_e = data["equilibrium"].values
    assert ((q_e >= -2.0 - 1e-9) & (q_e <= 2.5 + 1e-9)).all()
    assert np.isclose(q_e, 2.5).any()
    free = rmj.simulate(experiment.replace(RANGE | changes | {"springs.equilibrium": [-9.0, 9.0]}))
    assert free.data["equilibrium"].values.max() > 2.5


def test_springs_told_to_begin_beyond_a_range_of_the_joints_own_angle_are_refused_with_it():
    inside = rmj.load("two-link-transfer").replace(RANGE | {"springs.initial_stiffness": 2.0})
    inside = inside.replace({"motion.0.duration": 2.0, "motion.1.duration": 2.0})
    inside = inside.replace({"springs.initial_equilibrium": [2.4, -1.9]})
    start = rmj.simulate(inside).data["equilibrium"].values[0]
    np.testing.assert_allclose(start, [2.4, -1.9])
    for angles in ([2.6, -1.9], [2.4, -2.1]):
        outside = inside.replace({"springs.initial_equilibrium": angles})
        with pytest.raises(rmj.ResonanceError, match=r"springs\.equilibrium: -2 to 2\.5$"):
            rmj.simulate(outside)
