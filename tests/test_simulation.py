"""Whole runs: against the paper's differential equations, energy, (9) and (11), and themselves."""

import contextlib
import functools
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
import two_link
import xarray as xr
from scipy.integrate import simpson, solve_ivp

import resonance_mj as rmj
from resonance_mj.robots.options import INTEGRATORS

HOME = np.array([4.00114, -2.00057])


def short(changes=(), cycles=2):
    """The paper's first motion for a few cycles."""
    paper = rmj.load("paper")
    motion = paper.motion[0].model_dump() | {"duration": float(cycles)}
    return paper.replace({"motion": [motion], **dict(changes)})


def assert_equal_to_the_last_bit(one, other):
    assert (one.status, one.message, one.steps) == (other.status, other.message, other.steps)
    assert one.experiment == other.experiment
    xr.testing.assert_identical(one.data, other.data)
    for name in one.data.variables:
        here, there = one.data[name].values, other.data[name].values
        if here.dtype.kind == "f":
            np.testing.assert_array_equal(np.signbit(here), np.signbit(there), err_msg=name)


def values(run, *names):
    return tuple(run.data[name].values for name in names)


# Against the differential equations


def signals(t, q, dq, jacobian):
    """Feedback part of (4) and y of (8) along a motion (..., 2), from the closed form."""
    x_d, dx_d, _ = two_link.first_motion(t)
    J = two_link.jacobian(q)
    s = np.sin(two_link.position(q) - x_d)  # errors stay below a quarter turn
    rate = np.einsum("...ij,...j->...i", J, dq) - dx_d
    feedback = -np.einsum("...ji,...j->...i", J, 200 * rate + 2000 * s)
    if jacobian == "transpose":
        return feedback, np.einsum("...ji,...j->...i", J, rate + 10 * s)
    return feedback, np.linalg.solve(J, (rate + 10 * s)[..., None])[..., 0]


def continuous_law(jacobian):
    """The paper's first two cycles in continuous time: q, q̇, k, q̄_e at each instant (t -> (8,)).

    (1), (4)-(8) by an adaptive integrator to 1e-9, then w of (10) by quadrature and u of (9) from
    the solution of the first cycle. It shares nothing with the package.
    """
    gamma_k, gamma_qe, q_c = np.array([50, 5]), np.array([150, 10]), np.array([-0.5, -2.0])

    def solution(begin, state, u):
        def rate(t, z):
            q, dq, k, offset = z.reshape(4, 2)
            feedback, y = signals(t, q, dq, jacobian)
            torque = feedback + u(t) - k * (q - q_c) + offset
            ddq = two_link.forward_dynamics(q, dq, torque)
            return np.concatenate([dq, ddq, gamma_k * (q - q_c) * y, -gamma_qe * y])

        span = (begin, begin + 1)
        found = solve_ivp(
            rate, span, state, method="LSODA", rtol=1e-9, atol=1e-11, dense_output=True
        )
        return found.sol

    start = np.concatenate([HOME, np.zeros(6)])
    first = solution(0, start, lambda t: np.zeros(2))
    t = np.linspace(0, 1, 20_001)
    q, dq = first(t).T[:, :2], first(t).T[:, 2:4]
    _, y = signals(t, q, dq, jacobian)
    w = simpson(-y * q, x=t, axis=0) / simpson(q**2, x=t, axis=0)  # β = 1, q_s = 0, u = 0

    def learned(t):
        q, dq = first(t - 1).reshape(4, 2)[:2]
        return -signals(t - 1, q, dq, jacobian)[1] - w * q

    second = solution(1, first(1.0), learned)
    return lambda t: first(t) if t < 1 else second(t)


def test_closed_loop_converges_to_the_paper_s_differential_equations_with_order_one():
    """Sampling the law with a zero-order hold costs one order, whatever the integrator's own is.

    The reference is continuous; the package samples every dt: the motors hold their torque, (6) and
    (7) are explicit Euler steps and (10) is a rectangle rule, each of order 1. RK4 therefore errs
    with order 1 too. Its error is compared every 50 ms of the first two cycles.
    """
    timesteps = (2e-3, 1e-3, 5e-4)
    cases = [(name, "inverse") for name in INTEGRATORS] + [("implicitfast", "transpose")]
    reference = {}
    for integrator, jacobian in cases:
        if jacobian not in reference:
            exact = continuous_law(jacobian)
            reference[jacobian] = np.array([exact(0.05 * i) for i in range(40)]).reshape(40, 4, 2)
        errors = []
        for dt in timesteps:
            changes = {
                "simulation.timestep": dt,
                "simulation.integrator": integrator,
                "law.jacobian": jacobian,
            }
            found = values(rmj.simulate(short(changes)), "q", "stiffness", "offset")
            every = round(0.05 / dt)
            wanted = (reference[jacobian][:, i] for i in (0, 2, 3))
            errors.append(
                [np.abs(a[::every] - b).max() for a, b in zip(found, wanted, strict=True)]
            )
        orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
        case = f"{integrator}, {jacobian}: {errors}"
        assert ((orders > 0.9) & (orders < 1.2)).all(), case
        # At 1 ms: 6 mrad at most at the start from rest.
        assert errors[1][0] < 6e-3, case


@pytest.mark.parametrize(("integrator", "order"), [("Euler", 1), ("implicitfast", 1), ("RK4", 4)])
def test_arm_without_a_law_converges_with_the_order_of_its_integrator(integrator, order):
    """Motors off, springs fixed: a smooth motion under gravity, springs and viscosity.

    The reference is the closed-form arm by an adaptive integrator to 1e-12.
    """
    k, q_e = np.array([20.0, 4.0]), np.array([3.0, -1.0])

    def rate(t, z):
        q, dq = z.reshape(2, 2)
        return np.concatenate([dq, two_link.forward_dynamics(q, dq, -k * (q - q_e))])

    start = np.concatenate([HOME, np.zeros(2)])
    exact = solve_ivp(
        rate, (0, 1), start, method="DOP853", rtol=1e-11, atol=1e-12, dense_output=True
    )
    off = dict.fromkeys(("k_v", "k_p", "alpha", "beta", "gamma_k", "gamma_qe"), 0.0)
    errors = []
    for dt in (1e-2, 5e-3, 2.5e-3):
        changes = {
            "simulation.timestep": dt,
            "simulation.integrator": integrator,
            "springs.initial_stiffness": k.tolist(),
            "springs.initial_equilibrium": q_e.tolist(),
            **{f"law.{name}": value for name, value in off.items()},
        }
        run = rmj.simulate(short(changes, cycles=1))
        q, tau, time = values(run, "q", "tau", "time")
        assert not tau.any()
        errors.append(np.abs(q - exact.sol(time)[:2].T).max())
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    np.testing.assert_allclose(orders, order, atol=0.25, err_msg=str(errors))


def test_two_integrators_of_order_one_agree_on_the_arm():
    """Its only velocity-dependent force that either takes implicitly is the joints' viscosity."""
    one, other = (
        rmj.simulate(short({"simulation.integrator": i})) for i in ("Euler", "implicitfast")
    )
    np.testing.assert_allclose(one.data["q"], other.data["q"], rtol=0, atol=1e-9)


# Conservation


def energy_balance(integrator, dt):
    """Work of motors and springs, less viscous loss and gain of energy, over the second cycle [J].

    Within a time step the motor torque and the springs are constant, so that the motors' work and
    the springs' are exact in the joint angles; the trapezoid rule takes the viscous loss.
    """
    changes = {"simulation.timestep": dt, "simulation.integrator": integrator}
    run = rmj.simulate(short(changes, cycles=3))
    cycle = slice(round(1 / dt), 2 * round(1 / dt) + 1)
    q, dq, tau, k, offset, center = (
        v[cycle] for v in values(run, "q", "dq", "tau", "stiffness", "offset", "center")
    )
    turned, z = np.diff(q, axis=0), q - center
    motors = (tau[:-1] * turned).sum()
    springs = (offset[:-1] * turned - k[:-1] / 2 * (z[1:] ** 2 - z[:-1] ** 2)).sum()
    power = (dq**2 * two_link.D).sum(axis=1)
    lost = (power[1:] + power[:-1]).sum() * dt / 2
    energy = two_link.kinetic(q, dq) + two_link.potential(q)
    return motors + springs - lost - (energy[-1] - energy[0]), abs(motors) + abs(springs)


def test_work_of_motors_and_springs_is_the_energy_gained_and_lost():
    """To 1e-6 with RK4, where what is left is the trapezoid rule's error, of order 2."""
    (coarse, _), (fine, work) = (energy_balance("RK4", dt) for dt in (2e-3, 1e-3))
    assert abs(fine) < 1e-6 * work
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.5)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
def test_work_balances_the_energy_up_to_the_order_of_the_integrator(integrator):
    (coarse, _), (fine, work) = (energy_balance(integrator, dt) for dt in (2e-3, 1e-3))
    assert abs(fine) < 0.01 * work
    assert np.log2(coarse / fine) == pytest.approx(1, abs=0.3)


# Learning from cycle to cycle


def cycles_of(run, *names):
    """Signals of a run whose cycles have equally many steps, cycle by cycle (cycles, N, 2)."""
    cycles = run.data.sizes["cycle"]
    return tuple(v.reshape(cycles, -1, 2) for v in values(run, *names))


@pytest.mark.parametrize("lead", [0, 1, 7])
def test_learned_torque_of_a_cycle_is_9_and_10_of_the_signals_before(lead):
    """Within a motion and over the change to the next; q̄ = q - q_s with q_s not zero."""
    run = rmj.simulate(
        rmj.load("paper").replace(
            {
                "motion.0.duration": 3.0,
                "motion.1.duration": 2.0,
                "law.lead": lead,
                "law.beta": 1.5,
                "law.q_s": [3.9, -1.8],
            }
        )
    )
    u, y, q = cycles_of(run, "u", "y", "q")
    np.testing.assert_array_equal(u[0], 0)
    for i in range(1, len(u)):
        q_bar = q[i - 1] - [3.9, -1.8]
        v = u[i - 1] - 1.5 * np.concatenate([y[i - 1][lead:], y[i - 1][:lead]])
        w = (v * q_bar).sum(axis=0) / (q_bar**2).sum(axis=0)
        np.testing.assert_allclose(u[i], v - w * q_bar, rtol=1e-10, atol=1e-10)


def test_learned_torque_is_orthogonal_to_the_springs_of_the_cycle_it_was_learned_in_11():
    run = rmj.simulate(short(cycles=6))
    u, q = cycles_of(run, "u", "q")
    for i in range(1, 6):
        inner = (u[i] * q[i - 1]).sum(axis=0)  # q_s = 0
        size = np.linalg.norm(u[i], axis=0) * np.linalg.norm(q[i - 1], axis=0)
        assert (np.abs(inner) < 1e-12 * size).all()
        assert (size > 1).all()


def test_motor_torque_is_feedback_plus_learned_torque_4():
    run = rmj.simulate(short(cycles=3))
    q, dq, tau, u, y, time = values(run, "q", "dq", "tau", "u", "y", "time")
    feedback, error = signals(time, q, dq, "inverse")
    np.testing.assert_allclose(tau, feedback + u, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(y, error, rtol=1e-9, atol=1e-10)


def test_learned_torque_keeps_its_phase_when_the_cycle_changes_its_length():
    """The second motion repeats the first at half the speed: twice the samples, the same phases."""
    paper = rmj.load("paper")
    fast = paper.motion[0].model_dump() | {"duration": 2.0}
    slow = fast | {"duration": 2.0, "period": 2.0}
    run = rmj.simulate(paper.replace({"motion": [fast, slow]}))
    u, y, q = values(run, "u", "y", "q")
    v = (u - y)[1000:2000]
    q_bar = q[1000:2000]
    learned = v - (v * q_bar).sum(axis=0) / (q_bar**2).sum(axis=0) * q_bar
    for j in range(2):
        phase = np.arange(2000) / 2000
        expected = np.interp(phase, np.arange(1000) / 1000, learned[:, j], period=1.0)
        np.testing.assert_allclose(u[2000:, j], expected, rtol=1e-9, atol=1e-10)


# The paper


def reductions(name):
    run = rmj.simulate(rmj.load(name))
    assert run.status == rmj.Status.OK
    return [100 * segment["torque_reduction"] for segment in run.summary()["segments"]]


def test_experiment_paper_reproduces_the_paper_s_two_printed_reductions():
    """Sec. VI-B prints about 98 % at 39 to 40 s and 84 % at 79 to 80 s."""
    assert [round(one) for one in reductions("paper")] == [98, 84]


def test_experiment_paper_centered_reaches_what_the_analytic_arm_reached():
    """95.9 % and 93.5 %: a two-link Lagrangian without MuJoCo, findings.md section 1.

    There a four times shorter time step moved them by at most 0.4; the integrators differ.
    """
    assert reductions("paper-centered") == pytest.approx([95.9, 93.5], abs=0.3)


def test_torque_reduction_compares_the_last_cycle_with_the_motion_without_springs():
    """1 - ∫τᵀτ dt / ∫τ_d(0,0,t)ᵀτ_d(0,0,t) dt, the latter from the closed-form arm."""
    run = rmj.simulate(short(cycles=4))
    t = np.arange(1000) / 1000
    without = two_link.inverse_dynamics(*two_link.joint_motion(*two_link.first_motion(t)))
    tau, x, x_d = values(run, "tau", "x", "x_desired")
    (segment,) = run.summary()["segments"]
    expected = 1 - (tau[-1000:] ** 2).sum() / (without**2).sum()
    assert segment["torque_reduction"] == pytest.approx(expected, rel=1e-9)
    miss = ((x - x_d)[-1000:] ** 2).sum(axis=1).mean() ** 0.5
    assert segment["tracking_rms"] == pytest.approx(miss, rel=1e-12)


def test_tracking_improves_and_motors_work_less_from_cycle_to_cycle_at_first():
    run = rmj.simulate(short(cycles=8))
    rms, squared = values(run, "tracking_rms", "torque_squared")
    assert (np.diff(rms) < 0).all()
    assert squared[-1] < 0.1 * squared[0]


# One by one, again, and together


def test_a_run_repeats_itself_to_the_last_bit():
    assert_equal_to_the_last_bit(rmj.simulate(short()), rmj.simulate(short()))


def family():
    """Experiments of several layouts, cycle lengths and time steps, one of which diverges."""
    changes = [
        {},
        {"law.beta": 2.0, "law.lead": 1, "law.q_s": "mean"},
        {"law.k_v": 2000.0, "simulation.gravity": [0.0, 0.0, 0.0]},  # diverges
        {"law.jacobian": "transpose", "law.q_c": "mean"},
        {"simulation.gravity": [1.0, 0.0, -3.7], "law.gamma_k": 10.0},
        {"springs.initial_stiffness": [5.0, 1.0], "law.k_p": [900.0, 3000.0]},
        # As many time steps in a cycle as the others have, at twice the rate.
        {"simulation.timestep": 1e-3, "motion.0.period": 0.5, "motion.0.duration": 1.5},
        # These step on their own.
        {"simulation.timestep": 2.5e-3},
        {"simulation.integrator": "RK4"},
    ]
    return [short({"simulation.timestep": 2e-3, **one}, cycles=3) for one in changes]


@pytest.fixture(scope="module")
def one_by_one():
    return [rmj.simulate(experiment) for experiment in family()]


@pytest.mark.parametrize(
    ("threads", "order"),
    [(1, range(9)), (2, range(9)), (2, range(8, -1, -1)), (2, [3, 0]), (1, [2])],
)
def test_experiments_together_equal_each_alone_to_the_last_bit(
    one_by_one, threads, order, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    experiments = family()
    together = rmj.simulate_many([experiments[i] for i in order], threads=threads)
    assert len(together) == len(order)
    for run, index in zip(together, order, strict=True):
        assert_equal_to_the_last_bit(run, one_by_one[index])
        assert (run.status == rmj.Status.DIVERGED) == (index == 2)


FINGERPRINT = """
import hashlib
import resonance_mj as rmj
experiment = rmj.load("paper").replace({"motion.0.duration": 2.0, "motion.1.duration": 1.0})
data = rmj.simulate(experiment).data
bits = b"".join(data[name].values.tobytes() for name in sorted(data))
print(hashlib.sha256(bits).hexdigest())
"""


def test_another_process_with_other_numbers_of_threads_makes_the_same_bits(capsys):
    """Threads of the linear algebra under NumPy, of Numba and of OpenMP; another hash seed too."""
    exec(FINGERPRINT, {})
    here = capsys.readouterr().out
    variables = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")
    environment = os.environ | dict.fromkeys(variables, "1") | {"PYTHONHASHSEED": "1"}
    process = subprocess.run(
        [sys.executable, "-c", FINGERPRINT], env=environment, capture_output=True, text=True
    )
    assert process.returncode == 0, process.stderr
    assert process.stdout == here


def test_no_experiments_make_no_runs():
    assert rmj.simulate_many([]) == []


def test_progress_is_told_after_every_cycle_of_all():
    told = []
    rmj.simulate_many(
        [short(cycles=2), short({"simulation.timestep": 2e-3}, cycles=3)],
        progress=lambda done, total: told.append((done, total)),
    )
    assert told == [(i, 5) for i in range(1, 6)]


# What a run holds

PER_TIME = {
    "q": "rad",
    "dq": "rad/s",
    "x": "m",
    "x_desired": "m",
    "tau": "N m",
    "u": "N m",
    "y": "rad/s",
    "stiffness": "N m/rad",
    "offset": "N m",
    "equilibrium": "rad",
    "center": "rad",
    "tau_optimal": "N m",
}
PER_CYCLE = {
    "torque_squared": "N^2 m^2",
    "tracking_rms": "m",
    "stiffness_per_cycle": "N m/rad",
    "offset_per_cycle": "N m",
}


def test_every_variable_has_a_unit_a_meaning_and_its_documented_name():
    data = rmj.simulate(short()).data
    for names, dim in ((PER_TIME, "time"), (PER_CYCLE, "cycle")):
        for name, units in names.items():
            assert data[name].attrs["units"] == units, name
            assert data[name].dims[0] == dim, name
    for name in data.variables:
        assert data[name].attrs["units"], name
        assert name in data.coords or data[name].attrs["long_name"], name
    assert data["joint"].values.tolist() == ["joint1", "joint2"]
    assert data["axis"].values.tolist() == ["x", "z"]


def test_error_signal_of_the_transposed_jacobian_has_its_own_unit():
    """Jᵀ (Δẋ + α s) is in m²/s, not in rad/s."""
    data = rmj.simulate(short({"law.jacobian": "transpose"}, cycles=1)).data
    assert data["y"].attrs["units"] == "m^2/s"


def test_time_cycles_and_segments_tell_when_each_sample_was():
    paper = rmj.load("paper")
    slow = paper.motion[1].model_dump() | {"duration": 4.0, "period": 2.0}
    fast = paper.motion[0].model_dump() | {"duration": 3.0}
    data = rmj.simulate(paper.replace({"motion": [fast, slow]})).data
    np.testing.assert_allclose(data["time"], np.arange(7000) * 1e-3, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(
        data["cycle_of_sample"], np.repeat([1, 2, 3, 4, 5], [1000] * 3 + [2000] * 2)
    )
    assert data["segment_of_cycle"].values.tolist() == [1, 1, 1, 2, 2]
    assert data["start"].values.tolist() == [0, 3]
    assert data["end"].values.tolist() == [3, 7]


def test_thinning_keeps_whole_cycles_with_both_ends_and_the_per_cycle_part_as_it_was():
    paper = rmj.load("paper").replace({"motion.0.duration": 10.0, "motion.1.duration": 6.0})
    whole = rmj.simulate(paper).data
    thin = rmj.simulate(paper.replace({"simulation.samples": 8000})).data
    assert (whole.attrs["thinned"], thin.attrs["thinned"]) == (0, 1)
    assert thin.sizes["time"] <= 8000
    kept, counts = np.unique(thin["cycle_of_sample"], return_counts=True)
    assert (counts == 1000).all()
    assert {1, 10, 11, 16} <= set(kept.tolist())
    same = whole.isel(time=np.isin(whole["cycle_of_sample"].values, kept))
    for name in whole.variables:
        np.testing.assert_array_equal(thin[name].values, same[name].values, err_msg=name)


@pytest.mark.filterwarnings("ignore::resonance_mj.errors.DivergedWarning")
def test_a_thinned_run_that_diverges_keeps_the_cycles_that_led_to_it():
    paper = rmj.load("paper").replace({"law.beta": 8.0, "motion.0.duration": 60.0})
    whole = rmj.simulate(paper).data
    thin = rmj.simulate(paper.replace({"simulation.samples": 1})).data
    done = whole.sizes["cycle"]
    assert 10 < done < 60
    assert {1, 2, done - 1, done} == set(thin["cycle_of_sample"].values.tolist())
    same = whole.isel(time=np.isin(whole["cycle_of_sample"].values, [1, 2, done - 1, done]))
    for name in whole.variables:
        np.testing.assert_array_equal(thin[name].values, same[name].values, err_msg=name)


def test_a_thinned_run_that_is_stopped_keeps_its_last_cycles_as_they_were():
    """Springs whose center moves, and the first cycle of another motion."""
    asked = rmj.load("two-link-transfer").replace(
        {"law": {}, "motion.0.duration": 12.0, "motion.1.duration": 12.0}
    )
    for cycles in (8, 13, 20):
        stops = iter([*[False] * (cycles - 1), True])
        whole = rmj.simulate(asked, stop=lambda stops=stops: next(stops)).data
        stops = iter([*[False] * (cycles - 1), True])
        thin = asked.replace({"simulation.samples": 1})
        thin = rmj.simulate(thin, stop=lambda stops=stops: next(stops)).data
        kept = np.unique(thin["cycle_of_sample"].values)
        assert {cycles - 1, cycles} <= set(kept.tolist())
        same = whole.isel(time=np.isin(whole["cycle_of_sample"].values, kept))
        for name in ("x_desired", "center", "q", "equilibrium", "time"):
            np.testing.assert_array_equal(thin[name].values, same[name].values, err_msg=name)


def test_saved_run_is_loaded_as_it_was(tmp_path):
    run = rmj.simulate(
        rmj.load("paper").replace({"motion.0.duration": 2.0, "motion.1.duration": 2.0})
    )
    loaded = rmj.Run.load(run.save(tmp_path / "deep" / "folder"))
    assert_equal_to_the_last_bit(loaded, run)
    assert loaded.versions == run.versions
    assert loaded.summary() == run.summary()
    assert json.loads((tmp_path / "deep/folder/summary.json").read_text()) == run.summary()


# A run that does not end well

DIVERGING = {
    "learning gain": {"law.beta": 30.0},
    "learning gain, RK4": {"law.beta": 30.0, "simulation.integrator": "RK4"},
    "velocity gain": {"law.k_v": 2000.0},
    "velocity gain beyond all numbers": {"law.k_v": 1e9},
    "adaptation gain": {"law.gamma_k": 1e5},
    "adaptation gain beyond all numbers": {"law.gamma_k": 1e9},
    "stiff springs": {"springs.initial_stiffness": 1e5},
    "springs stiff beyond all numbers": {"springs.initial_stiffness": 1e9},
}


@functools.cache
def diverged(case):
    """A diverging run, and the files that it left in the working folder."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        run = rmj.simulate(short(DIVERGING[case], cycles=8))
        left = [path.name for path in Path(folder).iterdir()]
    assert run.status == rmj.Status.DIVERGED
    return run, left


@pytest.mark.parametrize("case", DIVERGING)
def test_diverging_run_says_where_and_what_to_try(case):
    run, _ = diverged(case)
    where = re.match(r"motion 1 diverged in cycle (\d+) of the run", run.message)
    cycle = int(where[1])
    assert (cycle - 1) * 1000 <= run.steps <= cycle * 1000
    assert "joint1" in run.message or "joint2" in run.message
    assert "a shorter simulation.timestep (now 0.001 s)" in run.message
    # Without learning in the first cycle, the learning cannot be the reason.
    other = "law.k_v" if cycle == 1 else "law.lead = 1, a smaller law.beta (now 30)"
    assert other in run.message
    assert "\n" not in run.message
    assert run.summary()["status"] == "diverged"
    assert run.summary()["message"] == run.message


@pytest.mark.parametrize("case", DIVERGING)
def test_diverging_run_keeps_what_was_recorded_and_all_of_it_finite(case):
    run, _ = diverged(case)
    data = run.data
    assert data.sizes["time"] == run.steps
    assert data.sizes["cycle"] == run.steps // 1000
    ended = set(data["segment_of_cycle"].values)
    for name, variable in data.variables.items():
        if name in ("electrical_power", "peak_torque"):  # of the last whole cycle, if there is one
            known = np.isin(data["segment"].values, [*ended])
            assert np.array_equal(np.isfinite(variable.values), known)
        elif variable.dtype.kind == "f":
            assert np.isfinite(variable.values).all(), name


@pytest.mark.parametrize("case", DIVERGING)
def test_diverging_run_stops_before_mujoco_integrates_what_is_no_motion(case):
    """MuJoCo would warn, in a log in the user's folder, of numbers beyond 1e10."""
    assert diverged(case)[1] == []


@pytest.mark.parametrize("case", DIVERGING)
def test_recorded_torque_is_one_that_mujoco_applied(case):
    """Controls beyond mjMAXVAL are none: MuJoCo then applies no control at all."""
    run, _ = diverged(case)
    assert (np.abs(run.data["tau"]) <= mujoco.mjMAXVAL).all()


def test_diverging_run_is_until_then_the_run_of_fewer_cycles():
    run, _ = diverged("learning gain")
    fewer = run.data.sizes["cycle"] - 1
    assert fewer >= 2
    before = rmj.simulate(short(DIVERGING["learning gain"], cycles=fewer))
    assert before.status is not rmj.Status.DIVERGED
    xr.testing.assert_equal(run.data["tau"][: 1000 * fewer], before.data["tau"])


@pytest.mark.parametrize(
    "case", ["learning gain", "velocity gain", "velocity gain beyond all numbers"]
)
def test_diverged_run_is_saved_and_loaded_like_any_other(case, tmp_path):
    """Of some whole cycles, of a part of the first, and of no time step at all."""
    run, _ = diverged(case)
    loaded = rmj.Run.load(run.save(tmp_path / "run"))
    assert_equal_to_the_last_bit(loaded, run)
    assert loaded.summary() == run.summary()


def test_reading_the_error_ahead_keeps_a_large_learning_gain_from_diverging():
    """The hold's delay is what makes (9) unstable when sampled: findings.md section 2.

    With β = 10 as printed, motors work harder than in an arm without springs by cycle 19.
    """
    changes = {"law.beta": 10.0, "law.q_c": "mean"}
    printed = rmj.simulate(short(changes, cycles=30)).data
    ahead = rmj.simulate(short({**changes, "law.lead": 1}, cycles=30)).data
    without = printed["torque_squared_without_springs"].item()
    assert printed["torque_squared"].values[18:].min() > without
    assert ahead["torque_squared"].values[10:].max() < without
    assert ahead.sizes["cycle"] == 30


BOUNDED = {
    "law": {},
    "law.kind": "transfer",
    "springs": {},
    "springs.stiffness": [2.0, 50.0],
}


def test_springs_begin_within_their_bounds_where_nothing_is_said_of_them():
    data = rmj.simulate(short(BOUNDED, cycles=2)).data.isel(time=0)
    assert (data["stiffness"] == 2.0).all()
    away = (data["equilibrium"] - data["center"]).values
    assert (np.abs(away) <= np.pi + 1e-12).all()


def test_springs_that_are_told_to_begin_outside_their_bounds_are_refused_with_them():
    center = rmj.simulate(short(BOUNDED, cycles=2)).data["center"].isel(time=0).values
    inside = short({**BOUNDED, "springs.initial_equilibrium": (center + 3.1).tolist()}, cycles=2)
    start = rmj.simulate(inside).data["equilibrium"].isel(time=0).values
    np.testing.assert_allclose(start, center + 3.1)
    outside = inside.replace({"springs.initial_equilibrium": (center + 3.2).tolist()})
    bounds = f"{center[0] - np.pi:.4g} to {center[0] + np.pi:.4g}"
    with pytest.raises(rmj.ResonanceError, match=rf"initial_equilibrium = .* joint1, .* {bounds}"):
        rmj.simulate(outside)


def test_experiments_that_share_an_arm_have_loads_of_their_own():
    """Springs are written into the loaded model: that of one robot is not that of another."""
    base = rmj.load("two-link-transfer")
    one = base.motion[0].model_dump() | {"duration": 6.0, "payload": 1.5}
    changes = [{"law.beta": beta, "motion": [one]} for beta in (2.0, 6.0, 10.0)]
    experiments = [base.replace(each) for each in changes]
    for together, experiment in zip(rmj.simulate_many(experiments), experiments, strict=True):
        alone = rmj.simulate(experiment)
        for name in ("q", "tau", "stiffness"):
            np.testing.assert_array_equal(together.data[name], alone.data[name])
