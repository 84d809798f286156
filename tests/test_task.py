"""Tasks with fewer coordinates than joints, and with rotation: the equations behind them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from resonance_mj.laws import equations
from resonance_mj.motions import rotations


def damped(J, rate, s, drift, usual=0.0, alpha=10.0):
    m, n = J.shape
    y = np.empty(n)
    equations.error_damped(J, rate, alpha, s, drift, usual, np.empty((m + 1, m)), y)
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


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("lack", [0.1, 0.5, 0.99])
@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 2), (3, 3), (2, 5), (6, 7)])
def test_damping_grows_to_a_tenth_of_the_jacobian_as_manipulability_is_lost(m, n, lack, size):
    """λ² = 0.01 lack² tr(J Jᵀ)/m with lack = 1 - w/usual, whatever the unit of length is."""
    rng = np.random.default_rng(m + n)
    J = size * (rng.normal(size=(m, n)) + 2 * np.eye(m, n))
    rate, s, drift = rng.normal(size=m), rng.normal(size=m), rng.normal(size=n)
    w = np.sqrt(np.linalg.det(J @ J.T))
    squared = 0.01 * lack**2 * np.trace(J @ J.T) / m
    plus = J.T @ np.linalg.inv(J @ J.T + squared * np.eye(m))
    expected = plus @ (rate + 10 * s) + (np.eye(n) - plus @ J) @ drift
    found = damped(J, rate, s, drift, usual=w / (1 - lack))
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())


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
    home = Rotation.random(None, rng).as_matrix()
    R, back = np.empty((3, 3)), np.empty(3)
    rotations.rotation(r, home, R)
    np.testing.assert_allclose(R, Rotation.from_rotvec(r).as_matrix() @ home, atol=1e-12)
    rotations.rotation_vector(R, home, back)
    np.testing.assert_allclose(back, r, atol=1e-7)


@pytest.mark.parametrize("angle", [1e-7, 3e-5, 0.99e-4])
def test_small_rotations_are_exact_in_every_digit(angle):
    """Of exp(r) about an axis in the x-y plane: each entry beside the diagonal is a single term."""
    x, y = angle * np.array([0.6, 0.8])
    R = np.empty((3, 3))
    rotations.rotation(np.array([x, y, 0.0]), np.eye(3), R)
    sinc, cosc = np.sin(angle) / angle, 2 * (np.sin(angle / 2) / angle) ** 2
    exact = np.array([cosc * x * y, sinc * y, -sinc * x])
    np.testing.assert_allclose([R[0, 1], R[0, 2], R[1, 2]], exact, rtol=2e-12)
    np.testing.assert_allclose(np.diag(R), [1 - cosc * y * y, 1 - cosc * x * x, np.cos(angle)])


@pytest.mark.parametrize("angle", [1e-12, 1e-10, 0.9e-9, 1.1e-9, 1e-6])
def test_smallest_rotation_vectors_are_exact(angle):
    r, R, back = angle * np.array([0.6, 0.0, 0.8]), np.empty((3, 3)), np.empty(3)
    rotations.rotation(r, np.eye(3), R)
    rotations.rotation_vector(R, np.eye(3), back)
    np.testing.assert_allclose(back, r, rtol=1e-10, atol=1e-25)


@pytest.mark.parametrize("n", [1, 2, 7])
def test_inertial_feedback_takes_g_y_off_the_torque(n):
    rng = np.random.default_rng(n)
    G, y, tau = rng.normal(size=(n, n)), rng.normal(size=n), rng.normal(size=n)
    expected = tau - G @ y
    equations.inertial_feedback(G, y, tau)
    np.testing.assert_allclose(tau, expected, rtol=1e-12, atol=1e-12)
