"""Tasks with fewer coordinates than joints, and with rotation: the equations behind them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from resonance_mj import equations


def damped(J, rate, s, drift, usual=0.0, alpha=10.0):
    m, n = J.shape
    y = np.empty(n)
    equations.error_damped(J, rate, alpha, s, drift, usual, np.empty((m + 1, m + 1)), y)
    return y


@given(seed=st.integers(0, 10_000), m=st.integers(1, 6), more=st.integers(0, 3))
def test_away_from_singular_poses_y_is_the_pseudo_inverse_with_the_posture_in_its_null_space(
    seed, m, more
):
    rng = np.random.default_rng(seed)
    n = m + more
    U, _, Vt = np.linalg.svd(rng.normal(size=(m, n)), full_matrices=False)
    J = U @ np.diag(rng.uniform(0.5, 2.0, m)) @ Vt
    rate, s, drift = rng.normal(size=m), rng.normal(size=m), rng.normal(size=n)
    plus = np.linalg.pinv(J)
    expected = plus @ (rate + 10 * s) + (np.eye(n) - plus @ J) @ drift
    np.testing.assert_allclose(damped(J, rate, s, drift), expected, atol=1e-6)


def test_at_a_singular_pose_y_stays_small_where_the_inverse_would_be_without_bound():
    J = np.array([[1.0, 1.0], [0.0, 1e-9]])
    rate, s, drift = np.array([0.0, 1.0]), np.zeros(2), np.zeros(2)
    assert np.abs(np.linalg.solve(J, rate)).max() > 1e8
    assert np.abs(damped(J, rate, s, drift, usual=0.1)).max() < 10.0


def test_the_damping_sets_in_without_a_jump():
    rng = np.random.default_rng(0)
    J = rng.normal(size=(3, 3))
    rate, s, drift = rng.normal(size=(3, 3))
    usual = abs(np.linalg.det(J))
    below, above = (damped(J, rate, s, drift, usual=usual * k) for k in (1 - 1e-9, 1 + 1e-9))
    np.testing.assert_allclose(below, above, rtol=1e-6)


@given(seed=st.integers(0, 10_000), angle=st.floats(0, 3.1))
def test_rotation_and_rotation_vector_are_inverse_to_each_other(seed, angle):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    r = angle * axis / np.linalg.norm(axis)
    home = Rotation.random(rng=rng).as_matrix()
    R, back = np.empty((3, 3)), np.empty(3)
    equations.rotation(r, home, R)
    np.testing.assert_allclose(R, Rotation.from_rotvec(r).as_matrix() @ home, atol=1e-12)
    equations.rotation_vector(R, home, back)
    np.testing.assert_allclose(back, r, atol=1e-7)


@pytest.mark.parametrize("n", [1, 2, 7])
def test_inertial_feedback_takes_g_y_off_the_torque(n):
    rng = np.random.default_rng(n)
    G, y, tau = rng.normal(size=(n, n)), rng.normal(size=n), rng.normal(size=n)
    expected = tau - G @ y
    equations.inertial_feedback(G, y, tau)
    np.testing.assert_allclose(tau, expected, rtol=1e-12, atol=1e-12)
