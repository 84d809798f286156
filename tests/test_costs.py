"""What springs leave the least of: what each cost is, its least, the law's way there, its words."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from scipy.optimize import minimize

import resonance_mj as rmj
from resonance_mj.errors import ExperimentError
from resonance_mj.evaluation.spring_parts import spring_parts
from resonance_mj.pictures.film.captions import fields
from resonance_mj.pictures.film.frame_data import of_run
from resonance_mj.plan.plan import plan_for
from resonance_mj.results.cycles import kept
from resonance_mj.springs.bounds import JointBounds
from resonance_mj.springs.cost import Cost, Drives, velocity
from resonance_mj.springs.elements import Element
from resonance_mj.springs.fit import fit

OTHERS = ("copper", "energy", "peak")
MOTORS = {
    "motors.k_m": [0.6, 0.4],
    "motors.gear_ratio": [10.0, 5.0],
    "motors.gear_efficiency": 0.8,
    "motors.no_load_friction": 0.01,
    "motors.regeneration": 0.5,
}


def asked(kind, name="two-link-transfer", **changes):
    return rmj.load(name).replace({"springs.cost": kind} | changes)


def by_hand(kind, tau, dq, motors):
    """The cost of a cycle, sample by sample, from what a motor and a gear do."""
    total, peak = 0.0, 0.0
    for torques, speeds in zip(tau, dq, strict=True):
        for j, (torque, speed) in enumerate(zip(torques, speeds, strict=True)):
            ratio, efficiency, k_m = (motors[name][j] for name in ("ratio", "efficiency", "k_m"))
            drives = torque * speed >= 0
            through = torque / efficiency if drives else torque * efficiency
            friction = motors["friction"][j] * np.sign(speed)
            shaft = through / ratio + friction
            heat = (shaft / k_m) ** 2
            power = shaft * ratio * speed + heat
            share = motors["regeneration"] if power < 0 else 1.0
            total += heat if kind == "copper" else share * power
            peak = max(peak, abs(torque) / motors["rated"][j])
    return peak if kind == "peak" else total / len(tau)


def motors_of(drives):
    return {
        "ratio": drives.gear_ratio,
        "efficiency": drives.gear_efficiency,
        "k_m": drives.k_m,
        "friction": drives.no_load_friction,
        "regeneration": drives.regeneration,
        "rated": drives.rated_torque,
    }


def some_motion(seed, n=2, steps=300):
    """A joint motion, the torque that it needs, and motors."""
    rng, t = np.random.default_rng(seed), np.arange(steps) / steps * 2 * np.pi
    waves = [np.sin(h * t[:, None] + rng.uniform(0, 6, n)) for h in (1, 2, 3)]
    q = 0.4 * sum(rng.normal(size=n) * wave / h for h, wave in enumerate(waves, start=1))
    torque = sum(5 * rng.normal(size=n) * wave for wave in waves[::-1]) - 15 * q + 3
    drives = Drives(
        k_m=rng.uniform(0.2, 1.0, n),
        gear_ratio=rng.uniform(1, 20, n),
        gear_efficiency=rng.uniform(0.7, 1.0, n),
        no_load_friction=rng.uniform(0.0, 0.05, n),
        regeneration=float(rng.uniform(0, 1)),
        rated_torque=rng.uniform(5, 20, n),
    )
    return q, torque, velocity(q, 1.0), drives


def bounds_of(n, kind, drives, most=np.inf, away=np.inf, elements=()):
    ends = np.full(n, -away), np.full(n, away)
    stiffness = np.zeros(n), np.full(n, most)
    objective = Cost(kind, drives)
    return JointBounds(stiffness, ends, np.zeros(n, bool), elements, objective=objective)


@pytest.mark.parametrize("kind", OTHERS)
@pytest.mark.parametrize("seed", range(3))
def test_a_cost_is_what_motors_and_gears_take_sample_by_sample(kind, seed):
    _, torque, dq, drives = some_motion(seed)
    expected = by_hand(kind, torque, dq, motors_of(drives))
    assert Cost(kind, drives).of(torque, dq) == pytest.approx(expected, rel=1e-12)


def test_velocities_are_those_of_the_fourier_series():
    t = np.arange(501) / 501 * 0.8
    w = 2 * np.pi / 0.8
    q = np.stack([np.sin(w * t) + 3, 0.2 * np.cos(7 * w * t)], axis=1)
    exact = np.stack([w * np.cos(w * t), -1.4 * w * np.sin(7 * w * t)], axis=1)
    assert np.allclose(velocity(q, 0.8), exact, atol=1e-9)


@pytest.mark.parametrize("kind", ["copper", "energy"])
def test_slope_and_curvature_of_a_cost_are_those_of_finite_differences(kind):
    _, torque, dq, drives = some_motion(4)
    cost, usual, step = Cost(kind, drives), np.array([20.0, 20.0]), 1e-5
    _, slope, curvature = cost.smooth(torque, dq, usual)
    above, below = (cost.smooth(torque + side * step, dq, usual) for side in (1, -1))
    scale = np.abs(slope).max()
    assert np.allclose((above[0] - below[0]) / (2 * step), slope, atol=1e-5 * scale)
    assert np.allclose((above[1] - below[1]) / (2 * step), curvature, rtol=1e-3, atol=1e-3)
    assert curvature.min() > -1e-6 * curvature.max()  # convex


@pytest.mark.parametrize("kind", OTHERS)
@pytest.mark.parametrize(("most", "away"), [(np.inf, np.inf), (12.0, 0.3)])
@pytest.mark.parametrize("seed", range(3))
def test_springs_are_the_best_that_another_solver_finds(kind, most, away, seed):
    q, torque, dq, drives = some_motion(seed)
    n = q.shape[1]
    found = fit(q, torque, bounds_of(n, kind, drives, most, away), q.mean(axis=0), dq)
    motors, left = motors_of(drives), []
    for j in range(n):
        own = {name: v if np.isscalar(v) else v[j : j + 1] for name, v in motors.items()}
        alone = Cost(kind, Drives(*(own[name] for name in OF_DRIVES)))
        z = q[:, j : j + 1] - q[:, j].mean()

        def cost(p, j=j, z=z, alone=alone):
            k = np.clip(p[0], 0.0, most)
            offset = p[1] if np.isinf(away) else np.clip(p[1], -k * away, k * away)
            return alone.of(torque[:, j : j + 1] + k * z - offset, dq[:, j : j + 1])

        starts = ((5.0, 0.0), (11.0, 3.0), (1.0, -1.0))
        exact = {"xatol": 1e-6, "fatol": 1e-9, "maxiter": 2000}
        tried = [minimize(cost, x0, method="Nelder-Mead", options=exact).fun for x0 in starts]
        left.append(min(tried))
    best = max(left) if kind == "peak" else sum(left)
    mine = Cost(kind, drives).of(torque - found.torque(q), dq)
    assert mine == pytest.approx(best, rel=1e-4)
    assert np.all(found.stiffness <= most)
    assert np.all(found.stiffness >= 0)
    if np.isfinite(away):
        assert np.all(np.abs(found.offset) <= found.stiffness * away * (1 + 1e-9))


OF_DRIVES = ("k_m", "ratio", "efficiency", "friction", "regeneration", "rated")


@pytest.mark.parametrize("kind", OTHERS)
def test_no_springs_and_elements_near_the_best_cost_less(kind):
    q, torque, dq, drives = some_motion(7)
    radii = np.array([1.0, -0.5])
    over = Element("pair", "linear", radii, (0.0, np.inf), None, 0.0, (-3.0, 3.0))
    bounds = bounds_of(2, kind, drives, elements=(over,))
    found = fit(q, torque, bounds, q.mean(axis=0), dq)
    alone = fit(q, torque, bounds_of(2, kind, drives), q.mean(axis=0), dq)
    cost = Cost(kind, drives)
    best = cost.of(torque - found.torque(q), dq)
    assert best <= cost.of(torque - alone.torque(q), dq) * (1 + 1e-6)
    rng = np.random.default_rng(0)
    for _ in range(200):
        away = 10 ** rng.uniform(-3, 0)
        k = np.maximum(found.stiffness + away * rng.normal(size=2), 0)
        offset = found.offset + away * rng.normal(size=2)
        p = found.others.parameters + away * rng.normal(size=2)
        p[0] = max(p[0], 0.0)
        near = found.__class__(k, offset, found.center, found.others._replace(parameters=p))
        assert cost.of(torque - near.torque(q), dq) >= best * (1 - 1e-5)


@pytest.mark.parametrize("kind", OTHERS)
@pytest.mark.parametrize("joints", [[1], [0, 1]])
@pytest.mark.parametrize("still", [False, True])
def test_joints_that_need_no_torque_or_stand_still_get_springs_that_do_nothing(kind, joints, still):
    q, torque, dq, drives = some_motion(3)
    torque[:, joints] = 0.0
    if still:
        q[:, joints], dq[:, joints] = 0.3, 0.0
    found = fit(q, torque, bounds_of(2, kind, drives), q.mean(axis=0), dq)
    exerted = found.torque(q)
    assert np.isfinite([*found]).all()
    # Corners are rounded by a thousandth of what is usual, a millinewton metre where nothing is.
    assert np.abs(exerted[:, joints]).max() < 2e-3 * max(1.0, np.abs(torque).max())
    cost = Cost(kind, drives)
    assert cost.of(torque - exerted, dq) <= cost.of(torque, dq) * (1 + 1e-4) + 1e-5


@pytest.mark.parametrize("kind", OTHERS)
def test_a_joint_that_stands_still_gets_the_softest_spring_that_holds_it(kind):
    t = np.linspace(0, 2 * np.pi, 500, endpoint=False)
    trembles = np.cos(7 * t)  # a stiffness of 333 would carry what is with it
    q = np.stack([0.4 * np.sin(t), 0.3 + 3e-6 * trembles], axis=1)
    torque = np.stack([2 * np.sin(t) + 0.3 * np.cos(3 * t), 0.6 - 1e-3 * trembles], axis=1)
    each = [np.full(2, value) for value in (0.5, 10.0, 1.0, 0.0, 30.0)]
    drives = Drives(*each[:4], 0.3, each[4])
    free = np.full(2, -np.inf), np.full(2, np.inf)
    for low, high in ((np.full(2, -1.5), np.full(2, 1.5)), free):
        any_ = np.zeros(2), np.full(2, np.inf)
        bounds = JointBounds(any_, (low, high), np.zeros(2, bool), objective=Cost(kind, drives))
        found = fit(q, torque, bounds, q.mean(axis=0), np.gradient(q, t[1], axis=0))
        assert found.offset[1] == pytest.approx(0.6, abs=2e-3)
        assert found.stiffness[1] == pytest.approx(0.4 if np.isfinite(high[1]) else 0.0, abs=0.01)


@pytest.mark.parametrize("kind", OTHERS)
def test_the_law_reaches_the_optimum_of_every_cost(kind):
    run = rmj.simulate(asked(kind, **MOTORS))
    assert run.status == "ok"
    units = {run.data[name].attrs["units"] for name in ("cost", "cost_optimal")}
    assert units == {"1" if kind == "peak" else "W"}
    motors = motors_of(run.plan.drives)
    last = {cycle.motion: cycle for cycle in kept(run)}
    for index, motion in enumerate(run.motions):
        assert motion.cycles_to_optimum <= 16
        assert motion.cost[-1] == pytest.approx(motion.cost_optimal, rel=0.01)
        # A judge of its own, from what was recorded.
        spent = by_hand(kind, last[index].tau, last[index].dq, motors)
        assert motion.cost[-1] == pytest.approx(spent, rel=1e-9)
        best, needed = run.plan.optima[index], run.plan.needed(index)
        springless = by_hand(kind, needed, best.dq, motors)
        assert motion.cost_without_springs == pytest.approx(springless, rel=1e-9)
        assert motion.reduction[-1] == pytest.approx(1 - spent / springless, rel=1e-9)


@pytest.mark.parametrize(
    "kind", ["energy", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("copper", "peak"))]
)
def test_seven_joints_reach_it_by_cycle_25_and_others_springs_cost_more(kind):
    run = rmj.simulate(asked(kind, "seven-joint"))
    (motion,) = run.motions
    assert run.status == "ok"
    assert motion.cycles_to_optimum <= 25
    assert motion.cost[-1] == pytest.approx(motion.cost_optimal, rel=0.01)
    best, squares = run.plan.optima[0], rmj.optimum(rmj.load("seven-joint"))[0]
    assert best.rate(best.torque) <= best.rate(squares.torque) * (1 + 1e-9)


def test_energy_that_all_comes_back_is_heat_in_windings_and_joints():
    # And what the joints' damping takes: springs give over a cycle what they take in.
    changes = {"motors.k_m": 0.5, "motors.regeneration": 1.0}
    damping = plan_for(rmj.load("two-link-transfer")).robot.damping
    energy, copper = (rmj.optimum(asked(kind, **changes)) for kind in ("energy", "copper"))
    for one, other in zip(energy, copper, strict=True):
        damped = (damping * one.dq**2).sum() * one.period / len(one.q)
        assert one.cost == pytest.approx(other.cost + damped, rel=1e-6)
        assert np.allclose(one.stiffness, other.stiffness, rtol=1e-4)


def test_a_motor_of_which_nothing_is_known_heats_with_100_w_at_its_limit():
    plan = rmj.simulate(asked("copper", "seven-joint", **{"motion.0.duration": 3.0})).plan
    drives, limit = plan.drives, plan.robot.torque_limit[:, 1]
    assert np.allclose(drives.rated_torque, limit)
    assert np.allclose(drives.copper_loss(limit[None], np.ones((1, 7))), 100.0)
    assert any("heat with 100 W" in note for note in plan.notes)


def test_ranges_are_of_the_cost_that_was_asked_for():
    for kind in OTHERS:
        best = rmj.optimum(asked(kind, **MOTORS))[0]
        without = best.rate(best.torque_without_springs)
        ends = best.stiffness_range(0.01)
        assert np.all(ends[:, 0] < best.stiffness)
        assert np.all(best.stiffness < ends[:, 1])
        for j, side in np.ndindex(ends.shape):
            fixed = [best.stiffness.copy(), best.stiffness.copy()]
            fixed[0][j] = fixed[1][j] = ends[j, side]
            bounds = best.bounds._replace(stiffness=tuple(fixed))
            spring = fit(best.q, best.torque_without_springs, bounds, best.center, best.dq)
            left = best.torque.copy()
            left[:, j] = (best.torque_without_springs - spring.torque(best.q))[:, j]
            rise = (best.rate(left) - best.rate(best.torque)) / without
            assert rise == pytest.approx(0.01, rel=0.05)


def test_the_summary_has_watts_joules_and_peak_whatever_the_cost(tmp_path):
    run = rmj.simulate(rmj.load("paper").replace({"motion.0.duration": 3.0}))
    segment = run.summary()["segments"][0]
    for of in ("", "_optimal", "_without_springs"):
        assert segment[f"electrical_energy{of}"] == pytest.approx(
            segment[f"electrical_power{of}"] * 1.0
        )
        assert segment[f"peak_torque{of}"] > 0
    assert "cost" not in segment
    run.save(tmp_path / "run")
    again = rmj.Run.load(tmp_path / "run")
    assert again.summary()["segments"][0] == segment
    assert math.isnan(rmj.simulate(run.experiment).motions[1].motors["peak_torque"]) is False


@pytest.mark.slow
def test_what_is_printed_drawn_and_said_is_of_the_cost(tmp_path):
    cut = {"motion.0.duration": 8.0, "motion.1.duration": 8.0}
    run = rmj.simulate(asked("energy", **MOTORS, **cut))
    assert "electrical power less by" in repr(run)
    assert "electrical power less by" in run._repr_html_()
    assert "electrical power less by" in repr(rmj.optimum(run.experiment)[0])
    shown = of_run(run, np.array([7.5]), "run")
    (words,) = [field for field in fields(shown, shown.sample[0]) if "best" in field]
    assert words.startswith("electrical power")
    assert f"{100 * run.motions[0].reduction_optimal:.1f} %" in words
    run.save(tmp_path / "run")
    (drawn,) = rmj.plot(run, tmp_path, figures=["cycles"], formats=["svg"])
    assert "electrical power per cycle [W]" in drawn.read_text(encoding="utf-8")
    page = rmj.report([run], tmp_path / "report.html", video=False, progress=False)
    assert "less electrical power" in page.read_text(encoding="utf-8")
    worth = spring_parts(run)
    assert worth.cost.name == "electrical power"
    assert worth.worth[2] <= worth.worth[1] <= worth.worth[0]
    command = [sys.executable, "-m", "resonance_mj", "springs", str(tmp_path / "run")]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "mean electrical" in said


@pytest.mark.slow
def test_certificates_judge_the_cost_and_say_where_none_can_be_judged():
    cut = {"motion.0.duration": 20.0, "motion.1.duration": 20.0}
    for kind in ("copper", "energy"):
        judged = [
            one
            for one in rmj.certify(rmj.simulate(asked(kind, **MOTORS, **cut))).items
            if one.claim.equation == "(12)"
        ]
        assert all(one.worst is not None and one.holds for one in judged)
    peak = rmj.certify(rmj.simulate(asked("peak", **cut)))
    assert [one.note for one in peak.items if one.claim.equation == "(12)"] == [
        "a peak has no slope that vanishes at its least"
    ] * 2


@pytest.mark.slow
def test_costs_step_together_as_one_by_one():
    experiments = [
        asked(kind, **{"motion.0.duration": 4.0, "motion.1.duration": 4.0}) for kind in OTHERS
    ]
    for alone, together in zip(
        map(rmj.simulate, experiments), rmj.simulate_many(experiments, progress=False), strict=True
    ):
        assert alone.data.identical(together.data)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"motors.k_m": 0.0}, "motors.k_m = 0.0"),
        ({"motors.k_m": [0.5, 0.5, 0.5]}, "motors.k_m = [0.5, 0.5, 0.5] has 3 numbers; 2"),
        ({"motors.gear_efficiency": 1.2}, "motors.gear_efficiency = 1.2"),
        ({"motors.gear_efficiency": 0.0}, "motors.gear_efficiency = 0.0"),
        ({"motors.no_load_friction": -1.0}, "motors.no_load_friction = -1.0"),
        ({"motors.regeneration": 2.0}, "motors.regeneration = 2.0"),
        ({"springs.cost": "joules"}, "springs.cost = 'joules'"),
    ],
)
def test_a_motor_that_is_none_is_refused_in_one_line(changes, words):
    with pytest.raises(ExperimentError) as refused:
        rmj.simulate(rmj.load("paper").replace(changes))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_weights_beside_another_cost_are_said_to_have_no_effect():
    pair = {"joints": ["joint1", "joint2"], "radii": [0.5, -1.5]}
    changes = {"springs.weights": [1.0, 2.0], "springs.element": [pair]}
    notes = rmj.simulate(asked("copper", **changes, **{"motion.0.duration": 1.0})).notes
    assert any("springs.weights" in note and "no effect" in note for note in notes)


@pytest.mark.slow
def test_a_sweep_keeps_watts_and_the_cost(tmp_path):
    (tmp_path / "sweep.toml").write_text(
        'experiment = "paper"\n[keys]\n"springs.cost" = ["torque-squared", "energy"]\n'
        '"motion.0.duration" = [3.0]\n"motion.1.duration" = [3.0]\n'
    )
    data = rmj.sweep(tmp_path / "sweep.toml", folder=tmp_path / "out", progress=False)
    power = data["electrical_power"]
    assert power.attrs["units"] == "W"
    assert np.isfinite(power).all()
    assert data["cost_reduction"].isnull().any()
    assert not data["cost_reduction"].sel({"springs.cost": "energy"}).isnull().any()


def test_the_optimum_of_a_cost_as_data():
    command = [sys.executable, "-m", "resonance_mj", "optimum", "paper", "--springs.cost", "energy"]
    said = subprocess.run([*command, "--json"], capture_output=True, text=True, check=True).stdout
    first = json.loads(said)["motions"][0]
    best = rmj.optimum(rmj.load("paper").replace({"springs.cost": "energy"}))[0]
    assert first["cost"] == pytest.approx(best.cost)
    assert first["reduction"] == pytest.approx(1 - best.cost / best.cost_without_springs)
