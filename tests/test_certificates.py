"""Certificates: the proof's claims where they hold, where they fail, and against closed forms."""

import dataclasses
import functools
import math
import subprocess
import sys

import numpy as np
import pytest
import two_link
from hypothesis import given
from hypothesis import strategies as st

import resonance_mj as rmj
from resonance_mj.evaluation.certificates import proof
from resonance_mj.evaluation.certificates.proof import untaken
from resonance_mj.laws import learning
from resonance_mj.springs import optimum
from resonance_mj.springs import spring as springs
from resonance_mj.springs.fit import LinearSprings, fit

ALPHA, K_V, K_P = 10.0, 200.0, 2000.0
GAMMA_K, GAMMA_QE = np.array([50.0, 5.0]), np.array([150.0, 10.0])
CYCLES = 6
TRANSFER = {
    "law__kind": "transfer",
    "law__lead": 1,
    "law__gamma_k": 0.0,
    "law__gamma_qe": 0.0,
}


def centered(first, second, **changes):
    durations = {"motion.0.duration": float(first), "motion.1.duration": float(second)}
    named = {key.replace("__", "."): value for key, value in changes.items()}
    return rmj.load("paper-centered").replace(durations | named)


@functools.cache
def short(lead, beta=1.0):
    """Both motions of the paper for a few cycles."""
    return rmj.simulate(centered(CYCLES, CYCLES, law__lead=lead, law__beta=beta))


@functools.cache
def diverging():
    return rmj.simulate(centered(40, 1, law__beta=10.0))


@functools.cache
def transferred():
    return rmj.simulate(centered(CYCLES, CYCLES, **TRANSFER))


@functools.cache
def bounded(kind):
    """Bounds that are active at the optimum of both motions."""
    limits = {"springs__stiffness": [0.0, 20.0], "springs__equilibrium": [-2.0, 2.0]}
    return rmj.simulate(centered(CYCLES, CYCLES, law__kind=kind, **limits))


def cycle(run, number):
    """A cycle's recorded signals."""
    data = run.data.isel(time=run.data["cycle_of_sample"].values == number)
    names = ("q", "dq", "x", "x_desired", "u", "y", "stiffness", "offset")
    return {name: data[name].values for name in names}


def dot(one, other):
    """∫ over a cycle of 1 s at 1 ms."""
    return float((one * other).sum() * 1e-3)


def values(found, equation, motion):
    item = found.of(equation)[motion - 1]
    return dict(zip(item.cycles.tolist(), item.values, strict=True))


def tampered(run, name, number, change):
    """The run with a recorded signal of one cycle changed."""
    data = run.data.copy(deep=True)
    data[name].values[data["cycle_of_sample"].values == number] += change
    return dataclasses.replace(run, data=data)


def verdicts(run):
    return {(item.claim.equation, item.motion): item.holds for item in rmj.certify(run).items}


# Against closed forms


MASS, DAMPING, AMPLITUDE, MIDDLE, OMEGA = 2.0, 3.0, 0.05, 0.1, 2 * np.pi


def slider(tmp_path, **changes):
    """A mass on a horizontal slide with viscosity, which repeats a sine: resonance by hand.

    It needs τ_d(0,0) = -mω²A sin ωt + dωA cos ωt, so that k_opt = mω² and τ_dopt = dωA cos ωt.
    """
    path = tmp_path / "slider.xml"
    path.write_text(
        f"""<mujoco><option gravity="0 0 0"/><worldbody><body name="cart">
        <joint name="slide" type="slide" axis="1 0 0" damping="{DAMPING}"/>
        <geom size=".05" mass="{MASS}"/><site name="tool"/></body></worldbody></mujoco>""",
        encoding="utf-8",
    )
    motion = {
        "shape": "fourier",
        "offset": [MIDDLE],
        "sin": [[AMPLITUDE]],
        "blend": 0,
        "duration": 5.0,
    }
    experiment = rmj.load("paper").replace(
        {
            "robot": {},
            "robot.mjcf": str(path),
            "robot.home": [MIDDLE],
            "task.coordinates": ["x"],
            "simulation.gravity": [0.0, 0.0, 0.0],
            "motion": [motion],
            "law.k_v": K_V,
            "law.k_p": K_P,
            "law.gamma_k": 800.0,
            "law.gamma_qe": 50.0,
            "law.beta": 4.0,
            "springs.initial_stiffness": 0.0,
            "springs.initial_equilibrium": 0.0,
            "law.q_c": [0.03],
            "law.q_s": [MIDDLE],
            **changes,
        }
    )
    return rmj.simulate(experiment)


def test_first_n_of_a_mass_at_resonance_is_what_it_is_by_hand(tmp_path):
    """U = 0 and the springs are slack: ∫τ_dopt²/β dt, and twice V of a start from rest."""
    found = rmj.certify(slider(tmp_path))
    k_opt = MASS * OMEGA**2
    offset_opt = k_opt * (MIDDLE - 0.03)
    learned = (DAMPING * OMEGA * AMPLITUDE) ** 2 / 2 / 4.0
    moving = MASS * (OMEGA * AMPLITUDE) ** 2
    sprung = k_opt**2 / 800.0 + offset_opt**2 / 50.0
    assert values(found, "(22)", 1)[1] == pytest.approx(learned + moving + sprung, rel=1e-9)
    assert found.unit == "N s/m"


def test_c_7_of_a_linear_arm_is_never_below_the_one_of_continuous_time(tmp_path):
    """For one mass V̇ = y Δu - Q(Δẋ, Δx) with a quadratic form Q >= c_7 y²."""
    run = slider(tmp_path, **{"simulation.timestep": 1e-4, "simulation.integrator": "RK4"})
    found = rmj.certify(run)
    k_opt = MASS * OMEGA**2
    cross = (k_opt + ALPHA * (DAMPING - ALPHA * MASS)) / 2
    Q = np.array([[K_V + DAMPING - ALPHA * MASS, cross], [cross, ALPHA * (K_P + k_opt)]])
    a = np.array([1.0, ALPHA])  # y = aᵀ (Δẋ, Δx)
    least = 1 / (a @ np.linalg.solve(Q, a))
    c_7 = np.array(list(values(found, "(15)", 1).values()))
    assert c_7.size == 4
    assert least > 50
    assert (c_7 > 0.99 * least).all()
    assert (c_7 < 5 * least).all()


@pytest.mark.parametrize("lead", [0, 1])
@pytest.mark.parametrize("motion", [1, 2])
def test_n_and_c_7_are_those_of_the_paper_s_arm_in_closed_form(motion, lead):
    """(16) in the task space, with R(q), q_d, τ_d and K_opt from the arm's own mechanics."""
    run = short(lead)
    t = np.arange(1000) * 1e-3
    x_d, dx_d, ddx_d = (two_link.first_motion, two_link.second_motion)[motion - 1](t)
    q_d, dq_d, ddq_d = two_link.joint_motion(x_d, dx_d, ddx_d)
    q_c = two_link.joint_motion(*two_link.first_motion(t))[0].mean(axis=0)
    needed = two_link.inverse_dynamics(q_d, dq_d, ddq_d)
    best = [
        np.linalg.lstsq(np.stack([q_c[j] - q_d[:, j], np.ones(1000)], 1), needed[:, j])[0]
        for j in range(2)
    ]
    k_opt, offset_opt = np.transpose(best)
    wanted = needed + k_opt * (q_d - q_c) - offset_opt

    def V(state, k, offset):  # noqa: N802
        q, dq, x = state
        J, error = two_link.jacobian(q), x - x_d[0]
        rate, s = J @ dq - dx_d[0], np.sin(error)
        R_J = np.linalg.solve(J.T, two_link.inertia(q)) @ np.linalg.inv(J)
        motion = 0.5 * rate @ R_J @ rate + ALPHA * rate @ R_J @ s + 0.5 * ALPHA**2 * s @ R_J @ s
        motion += ((K_P + ALPHA * K_V) * (1 - np.cos(error))).sum()
        away = (k - k_opt) ** 2 / GAMMA_K + (offset - offset_opt) ** 2 / GAMMA_QE
        return motion + 0.5 * away.sum()

    found = rmj.certify(run)
    N, c_7 = values(found, "(22)", motion), values(found, "(15)", motion)
    begin = 1 + (motion - 1) * CYCLES
    assert list(N) == list(range(begin, begin + CYCLES))
    assert list(c_7) == list(range(begin, begin + CYCLES - 1))
    for number in c_7:
        now, then = cycle(run, number), cycle(run, number + 1)
        states = [tuple(one[name][0] for name in ("q", "dq", "x")) for one in (now, then)]
        V_0, V_1 = (
            V(state, one["stiffness"][0], one["offset"][0])
            for state, one in zip(states, (now, then), strict=True)
        )
        du, y = now["u"] - wanted, np.roll(now["y"], -lead, axis=0)
        assert N[number] == pytest.approx(dot(du, du) + 2 * V_0, rel=1e-6)
        assert c_7[number] == pytest.approx((dot(du, y) - (V_1 - V_0)) / dot(y, y), rel=1e-4)


def test_v_grows_along_a_run_as_17_says():
    """V̇ by differences is yᵀΔu - ‖Δẋ‖²_Kv - α sᵀK_p s + yᵀζ, with ζ from the arm's own mechanics.

    Of what N adds up, this alone knows V: without any one of its three parts it does not hold.
    """
    dt = 1e-4
    run = rmj.simulate(
        centered(
            2, 1, simulation__timestep=dt, simulation__integrator="RK4", law__velocity="jacobian"
        )
    )
    plan, now = run.plan, cycle(run, 2)
    best, q, dq = plan.optima[0], now["q"], now["dq"]
    y, k, offset, q_c = now["y"], now["stiffness"], now["offset"], plan.q_c
    t = np.arange(len(q)) * dt
    x_d, dx_d, _ = two_link.first_motion(t)
    error = now["x"] - x_d
    rate = np.einsum("tij,tj->ti", two_link.jacobian(q), dq) - dx_d

    weight = K_P + ALPHA * K_V
    parts = {
        "R": [
            proof.motion_energy(y[i], two_link.inertia(q[i]), 0 * x_d[0], 0 * x_d[0])
            for i in range(len(q))
        ],
        "x": [proof.motion_energy(0 * y[0], np.eye(2), e, np.full(2, weight)) for e in error],
        "k": [
            proof.spring_energy(a - best.stiffness, b - best.offset, GAMMA_K, GAMMA_QE)
            for a, b in zip(k, offset, strict=True)
        ],
    }

    def slope(signal):
        return (np.asarray(signal)[2:] - np.asarray(signal)[:-2]) / (2 * dt)

    dq_r = dq - y
    # R q̈_r + (Ṙ/2 + S) q̇_r: the torque is quadratic in the speed, and this is its bilinear form.
    both, one, other = (two_link.coriolis(q, v) for v in (dq + dq_r, dq, dq_r))
    inertial = np.einsum("tij,tj->ti", two_link.inertia(q)[1:-1], slope(dq_r))
    mean = ((both - one - other) / 2)[1:-1]
    needed = best.torque_without_springs - springs.torque(best.stiffness, best.offset, best.q, q_c)
    pull = springs.torque(best.stiffness, best.offset, q, q_c)
    zeta = (needed + pull - two_link.D * dq - two_link.gravity(q))[1:-1] - inertial - mean
    s = np.sin(error)
    wanted = ((now["u"] - needed) * y - K_V * rate**2 - ALPHA * K_P * s**2).sum(axis=1)[1:-1]
    wanted += (y[1:-1] * zeta).sum(axis=1)
    slopes = {name: slope(part) for name, part in parts.items()}
    size = np.abs(wanted).max()
    assert np.abs(sum(slopes.values()) - wanted).max() < 0.02 * size
    for name in parts:
        without = sum(part for other_name, part in slopes.items() if other_name != name)
        assert np.abs(without - wanted).max() > 0.2 * size


# What the proof says


@pytest.mark.parametrize(("lead", "beta"), [(0, 1.0), (1, 1.0), (1, 2.0)])
def test_n_changes_by_exactly_what_the_proof_adds_up(lead, beta):
    """(14) and (23) without their inequalities, from what was recorded."""
    run = short(lead, beta)
    found = rmj.certify(run)
    optima = rmj.optimum(run.experiment)
    q_s = optima[0].q.mean(axis=0)
    for motion, best in enumerate(optima, start=1):
        N, c_7 = values(found, "(22)", motion), values(found, "(15)", motion)
        for number in c_7:
            now = cycle(run, number)
            y, q_bar = np.roll(now["y"], -lead, axis=0), now["q"] - q_s
            dropped = learning.spring_like_part(now["u"] - beta * y, q_bar) * q_bar
            third = 2 * dot(best.torque, dropped) - dot(dropped, dropped)
            change = -2 * (c_7[number] - beta / 2) * dot(y, y) + third / beta
            assert N[number + 1] - N[number] == pytest.approx(change, rel=1e-9, abs=1e-9)
            # What the optimum's orthogonality leaves of the third term is of second order in Δq.
            away = (best.torque * (now["q"] - best.q)).sum(axis=0) * 1e-3
            assert third <= (away**2 / (q_bar**2).sum(axis=0) / 1e-3).sum() + 1e-12


def test_transfer_leaves_only_a_product_of_errors_beside_what_is_learned():
    """Δu(t+T) = Δu - L y⁺ + (K_{i+1} - K_i) Δq, Δu from what the motion needs of the motors."""
    run = rmj.simulate(centered(4, 1, **TRANSFER, law__harmonics=500, law__beta=2.0))
    best = rmj.optimum(run.experiment)[0]

    def error(now, center):
        spring = springs.torque(now["stiffness"][0], now["offset"][0], best.q, center)
        return now["u"] + spring - best.torque_without_springs

    centers = run.data["center"].values[::1000]
    for number in (1, 2, 3):
        now, then = cycle(run, number), cycle(run, number + 1)
        handed = (then["stiffness"][0] - now["stiffness"][0]) * (now["q"] - best.q)
        wanted = error(now, centers[number - 1]) - 2.0 * np.roll(now["y"], -1, axis=0) + handed
        np.testing.assert_allclose(error(then, centers[number]), wanted, atol=1e-10)


@pytest.mark.parametrize("run", [lambda: short(0), lambda: short(1), transferred])
def test_everything_holds_where_the_proof_says_so(run):
    found = rmj.certify(run())
    assert len(found.items) == 10
    for item in found.items:
        assert item.holds, item
    for item in found.of("(15)"):
        assert item.worst > found.enough
    for item in found.of("(11)"):
        assert item.worst < 1e-13
    for item in found.of("(22)"):
        assert (np.diff(item.values) < 0).all()


def test_passivity_is_lost_before_the_run_diverges_and_n_grows_from_then_on():
    run = diverging()
    assert run.status is rmj.Status.DIVERGED
    found = rmj.certify(run)
    c_7, N = values(found, "(15)", 1), values(found, "(22)", 1)
    assert found.enough == 5.0
    short_of = [number for number in c_7 if c_7[number] < found.enough]
    grows = [number for number in c_7 if N[number + 1] > N[number]]
    # N falls while c_7 > β/2, and grows in every cycle after the first that falls well short.
    assert short_of == list(range(short_of[0], max(c_7) + 1))
    assert set(grows) <= set(short_of)
    assert grows == list(range(grows[0], max(c_7) + 1))
    passive, falling = found.of("(15)")[0], found.of("(22)")[0]
    assert passive.holds is falling.holds is False
    assert passive.worst < -10
    assert falling.worst > 1.2
    assert falling.cycles[falling.fails].tolist() == grows
    # Long before torque² shows it, and while (9), (11) and (12) hold to rounding.
    assert grows[0] < run.data.sizes["cycle"] - 5
    assert all(verdicts(run)[equation, 1] for equation in ("(9)", "(11)", "(12)"))


@pytest.mark.parametrize("kind", ["paper", "transfer"])
def test_orthogonality_holds_with_active_bounds(kind):
    found = verdicts(bounded(kind))
    for equation in ("(9)", "(11)", "(12)"):
        assert found[equation, 1]
        assert found[equation, 2]


@pytest.mark.parametrize("number", [CYCLES, 2 * CYCLES])
def test_bounded_springs_leave_torque_that_only_a_better_spring_could_take(number):
    """With active bounds u is not orthogonal to 1 and q, and yet no feasible spring could help."""
    run = bounded("transfer")
    now = cycle(run, number)
    center = run.data["center"].values[run.data["cycle_of_sample"].values == number][0]
    acting = LinearSprings(now["stiffness"][0], now["offset"][0], center)
    q, u = cycle(run, number - 1)["q"], now["u"]
    bounds = run.experiment.springs
    assert np.abs(untaken(u, q, acting, bounds)).max() < 1e-12
    free = bounds.model_copy(
        update=dict.fromkeys(("stiffness", "equilibrium"), (-math.inf, math.inf))
    )
    assert np.abs(untaken(u, q, acting, free)).max() > 0.1


def test_printed_12_holds_with_its_own_equilibrium_wherever_the_stiffness_is_free():
    """At a bound of q_e the spring can still be scaled: ∫τ_dopt (q_d - q_eopt) dt = 0."""
    experiment = rmj.load("paper-centered").replace(
        {"springs.stiffness": [0.0, math.inf], "springs.equilibrium": [-0.5, 0.5]}
    )
    best = rmj.optimum(experiment)[0]
    away = best.equilibrium - best.center
    assert abs(away[0]) == pytest.approx(0.5)
    assert best.stiffness[0] > 0
    torque, q_bar = best.torque[:, 0], best.q[:, 0] - best.equilibrium[0]
    assert abs(torque @ q_bar) < 1e-12 * np.linalg.norm(torque) * np.linalg.norm(q_bar)
    assert abs(torque.sum()) > 0.1 * np.abs(torque).sum()


@given(
    point=st.tuples(*[st.floats(-50, 50)] * 2),
    other=st.tuples(st.floats(0, 1), st.floats(0, 1)),
    gammas=st.tuples(*[st.floats(0.1, 500)] * 2),
    k_max=st.sampled_from([5.0, 30.0, math.inf]),
    reach=st.sampled_from([(-0.5, 2.0), (0.3, 1.0), (-math.inf, math.inf)]),
)
def test_projecting_the_springs_never_raises_their_energy(point, other, gammas, k_max, reach):
    """Towards every feasible spring f, the optimum included: ⟨p - Pp, f - Pp⟩ <= 0 in Γ⁻¹.

    Hence |Pp - f|² <= |p - f|² - |p - Pp|² in the metric of V's last two terms.
    """
    gamma_k, gamma_qe = gammas
    metric = np.array([1 / gamma_k, 1 / gamma_qe])
    k = other[0] * min(k_max, 60.0)
    low, high = (k * end if math.isfinite(end) else math.copysign(60.0, end) for end in reach)
    feasible = np.array([k, low + other[1] * (high - low)])
    p = np.array(point)
    projected = np.array(springs.nearest(*p, 0.0, k_max, *reach, gamma_qe / gamma_k))
    room = 1e-9 * (1 + metric @ (p**2 + feasible**2))
    assert metric @ ((p - projected) * (feasible - projected)) <= room
    before, after = (metric @ (at - feasible) ** 2 for at in (p, projected))
    assert after <= before - metric @ (p - projected) ** 2 + room


def test_adaptation_at_the_bounds_spends_no_more_energy_than_without_them():
    """At each step of a run V's spring terms grow by y (φ Δk - Δq̄_e) Δt and Euler's own at most."""
    run = bounded("paper")
    at_bounds = 0
    for motion, best in enumerate(rmj.optimum(run.experiment)):
        for number in range(1 + motion * CYCLES, 1 + (motion + 1) * CYCLES):
            now = cycle(run, number)
            center = run.data["center"].values[0]
            assert np.allclose(center, best.center)
            dk, d_offset = now["stiffness"] - best.stiffness, now["offset"] - best.offset
            energy = 0.5 * (dk**2 / GAMMA_K + d_offset**2 / GAMMA_QE)
            phi, y = now["q"] - center, now["y"]
            first = 1e-3 * y * (phi * dk - d_offset)
            euler = 0.5 * (1e-3 * y) ** 2 * (GAMMA_K * phi**2 + GAMMA_QE)
            assert (energy[1:] <= (energy + first + euler)[:-1] + 1e-12).all()
            # Without bounds it would be equal.
            at_bounds += int((energy[1:] < (energy + first + euler)[:-1] - 1e-9).sum())
    assert at_bounds > 100


# What is caught


def test_learned_torque_changed_in_one_cycle_is_caught_there():
    run = short(1)
    q = cycle(run, 2)["q"]
    parallel = tampered(run, "u", 3, 1e-6 * (q - q.mean(axis=0)))
    item = rmj.certify(parallel).of("(11)")[0]
    assert item.holds is False
    assert item.cycles[item.fails].tolist() == [2]
    assert item.where.startswith("2, joint")
    # What is orthogonal to q̄ passes (11), but not (9), which follows each cycle to the next.
    phase = 2 * np.pi * np.arange(1000)[:, None] / 1000
    wave = np.sin(40 * phase) * np.ones(2)
    wave -= learning.spring_like_part(wave, q - q.mean(axis=0)) * (q - q.mean(axis=0))
    item = rmj.certify(tampered(run, "u", 3, 1e-6 * wave)).of("(9)")[0]
    assert item.cycles[item.fails].tolist() == [2, 3]


def test_a_spring_changed_in_one_cycle_of_a_transfer_is_caught_there():
    item = rmj.certify(tampered(transferred(), "stiffness", 3, 1e-6)).of("(9)")[0]
    assert item.cycles[item.fails].tolist() == [2]


@pytest.mark.parametrize("kind", ["stiffness", "offset"])
def test_an_optimum_that_is_not_one_is_caught_whatever_it_was_found_by(kind, monkeypatch):
    """(12) is judged by the torque that is left, and does not ask again who found the springs."""

    def wrong(*arguments):
        best = fit(*arguments)
        return dataclasses.replace(best, **{kind: 1.000001 * getattr(best, kind)})

    monkeypatch.setattr(optimum, "fit", wrong)
    monkeypatch.setattr(proof, "fit", wrong, raising=False)
    run = dataclasses.replace(short(0), planned=None)
    assert [item.holds for item in rmj.certify(run).of("(12)")] == [False, False]


def test_a_robot_that_changed_since_the_run_is_refused(tmp_path):
    run = slider(tmp_path)
    path = tmp_path / "slider.xml"
    path.write_text(path.read_text().replace(f'mass="{MASS}"', 'mass="2.1"'))
    with pytest.raises(rmj.ResonanceError, match=r"slider\.xml: is not the robot of the run"):
        rmj.certify(dataclasses.replace(run, planned=None))


# What is read


def test_a_saved_run_has_the_certificates_of_the_fresh_one(tmp_path):
    run = short(0)
    loaded = rmj.Run.load(run.save(tmp_path))
    for one, other in zip(rmj.certify(run).items, rmj.certify(loaded).items, strict=True):
        assert (one.worst, one.where) == (other.worst, other.where)
        np.testing.assert_array_equal(one.values, other.values)


def test_a_thinned_run_is_judged_in_the_cycles_that_it_kept():
    experiment = centered(20, 3, law__lead=1)
    whole = rmj.certify(rmj.simulate(experiment))
    run = rmj.simulate(experiment.replace({"simulation.samples": 9000}))
    kept = np.unique(run.data["cycle_of_sample"])
    thin = rmj.certify(run)
    assert thin.of("(22)")[0].cycles.tolist() == [n for n in kept if n <= 20]
    assert len(thin.of("(22)")[0].cycles) < 10
    for equation in ("(9)", "(11)", "(15)"):
        assert thin.of(equation)[0].cycles.size >= 3
    for one, other in zip(thin.items, whole.items, strict=True):
        if one.cycles.size:
            at = np.isin(other.cycles, one.cycles)
            np.testing.assert_array_equal(one.values, other.values[at])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law.jacobian": "transpose"}, "no proof with Jᵀ"),
        ({"law.beta": 0.0}, "learning gain is 0"),
        ({"motion.0.duration": 1.0}, "no two cycles"),
    ],
)
def test_what_does_not_apply_says_why(changes, words):
    found = rmj.certify(rmj.simulate(centered(2, 1).replace(changes)))
    for equation in ("(15)", "(22)"):
        item = found.of(equation)[0]
        assert item.holds is None
        assert words in item.note
    assert all(item.holds for item in found.of("(12)"))


def test_an_arm_with_joints_to_spare_is_judged_by_the_motion_that_it_made():
    run = rmj.simulate(
        rmj.load("planar-three-link").replace({"motion.0.duration": 8.0, "law.harmonics": 20})
    )
    found = rmj.certify(run)
    assert all(item.holds for item in found.items)
    # Its first cycle is the passage from rest, from which nothing is learned.
    assert found.of("(22)")[0].cycles.tolist() == list(range(2, 9))


# As a user meets it


def command(*arguments, cwd):
    line = [sys.executable, "-m", "resonance_mj.cli", *map(str, arguments)]
    return subprocess.run(line, cwd=cwd, capture_output=True, text=True, timeout=300)


def test_run_certify_prints_and_draws_and_leaves_the_run_s_status_alone(tmp_path):
    fails = command(
        "run", "paper-centered", "--certify", "--law.beta", "10", "--out", "x", cwd=tmp_path
    )
    assert fails.returncode == 1
    assert len(fails.stderr.splitlines()) == 1
    for words in ("certificates", "(11) u(t+T) ⟂ q̄", "holds 1-20", "fails 1", "not judged"):
        assert words in fails.stdout
    assert {"certificates.svg", "certificates.png"} <= {p.name for p in (tmp_path / "x").iterdir()}
    svg = (tmp_path / "x" / "certificates.svg").read_text(encoding="utf-8")
    for words in ("(15) motion 1", "grows from here", "N falls above 5"):
        assert words in svg
    assert "motion 2" not in svg  # It was not reached.


def test_certify_of_what_is_no_run_is_refused_in_one_line(tmp_path):
    refused = command("certify", tmp_path, cwd=tmp_path)
    assert refused.returncode == 2
    (line,) = refused.stderr.splitlines()
    assert "holds no run" in line


@pytest.mark.slow
def test_a_run_loads_no_certificates_and_can_be_certified_later(tmp_path):
    script = """
import sys
from resonance_mj.cli import main
main(["run", "paper", "--motion.0.duration", "2", "--motion.1.duration", "2"])
print(sorted(name for name in sys.modules if name.startswith("resonance_mj.")))
sys.exit(main(["certify", "runs/paper", "--out", "drawn"]))
"""
    process = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert (process.returncode, process.stderr) == (0, "")
    (loaded,) = [line for line in process.stdout.splitlines() if line.startswith("['")]
    assert "'resonance_mj.simulation.simulation'" in loaded
    for name in ("certificates", "results.cycles", "proof", "certificate_figure"):
        assert f".{name}'" not in loaded
    assert "(22) N falls" in process.stdout
    assert {path.name for path in (tmp_path / "drawn").iterdir()} == {
        "certificates.svg",
        "certificates.png",
    }
