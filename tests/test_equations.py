"""The functions that are the paper's mathematics, against the paper written out in NumPy."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from resonance_mj.laws import equations, learning
from resonance_mj.springs import spring as springs

# Repeatable: the same examples in every run.
repeatable = settings(deadline=None, derandomize=True, database=None)

seeds = st.integers(0, 2**32 - 1)
joints = st.integers(1, 7)
numbers = st.floats(-1e3, 1e3).filter(lambda v: v == 0 or abs(v) > 1e-6)


# (4) to (8)


@repeatable
@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=7))
def test_saturation_is_the_sine_up_to_a_quarter_turn_and_one_beyond(errors):
    error, s = np.array(errors), np.empty(len(errors))
    equations.saturation(error, s)
    as_printed = np.where(
        error > np.pi / 2, 1, np.where(error < -np.pi / 2, -1, np.sin(np.clip(error, -2, 2)))
    )
    np.testing.assert_allclose(s, as_printed, rtol=1e-15, atol=0)


def test_saturation_is_odd_never_falls_and_has_slope_one_at_zero():
    error = np.arange(-4000, 4001) / 1000
    s = np.empty_like(error)
    equations.saturation(error, s)
    np.testing.assert_array_equal(s, -s[::-1])
    assert (np.diff(s) >= 0).all()
    assert (s[4001] - s[3999]) / (error[4001] - error[3999]) == pytest.approx(1, abs=1e-6)


def arm(seed, n, m=None):
    """A random Jacobian, errors and gains of an arm with n joints and m coordinates."""
    rng = np.random.default_rng(seed)
    m = n if m is None else m
    J = rng.normal(size=(m, n)) + 2 * np.eye(m, n)
    return rng, J, rng.normal(size=m), rng.normal(size=m)


@repeatable
@given(seeds, joints, joints)
def test_motor_torque_is_4(seed, n, m):
    rng, J, rate, s = arm(seed, n, m)
    k_v, k_p, u = rng.uniform(0, 300, m), rng.uniform(0, 3000, m), rng.normal(size=n)
    tau = np.empty(n)
    equations.motor_torque(J, k_v, k_p, rate, s, u, tau)
    as_printed = -J.T @ (np.diag(k_v) @ rate + np.diag(k_p) @ s) + u
    np.testing.assert_allclose(tau, as_printed, rtol=1e-12, atol=1e-9)


@repeatable
@given(seeds, joints)
def test_stiffness_and_offset_rates_are_6_and_7(seed, n):
    rng = np.random.default_rng(seed)
    gamma_k, gamma_qe, q, q_c, y = rng.normal(size=(5, n))
    each = zip(gamma_k, gamma_qe, q, q_c, y, strict=True)
    rates, offsets = zip(*(equations.spring_rates(*one) for one in each), strict=True)
    np.testing.assert_allclose(
        rates, np.diag(gamma_k) @ (np.diag(q) - np.diag(q_c)) @ y, rtol=1e-14
    )
    np.testing.assert_allclose(offsets, -np.diag(gamma_qe) @ y, rtol=1e-15)


@repeatable
@given(seeds, joints, st.floats(0, 100))
def test_error_signal_is_8(seed, n, alpha):
    _, J, rate, s = arm(seed, n)
    y, before = np.empty(n), J.copy()
    equations.error_inverse(J, rate, alpha, s, np.empty((n, n)), y)
    scale = np.linalg.cond(J) * np.abs(rate + alpha * s).max()
    np.testing.assert_allclose(J @ y, rate + alpha * s, atol=1e-13 * scale)
    np.testing.assert_allclose(
        y, np.linalg.inv(J) @ (rate + alpha * s), rtol=1e-12 * np.linalg.cond(J), atol=1e-13 * scale
    )
    np.testing.assert_array_equal(J, before)


@repeatable
@given(seeds, joints, joints, st.floats(0, 100))
def test_error_signal_with_the_transpose_is_that_of_sec_6c(seed, n, m, alpha):
    _, J, rate, s = arm(seed, n, m)
    y = np.empty(n)
    equations.error_transpose(J, rate, alpha, s, y)
    np.testing.assert_allclose(y, J.T @ (rate + alpha * s), rtol=1e-12, atol=1e-12 * (1 + alpha))


@pytest.mark.parametrize("n", range(2, 8))
def test_error_signal_needs_no_pivot_on_the_diagonal(n):
    """J is a cyclic permutation: elimination without exchanging rows would divide by zero."""
    J = np.roll(np.eye(n), 1, axis=1)
    rate, y = np.arange(1.0, n + 1), np.empty(n)
    equations.error_inverse(J, rate, 0.0, np.zeros(n), np.empty((n, n)), y)
    np.testing.assert_array_equal(y, J.T @ rate)


@pytest.mark.parametrize("n", range(1, 8))
def test_error_signal_of_a_singular_pose_is_not_finite(n):
    y = np.empty(n)
    J = np.ones((n, n)) if n > 1 else np.zeros((1, 1))
    equations.error_inverse(J, np.ones(n), 1.0, np.ones(n), np.empty((n, n)), y)
    assert not np.isfinite(y).any()


# The springs


@repeatable
@given(numbers, numbers, st.floats(-7, 7), st.floats(-7, 7))
def test_spring_to_write_exerts_the_torque_of_its_stiffness_and_offset(k, offset, q, q_c):
    """-k (q - q_e) = -k (q - q_c) + q̄_e, Sec. IV-B, also where only k = 0 could not push."""
    written, q_e = springs.equilibrium(k, offset, q_c)
    wanted = -k * (q - q_c) + offset
    scale = abs(k) * (abs(q) + abs(q_c)) + abs(offset)
    assert -written * (q - q_e) == pytest.approx(wanted, rel=1e-12, abs=1e-12 * scale + 1e-10)
    assert springs.torque(k, offset, q, q_c) == pytest.approx(wanted, rel=1e-12, abs=1e-12 * scale)


def test_spring_without_stiffness_and_offset_is_none():
    assert springs.equilibrium(0.0, 0.0, 1.3) == (0.0, 1.3)


def random_polygon(rng):
    """Bounds (k_min, k_max, low, high): with or without an apex, an upper bound, both signs."""
    k_min = rng.choice([0.0, rng.uniform(0, 20)])
    k_max = rng.choice([math.inf, k_min + rng.uniform(0.1, 50)])
    low = rng.uniform(-4, 4)
    return k_min, k_max, low, low + rng.uniform(0.05, 4)


def random_pair(rng, polygon):
    """A pair (k, q̄_e): inside the polygon, on its boundary, or beyond any edge or corner."""
    k_min, k_max, low, high = polygon
    along, across = rng.choice([0, 1, rng.uniform(-1, 0), rng.random(), rng.uniform(1, 2)], 2)
    k = k_min + along * (min(k_max, k_min + 50) - k_min)
    inside = min(max(k, k_min), k_max)
    beyond = min(across, 0.0) + max(across - 1, 0.0)  # so that also the apex has a neighbourhood
    return k, inside * (low + across * (high - low)) + beyond


def random_projection(seed):
    """A polygon, a pair, a feasible pair and a weight."""
    rng = np.random.default_rng(seed)
    k_min, k_max, low, high = polygon = random_polygon(rng)
    k = k_min + rng.random() * (min(k_max, k_min + 50) - k_min)
    feasible = k, k * (low + rng.random() * (high - low))
    return polygon, random_pair(rng, polygon), feasible, 10 ** rng.uniform(-2, 2)


weights = st.floats(1e-2, 1e2)


def is_feasible(k, offset, k_min, k_max, low, high, rounding=0.0):
    return k_min <= k <= k_max and k * low - rounding * k <= offset <= k * high + rounding * k


def squared_distance(a, b, weight):
    return weight * (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2


@repeatable
@given(seeds)
def test_nearest_spring_is_feasible_and_projecting_again_changes_nothing(seed):
    polygon, pair, _, weight = random_projection(seed)
    once = springs.nearest(*pair, *polygon, weight)
    assert is_feasible(*once, *polygon)
    assert springs.nearest(*once, *polygon, weight) == once


@repeatable
@given(seeds)
def test_spring_within_the_bounds_is_its_own_nearest(seed):
    polygon, _, feasible, weight = random_projection(seed)
    assert springs.nearest(*feasible, *polygon, weight) == feasible


@repeatable
@given(seeds)
def test_nearest_spring_is_nearer_to_every_feasible_one(seed):
    """The property of a projection on a convex set that keeps (16) a Lyapunov function."""
    polygon, pair, feasible, weight = random_projection(seed)
    nearest = springs.nearest(*pair, *polygon, weight)
    before = squared_distance(pair, feasible, weight)
    gone = squared_distance(pair, nearest, weight)
    after = squared_distance(nearest, feasible, weight)
    # The stronger form: the three points make an angle of at least 90 degrees at the nearest one.
    assert after + gone <= before + 1e-9 * (1 + before)


@repeatable
@given(seeds)
def test_nearest_spring_is_the_minimum_over_the_polygon(seed):
    """Against a search along every edge, if the spring is not feasible itself."""
    polygon, pair, _, weight = random_projection(seed)
    found = squared_distance(pair, springs.nearest(*pair, *polygon, weight), weight)
    if is_feasible(*pair, *polygon):
        assert found == 0.0
        return
    k_min, k_max, low, high = polygon
    far = min(k_max, 3000.0)  # beyond the nearest spring of any pair above
    edges = [
        ((k_min, k_min * low), (far, far * low)),
        ((k_min, k_min * high), (far, far * high)),
        ((k_min, k_min * low), (k_min, k_min * high)),
        ((far, far * low), (far, far * high)),
    ]
    share = np.linspace(0, 1, 5_001)
    searched = min(
        (
            weight * (a[0] + share * (b[0] - a[0]) - pair[0]) ** 2
            + (a[1] + share * (b[1] - a[1]) - pair[1]) ** 2
        ).min()
        for a, b in edges
    )
    assert found <= searched * (1 + 1e-12) + 1e-12
    # The search's own error is a step along an edge at most.
    step = max(math.sqrt(squared_distance(a, b, weight)) for a, b in edges) / 5_000
    assert math.sqrt(searched) <= math.sqrt(found) + step


@pytest.mark.parametrize("along", [-0.5, 0.5, 1.5])
@pytest.mark.parametrize("across", [-0.5, 0.5, 1.5])
@pytest.mark.parametrize("seed", [0, 1])
def test_nearest_spring_is_what_a_constrained_minimiser_finds(along, across, seed):
    """From inside, and from beyond each edge and corner."""
    rng = np.random.default_rng(seed)
    k_min, low, weight = rng.uniform(1, 5), rng.uniform(-3, 1), rng.uniform(0.1, 10)
    k_max, high = k_min + rng.uniform(1, 20), low + rng.uniform(0.5, 3)
    k = k_min + along * (k_max - k_min)
    pair = k, min(max(k, k_min), k_max) * (low + across * (high - low))
    constraints = [
        {"type": "ineq", "fun": lambda p: p[1] - low * p[0]},
        {"type": "ineq", "fun": lambda p: high * p[0] - p[1]},
    ]
    searched = minimize(
        lambda p: squared_distance(p, pair, weight),
        [(k_min + k_max) / 2, (k_min + k_max) / 2 * (low + high) / 2],
        method="SLSQP",
        bounds=[(k_min, k_max), (None, None)],
        constraints=constraints,
        options={"ftol": 1e-14, "maxiter": 500},
    )
    nearest = springs.nearest(*pair, k_min, k_max, low, high, weight)
    np.testing.assert_allclose(nearest, searched.x, rtol=1e-5, atol=1e-5)


@repeatable
@given(st.floats(-60, 60), numbers, weights, st.floats(-50, 0), st.floats(0, 50))
def test_without_bounds_on_the_angle_only_the_stiffness_is_limited(k, offset, weight, k_min, k_max):
    """A negative stiffness may be allowed, and the offset is free."""
    nearest = springs.nearest(k, offset, k_min, k_max, -math.inf, math.inf, weight)
    assert nearest == (min(max(k, k_min), k_max), offset)
    free = springs.nearest(k, offset, -math.inf, math.inf, -math.inf, math.inf, weight)
    assert free == (k, offset)


# (9), (10), (11)


def gain_of(beta, n):
    """β as the learning gain β I of each robot."""
    return np.asarray(beta)[..., None, None] * np.eye(n)


def cycle(seed, n, steps=200, robots=()):
    """Random signals u, y, q of a cycle (*robots, steps, n) and gains β, q_s."""
    rng = np.random.default_rng(seed)
    u, y, q = rng.normal(size=(3, *robots, steps, n))
    return u, y, q + 2, rng.uniform(0, 3, robots), rng.normal(size=(*robots, n))


@repeatable
@given(seeds, joints)
def test_learned_torque_is_9_with_the_coefficients_10(seed, n):
    u, y, q, beta, q_s = cycle(seed, n)
    dt = 1 / len(q)
    q_bar = q - q_s
    w = [
        np.sum((u[:, j] - beta * y[:, j]) * q_bar[:, j] * dt) / np.sum(q_bar[:, j] ** 2 * dt)
        for j in range(n)
    ]
    as_printed = np.array([u[t] - beta * y[t] - np.diag(w) @ q_bar[t] for t in range(len(u))])
    found = learning.learn(u, y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s)
    np.testing.assert_allclose(found, as_printed, rtol=1e-10, atol=1e-12)


@repeatable
@given(seeds, joints, st.integers(0, 5))
def test_learned_torque_is_orthogonal_to_what_a_spring_could_exert_11(seed, n, lead):
    u, y, q, beta, q_s = cycle(seed, n)
    found = learning.learn(u, y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s, lead=lead)
    q_bar = q - q_s
    rounding = len(q) * np.finfo(float).eps * np.sqrt((u**2).sum(0) + (beta * y**2).sum(0))
    assert (np.abs((found * q_bar).sum(axis=0)) <= rounding * np.sqrt((q_bar**2).sum(0))).all()


@repeatable
@given(seeds, joints)
def test_a_torque_that_springs_could_exert_is_not_learned(seed, n):
    """What remains of u does not change when -k (q - q_s) is added to it, whatever k."""
    u, y, q, beta, q_s = cycle(seed, n)
    k = np.random.default_rng(seed).normal(size=n)
    found = learning.learn(u, y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s)
    sprung = learning.learn(u - k * (q - q_s), y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s)
    np.testing.assert_allclose(sprung, found, rtol=1e-10, atol=1e-11)


@repeatable
@given(seeds, joints, st.integers(0, 199))
def test_learning_with_lead_reads_the_error_that_many_samples_ahead(seed, n, lead):
    """Periodic in the stored cycle: reading y ahead is reading a y that was shifted back."""
    u, y, q, beta, q_s = cycle(seed, n)
    ahead = np.array([y[(t + lead) % len(y)] for t in range(len(y))])
    np.testing.assert_array_equal(
        learning.learn(u, y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s, lead=lead),
        learning.learn(u, ahead, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s),
    )


@repeatable
@given(seeds, joints, st.integers(1, 99))
def test_learning_with_a_low_pass_keeps_the_first_harmonics_and_11(seed, n, harmonics):
    u, y, q, beta, q_s = cycle(seed, n)
    found = learning.learn(u, y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s, harmonics=harmonics)
    q_bar = q - q_s
    w = (learning.low_pass(u - beta * y, harmonics) - found) / q_bar
    np.testing.assert_allclose(w, np.broadcast_to(w[0], w.shape), rtol=1e-6, atol=1e-9)
    size = np.linalg.norm(found, axis=0) * np.linalg.norm(q_bar, axis=0)
    assert (np.abs((found * q_bar).sum(axis=0)) <= 1e-9 * (size + 1)).all()


def test_learning_of_many_robots_is_that_of_each():
    u, y, q, beta, q_s = cycle(0, 3, robots=(5,))
    together = learning.learn(u, y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s, lead=2)
    for r in range(5):
        alone = learning.learn(
            u[r], y[r], q[r], gain=gain_of(beta[r], u.shape[-1]), q_s=q_s[r], lead=2
        )
        np.testing.assert_array_equal(together[r], alone)


def test_a_joint_that_rests_at_q_s_learns_without_dividing_by_zero():
    u, y, q, beta, q_s = cycle(0, 2)
    q[:, 1] = q_s[1]
    found = learning.learn(u, y, q, gain=gain_of(beta, u.shape[-1]), q_s=q_s)
    np.testing.assert_allclose(found[:, 1], (u - beta * y)[:, 1], rtol=1e-15)


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1.0, 1e6])
def test_coefficients_10_are_those_of_any_swing_however_small(size):
    """And a joint that stands still at q_s has exactly none, whatever was in memory before."""
    rng = np.random.default_rng(0)
    q_bar = size * rng.normal(size=(50, 4))
    q_bar[:, 2] = 0.0
    k = np.array([3.0, -2.0, 5.0, 0.25])
    np.full(4, 7.0)  # NumPy hands out this memory again
    w = learning.spring_like_part(k * q_bar, q_bar)
    np.testing.assert_allclose(w, [3.0, -2.0, 0.0, 0.25], rtol=1e-12, atol=0)


# Another number of time steps


def test_resampling_to_as_many_samples_changes_nothing():
    u = np.random.default_rng(0).normal(size=(3, 50, 2))
    np.testing.assert_array_equal(learning.resample(u, 50), u)


@pytest.mark.parametrize(("before", "after"), [(500, 1000), (1000, 500), (300, 700), (1000, 999)])
def test_resampling_keeps_a_sine_and_its_phase(before, after):
    """Linear interpolation errs by (2π/N)²/8 of the amplitude at most."""

    def sine(steps):
        t = np.arange(steps) / steps
        return np.stack([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=-1)

    error = np.abs(learning.resample(sine(before), after) - sine(after)).max()
    assert error <= (2 * np.pi / before) ** 2 / 8 * (1 + 1e-9) + 1e-15


@pytest.mark.parametrize("times", [2, 3, 7])
def test_resampling_to_a_multiple_and_back_changes_nothing(times):
    u = np.random.default_rng(1).normal(size=(2, 100, 3))
    np.testing.assert_array_equal(learning.resample(learning.resample(u, 100 * times), 100), u)
