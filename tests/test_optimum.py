"""The best constant springs, (2) and (3): against searches of the closed-form arm, and (12)."""

import functools
import math

import mujoco
import numpy as np
import pytest
import two_link
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize, nnls

import resonance_mj as rmj
from resonance_mj.motions.kinematics import Kinematics
from resonance_mj.plan.plan import plan_for
from resonance_mj.springs.optimum import best_springs

Q_C = np.array([-0.5, -2.0])
UNBOUNDED = {"springs.stiffness": [-math.inf, math.inf]}
PHYSICAL = {"springs.stiffness": [0.0, math.inf]}
BOUNDS = {
    "k >= 0, |q_e - q_c| <= pi": ([0.0, math.inf], [-math.pi, math.pi], "mean"),
    "k in [2, 20], |q_e - q_c| <= 1": ([2.0, 20.0], [-1.0, 1.0], "mean"),
    "one-sided cone": ([0.0, 25.0], [3.5, 4.2], [-0.5, -6.0]),
    "k >= 0 alone": ([0.0, math.inf], [-math.inf, math.inf], [-0.5, -2.0]),
}


@functools.cache
def needed(number, samples=400):
    """Joint motion and torque (samples, 2) of a motion of the paper, from the closed form.

    Both are smooth and periodic, so that the rectangle rule over 400 samples is exact to rounding.
    """
    t = np.arange(samples) / samples
    motion = (two_link.first_motion, two_link.second_motion)[number]
    q, dq, ddq = two_link.joint_motion(*motion(t))
    return q, two_link.inverse_dynamics(q, dq, ddq)


def cost(number, k, offset, q_c=Q_C):
    """J of (3) in the coordinates (k, q̄_e), from the closed form; T = 1 s."""
    q, torque = needed(number)
    return ((torque + k * (q - q_c) - offset) ** 2).sum(axis=1).mean()


@functools.cache
def paper():
    return rmj.optimum(rmj.load("paper"))


def searched(number, q_c, stiffness=(-math.inf, math.inf), angle=(-math.inf, math.inf)):
    """Stiffness and offset of least cost as a general minimiser finds them, joint by joint.

    It searches the stiffness and the spring's mean torque, which hardly interact.
    """
    q, torque = needed(number)
    found = []
    for j in range(2):
        shift = q[:, j].mean() - q_c[j]
        z = q[:, j] - q[:, j].mean()
        constraints = [
            {"type": "ineq", "fun": lambda p, b=b, a=a: a * (p[1] + p[0] * shift - b * p[0])}  # noqa: B023
            for b, a in zip(angle, (1, -1), strict=True)
            if math.isfinite(b)
        ]
        bounds = [tuple(v if math.isfinite(v) else None for v in stiffness), (None, None)]
        best = minimize(
            lambda p: ((torque[:, j] + p[0] * z - p[1]) ** 2).mean(),  # noqa: B023
            [max(1.0, stiffness[0]), 0.0],
            method="SLSQP",
            bounds=bounds,
            constraints=constraints,
            options={"maxiter": 10_000, "ftol": 1e-15},
        )
        found.append((best.x[0], best.x[1] + best.x[0] * shift))
    return np.array(found).T


# Without bounds


@pytest.mark.parametrize("number", [0, 1])
def test_optimum_is_what_a_search_of_the_closed_form_finds(number):
    k, offset = searched(number, Q_C)
    found = paper()[number]
    np.testing.assert_allclose(found.stiffness, k, rtol=1e-6)
    np.testing.assert_allclose(found.offset, offset, rtol=1e-6)
    np.testing.assert_allclose(found.equilibrium, offset / k + Q_C, rtol=1e-6)
    assert found.cost == pytest.approx(cost(number, k, offset), rel=1e-9)
    assert found.cost_without_springs == pytest.approx(cost(number, 0, 0), rel=1e-9)


@pytest.mark.parametrize(
    ("number", "stiffness", "reduction"),
    [(0, (3.062, -2.709), 0.966), (1, (29.950, 4.549), 0.962)],
)
def test_optimum_of_the_paper_s_motions_is_the_one_found_before_the_project(
    number, stiffness, reduction
):
    """findings.md section 1; the closed form above gives the same to 1e-6."""
    np.testing.assert_allclose(paper()[number].stiffness, stiffness, rtol=1e-3)
    assert paper()[number].torque_reduction == pytest.approx(reduction, abs=5e-4)


@pytest.mark.parametrize("number", [0, 1])
def test_optimal_torque_is_orthogonal_to_every_torque_of_a_spring_12(number):
    """∫ τ_dopt (q_d - q_e,opt) dt = 0, and ∫ τ_dopt dt = 0: no spring could take more of it."""
    found = paper()[number]
    scale = np.linalg.norm(found.torque_without_springs, axis=0) * math.sqrt(len(found.q))
    assert (np.abs((found.torque * (found.q - found.equilibrium)).sum(axis=0)) < 1e-9 * scale).all()
    assert (np.abs(found.torque.sum(axis=0)) < 1e-9 * scale).all()


@pytest.mark.parametrize("q_c", ["mean", [0.0, 0.0], [4.0, 1.0]])
def test_optimum_does_not_depend_on_the_centre_that_offsets_are_counted_from(q_c):
    elsewhere = rmj.optimum(rmj.load("paper").replace({"law.q_c": q_c}))
    for here, there in zip(paper(), elsewhere, strict=True):
        np.testing.assert_allclose(there.stiffness, here.stiffness, rtol=1e-9)
        np.testing.assert_allclose(there.equilibrium, here.equilibrium, rtol=1e-9)
        assert there.cost == pytest.approx(here.cost, rel=1e-9)


def test_optimum_does_not_depend_on_the_time_step():
    """J is an integral; the samples' rectangle rule is exact for smooth periodic signals."""
    coarse = rmj.optimum(rmj.load("paper").replace({"simulation.timestep": 4e-3}))
    for here, there in zip(paper(), coarse, strict=True):
        np.testing.assert_allclose(there.stiffness, here.stiffness, rtol=1e-7)
        assert there.cost == pytest.approx(here.cost, rel=1e-7)


# The cost as a function


@pytest.mark.parametrize("number", [0, 1])
@settings(deadline=None, derandomize=True, database=None, max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_cost_is_quadratic_in_stiffness_and_offset_jointly(number, seed):
    """Third differences vanish along every line, and second ones are not negative: one minimum."""
    rng = np.random.default_rng(seed)
    start, step = rng.uniform(-30, 30, (2, 2, 2))
    J = np.array([cost(number, *(start + i * step)) for i in range(4)])
    assert abs(J @ [-1, 3, -3, 1]) < 1e-10 * J.max()
    assert J[:3] @ [1, -2, 1] > 0


@pytest.mark.parametrize("number", [0, 1])
def test_cost_is_not_quadratic_in_stiffness_and_equilibrium_angle_jointly(number):
    """Unlike what Sec. III-D says of (k, q_e): the square of k q_e makes it a quartic there."""
    start, step = np.array([[1.0, 2.0], [0.1, -0.3]]), np.array([[3.0, 4.0], [0.5, 0.7]])

    def at(i):
        k, q_e = start + i * step
        return cost(number, k, k * (q_e - Q_C))

    J = np.array([at(i) for i in range(6)])
    assert abs(J[:4] @ [-1, 3, -3, 1]) > 0.01 * J.max()
    assert J[:5] @ [1, -4, 6, -4, 1] == pytest.approx(24 * (3.0**2 * 0.5**2 + 4.0**2 * 0.7**2))
    assert abs(J @ [-1, 5, -10, 10, -5, 1]) < 1e-9 * J.max()


@pytest.mark.parametrize("number", [0, 1])
def test_cost_between_two_springs_may_exceed_both_in_stiffness_and_equilibrium_angle(number):
    """Not even convex in (k, q_e): two springs of equal offset torque, and the one halfway."""
    best = paper()[number]
    ends = [(k, best.offset / k + Q_C) for k in (0.2 * best.stiffness, 1.8 * best.stiffness)]
    k, q_e = np.mean(ends, axis=0)
    halfway = cost(number, k, k * (q_e - Q_C))
    assert all(halfway > cost(number, k, k * (q_e - Q_C)) for k, q_e in ends)


@pytest.mark.parametrize("number", [0, 1])
@settings(deadline=None, derandomize=True, database=None, max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_cost_beyond_the_optimum_is_the_distance_in_the_metric_of_the_projection(number, seed):
    """J - J_min = T Σ var(q) (Δk)² + (Δ mean spring torque)²: what `springs.nearest` minimises."""
    best = paper()[number]
    dk, d_offset = np.random.default_rng(seed).uniform(-20, 20, (2, 2))
    q = needed(number)[0]
    d_level = d_offset - dk * (q.mean(axis=0) - Q_C)
    expected = (q.var(axis=0) * dk**2 + d_level**2).sum()
    J = cost(number, best.stiffness + dk, best.offset + d_offset)
    assert J - best.cost == pytest.approx(expected, rel=1e-7)


# With bounds


@functools.cache
def bounded(case):
    stiffness, angle, q_c = BOUNDS[case]
    changes = {"springs.stiffness": stiffness, "springs.equilibrium": angle, "law.q_c": q_c}
    return rmj.optimum(rmj.load("paper").replace(changes))


@pytest.mark.parametrize("case", BOUNDS)
@pytest.mark.parametrize("number", [0, 1])
def test_bounded_optimum_is_what_a_constrained_search_of_the_closed_form_finds(case, number):
    found = bounded(case)[number]
    stiffness, angle, _ = BOUNDS[case]
    k, offset = searched(number, found.center, stiffness, angle)
    np.testing.assert_allclose(found.stiffness, k, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(found.offset, offset, rtol=1e-4, atol=1e-4)
    best = cost(number, k, offset, found.center)
    assert found.cost == pytest.approx(best, rel=1e-6)


@pytest.mark.parametrize("case", BOUNDS)
@pytest.mark.parametrize("number", [0, 1])
def test_bounded_optimum_is_a_spring_that_exists_and_no_better_than_the_unbounded(case, number):
    """A spring exerts an offset torque between k (q_e,min - q_c) and k (q_e,max - q_c)."""
    found = bounded(case)[number]
    (k_min, k_max), (low, high), _ = BOUNDS[case]
    k, offset = found.stiffness, found.offset
    assert ((k_min <= k) & (k <= k_max)).all()
    if math.isfinite(low):
        rounding = 1e-12 * (1 + np.abs(offset))
        assert (k * low - rounding <= offset).all()
        assert (offset <= k * high + rounding).all()
    assert found.cost >= paper()[number].cost * (1 - 1e-12)
    assert found.cost <= found.cost_without_springs
    assert cost(number, k, offset, found.center) == pytest.approx(found.cost, rel=1e-9)


def test_wider_bounds_never_cost_more():
    """The feasible sets are nested."""
    last = math.inf
    for reach in (0.1, 0.5, 1.0, 2.0, 4.0):
        changes = {
            "springs.stiffness": [0.0, 15.0 * reach],
            "springs.equilibrium": [-reach, reach],
            "law.q_c": "mean",
            "simulation.timestep": 5e-3,
        }
        total = sum(one.cost for one in rmj.optimum(rmj.load("paper").replace(changes)))
        assert total <= last
        last = total


def test_bounds_that_hold_the_unbounded_optimum_change_nothing():
    changes = {"springs.stiffness": [0.0, 40.0], "springs.equilibrium": [-4.0, 4.0]}
    found = rmj.optimum(rmj.load("paper").replace(changes))[1]
    np.testing.assert_allclose(found.stiffness, paper()[1].stiffness, rtol=1e-12)
    np.testing.assert_allclose(found.offset, paper()[1].offset, rtol=1e-12)


def test_a_joint_that_stands_still_gets_the_offset_it_needs():
    """There its stiffness does not matter, so none is given, and the torque is taken away whole."""
    q = np.stack([np.full(100, 0.7), np.sin(2 * np.pi * np.arange(100) / 100)], axis=1)
    torque = np.stack([np.full(100, 5.0), -3 * q[:, 1] + 1], axis=1)
    springs = rmj.load("paper").springs
    found = best_springs(q, torque, center=np.zeros(2), period=1.0, bounds=springs)
    np.testing.assert_allclose(found.stiffness, [0, 3], atol=1e-12)
    np.testing.assert_allclose(found.offset, [5, 1], atol=1e-12)
    np.testing.assert_allclose(found.torque, 0, atol=1e-12)
    assert found.equilibrium[0] == math.inf


# In a run's own terms


def last_cycle(run, segment):
    data = run.data
    cycle = int(data["cycle"][data["segment_of_cycle"] == segment][-1])
    return cycle, data.isel(time=data["cycle_of_sample"].values == cycle)


def test_a_run_s_own_motion_and_torque_have_the_optimum_of_the_desired_motion():
    """Motors and springs together exert what the motion needs, however they share it."""
    run = rmj.simulate(
        rmj.load("paper-centered").replace(
            {"law.lead": 1, "motion.0.duration": 30.0, "motion.1.duration": 30.0}
        )
    )
    for segment, optimum in enumerate(rmj.optimum(run.experiment), start=1):
        _, data = last_cycle(run, segment)
        q, center = data["q"].values, data["center"].values
        spring = data["offset"].values - data["stiffness"].values * (q - center)
        own = best_springs(
            q,
            data["tau"].values + spring,
            center=center[0],
            period=1.0,
            bounds=run.experiment.springs,
        )
        np.testing.assert_allclose(own.stiffness, optimum.stiffness, rtol=0.02)
        np.testing.assert_allclose(own.equilibrium, optimum.equilibrium, rtol=0.01)
        assert own.cost_without_springs == pytest.approx(optimum.cost_without_springs, rel=0.01)


@pytest.mark.parametrize("number", [0, 1])
def test_motors_of_a_simulated_arm_with_the_optimal_springs_need_the_optimal_torque(number):
    """The optimum of inverse dynamics is what MuJoCo's forward dynamics then asks of the motors.

    The first and the last tenth of the cycle are left out: the arm starts at rest, and what the law
    learned around t = 0 from that one jump of the velocity error takes hundreds of cycles to fade.
    """
    optimum = paper()[number]
    motion = rmj.load("paper").motion[number].model_dump()
    run = rmj.simulate(
        rmj.load("paper-centered").replace(
            {
                "motion": [motion | {"duration": 20.0}],
                "law.lead": 1,
                "law.gamma_k": 0.0,
                "law.gamma_qe": 0.0,
                "springs.initial_stiffness": optimum.stiffness.tolist(),
                "springs.initial_equilibrium": optimum.equilibrium.tolist(),
            }
        )
    )
    _, data = last_cycle(run, 1)
    np.testing.assert_array_equal(data["stiffness"].values[-1], optimum.stiffness)
    away = (data["tau"].values - optimum.torque)[100:900]
    assert (away**2).sum(axis=1).mean() < 0.01 * optimum.torque_squared


# A device's range of the joint's own angle

RANGE = {"springs.equilibrium": [-2.0, 2.5], "springs.equilibrium_about": "zero"}


def best_within_range(q, torque, low=-2.0, high=2.5):
    """Stiffness k >= 0, and k q_e with q_e in [low, high], of the best springs, by SciPy.

    Such a spring is a sum, with factors of at least 0, of two: one with its equilibrium at each end
    of the range.
    """
    found = []
    for angles, needed in zip(q.T, torque.T, strict=True):
        ends = np.stack([low - angles, high - angles], axis=1)
        a, b = nnls(ends, needed)[0]
        found.append((a + b, (a * low + b * high)))
    return np.array(found).T


@pytest.mark.parametrize("q_c", ["mean", [3.0, -1.0]])
@pytest.mark.parametrize("number", [0, 1])
def test_optimum_within_a_range_of_the_joints_own_angle_is_that_of_bounded_least_squares(
    number, q_c
):
    found = rmj.optimum(rmj.load("paper").replace(PHYSICAL | RANGE | {"law.q_c": q_c}))[number]
    k, torque_at_zero = best_within_range(*needed(number))
    np.testing.assert_allclose(found.stiffness, k, rtol=1e-5)
    np.testing.assert_allclose(
        found.springs.about(np.zeros(2)).offset, torque_at_zero, rtol=1e-5, atol=1e-9
    )


def test_optimum_ends_where_the_range_does():
    found = rmj.optimum(rmj.load("paper").replace(PHYSICAL | RANGE))[1]
    assert found.equilibrium[0] == pytest.approx(2.5, abs=1e-12)


def test_what_mujoco_warns_of_meanwhile_is_kept_for_the_notes_and_off_the_screen(
    monkeypatch, capfd, tmp_path
):
    """Whoever asks first, for the optimum or for the notes."""
    torque = Kinematics.torque

    def warns(self, motion):
        model = mujoco.MjModel.from_xml_string(
            "<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>"
        )
        data = mujoco.MjData(model)
        data.qpos[0] = math.nan
        mujoco.mj_step(model, data)
        return torque(self, motion)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Kinematics, "torque", warns)
    plan = plan_for(rmj.load("paper"))
    assert plan.optima
    assert [line for line in plan.notes if line.startswith("MuJoCo warns: Nan")]
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("stiffness", [(-np.inf, np.inf), (0.0, np.inf), (0.0, 4.0)])
def test_at_the_ends_of_a_stiffness_s_range_torque_costs_what_is_said_and_beyond_more(stiffness):
    bounded = {} if stiffness[0] else {"springs.equilibrium": [-0.5, 0.8]}
    base = rmj.load("two-link-transfer").replace({"springs.stiffness": stiffness} | bounded)
    best = rmj.optimum(base)[0]
    most = best.torque_squared + 0.05 * best.torque_squared_without_springs
    ends = best.stiffness_range(0.05)
    for j in range(2):
        name = ("joint1", "joint2")[j]
        for side, k in enumerate(ends[j]):
            at_bound = k == stiffness[side]
            for beyond in (0.0, 1e-3):
                held = float(k + (2 * side - 1) * beyond * max(1.0, abs(k)))
                if not stiffness[0] <= held <= stiffness[1]:
                    continue
                own = {f"springs.joint.{name}.stiffness": [held, held]}
                (other, *_) = rmj.optimum(base.replace(own))
                if beyond:
                    assert other.torque_squared > most
                elif at_bound:
                    assert other.torque_squared <= most * (1 + 1e-9)
                else:
                    assert other.torque_squared == pytest.approx(most, rel=1e-6)
