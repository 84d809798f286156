"""Antagonistic pairs: two tendons that stiffen are a spring that is set by their rest lengths."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import resonance_mj as rmj
from resonance_mj.errors import ResonanceError
from resonance_mj.evaluation.spring_parts import spring_parts
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots import elastic
from resonance_mj.springs.antagonist import Pair
from resonance_mj.springs.elements import Elements

PAIR = Pair(rate=500.0, hardening=2e4, pretension=2.0, holding=0.01)
FIRST = {"kind": "antagonistic", "joints": ["joint1"], "radii": [0.05], "pull": [500.0, 2e4]}
SECOND = {"kind": "antagonistic", "joints": ["joint2"], "radii": [-0.05], "pull": [100.0, 1e4]}
SHORT = {"motion.0.duration": 16.0, "motion.1.duration": 16.0}
PAIRS = [FIRST | {"pretension": 2.0, "holding": 0.01}, SECOND]


def with_pairs(pairs=PAIRS, **changes):
    return rmj.load("two-link-transfer").replace({"springs.element": pairs} | changes)


def test_a_taut_pair_is_a_linear_spring_of_the_stiffness_and_rest_that_its_ends_say():
    ends = (0.1, 0.16)
    k, rest = PAIR.spring(ends)
    assert k == pytest.approx(2 * (500 + 2e4 * 0.06))
    assert PAIR.ends(k, rest) == pytest.approx(ends)
    taut = np.linspace(*ends, 50)
    assert np.allclose(PAIR.force(taut, ends), -k * (taut - rest))
    beyond = np.array([0.08, 0.2])  # one tendon is slack, the other pulls alone
    x = np.array([0.16 - 0.08, 0.2 - 0.1])
    assert np.allclose(PAIR.force(beyond, ends), np.array([1, -1]) * (500 * x + 2e4 * x**2))
    assert np.allclose(PAIR.slack(beyond, ends), [[0.02, 0.0], [0.0, 0.04]])


def test_what_a_pair_stores_is_the_integral_of_what_it_exerts():
    ends, at = (0.1, 0.16), np.linspace(0.05, 0.22, 20_001)
    stored = PAIR.stored(at, ends).sum(axis=1)
    assert np.allclose(-np.gradient(stored, at)[1:-1], PAIR.force(at, ends)[1:-1], atol=1e-2)


def test_mujocos_tendons_exert_what_pairs_do_taut_and_slack():
    robot = plan_for(with_pairs()).robot
    springs = Elements(robot.elements, np.array([3000.0, -200.0, 900.0, 30.0]))
    elastic.write(robot.model, springs)
    read = elastic.read(robot.model, robot.elements).parameters
    assert np.allclose(read, springs.parameters)
    data = mujoco.MjData(robot.model)
    q = robot.home + np.random.default_rng(1).uniform(-3, 3, (40, 2))
    torque = springs.torque(q)
    slack = [
        one.pair.slack(q @ one.radii, one.pair.ends(*one.rests(p))) for one, p in springs.each()
    ]
    assert all(loose.any() for loose in slack)
    for pose, exerted in zip(q, torque, strict=True):
        data.qpos[robot.qpos_address] = pose
        mujoco.mj_forward(robot.model, data)
        assert np.allclose(data.qfrc_passive[robot.dof_address], exerted, atol=1e-9)


def least_of_a_taut_pair(element, lengths, force):
    """Least mean square of what any taut pair leaves of a force, stiffness by stiffness."""
    pair = element.pair

    def left(k):
        half = (k / 2 - pair.rate) / (2 * pair.hardening) - pair.stretch
        rest = np.clip((force + k * lengths).mean() / k, lengths.max() - half, lengths.min() + half)
        return float(((force + k * (lengths - rest)) ** 2).mean())

    softest = 2 * pair.rate + 2 * pair.hardening * (np.ptp(lengths) + 2 * pair.stretch)
    grid = softest * np.geomspace(1.0, 30.0, 3000)
    best = int(np.argmin([left(k) for k in grid]))
    around = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    found = minimize_scalar(left, bounds=around, method="bounded", options={"xatol": 1e-9})
    return min(float(found.fun), left(softest))


def test_the_law_comes_within_a_percent_of_the_best_taut_pairs_of_another_search():
    run = rmj.simulate(with_pairs())
    assert run.status == "ok"
    assert not any("slack" in note for note in run.notes)
    bound = 0
    for motion, joints, loaded in zip(run.motions, run.plan.joints, run.plan.loaded, strict=True):
        needed, best = loaded.torque(joints), 0.0
        for j, one in enumerate(run.plan.robot.elements):
            r = one.radii[j]
            best += r**2 * least_of_a_taut_pair(one, joints.q[:, j] * r, needed[:, j] / r)
        assert motion.torque_squared_optimal == pytest.approx(best, rel=1e-5)
        assert motion.torque_squared[-1] == pytest.approx(best, rel=0.01)
        assert motion.cycles_to_optimum <= 15
        last = list(motion.parameters.values())
        springs = Elements(run.plan.robot.elements, np.array([values[-1] for values in last]))
        for one, p in springs.each():
            pulls = one.pair.tension(joints.q @ one.radii, one.pair.ends(*one.rests(p)))
            assert pulls.min() > one.pair.pretension - 0.05
            bound += pulls.min() < one.pair.pretension + 0.05
    # Somewhere what keeps it taut decides: without that the springs would be others.
    assert bound


def test_pairs_beside_elements_over_two_joints_and_for_other_costs_are_at_their_optimum():
    both = [*PAIRS, {"joints": ["joint1", "joint2"], "radii": [0.03, -0.02]}]
    for experiment in (
        with_pairs(both, **SHORT),
        with_pairs(**SHORT, **{"springs.cost": "energy", "motors.k_m": 0.5}),
    ):
        run = rmj.simulate(experiment)
        assert run.status == "ok"
        for motion in run.motions:
            assert motion.cycles_to_optimum <= 15
            assert motion.cost[-1] == pytest.approx(motion.cost_optimal, rel=0.01)


def test_a_pair_that_goes_slack_in_a_run_is_said_and_not_blamed_for_a_lost_path():
    run = rmj.simulate(with_pairs([FIRST], **SHORT, **{"law.kind": "feedback"}))
    assert any("a tendon of joint1 is slack for" in note for note in run.notes)
    assert run.status == "not tracking"
    assert "slack" not in run.message
    assert 'law.kind = "transfer", which learns' in run.message


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"pull": None}, "needs pull"),
        ({"pull": [500.0, 0.0]}, "greater than 0"),
        ({"pull": [-1.0, 10.0]}, "greater than or equal to 0"),
        ({"joints": ["joint1", "joint2"], "radii": [1.0, 1.0]}, "over one joint"),
        ({"stiffness": [0.0, 900.0]}, "1000 together"),
        ({"stiffness": [0.0, 1200.0]}, "goes slack along motion.0"),
        ({"kind": "linear"}, "is of a pair"),
        ({"pretension": -1.0}, "pretension"),
    ],
)
def test_a_pair_that_cannot_be_is_refused_in_one_line(change, says):
    pair = {key: value for key, value in (FIRST | change).items() if value is not None}
    with pytest.raises(ResonanceError) as error:
        plan_for(with_pairs([pair]))
    assert says in str(error.value)
    assert "springs.element" in str(error.value)
    assert "\n" not in str(error.value)


def test_what_actuators_hold_and_what_changing_takes_is_counted(tmp_path):
    run = rmj.simulate(with_pairs(**SHORT))
    found = spring_parts(run)
    q = [motion.q for motion in found.motions]
    taken, uses = [], [[part.pair for part in motion.parts] for motion in found.motions]
    elements = run.plan.robot.elements
    for angles, pairs in zip(q, uses, strict=True):
        for one, use in zip(elements, pairs, strict=True):
            pulls = one.pair.tension(angles @ one.radii, use.ends)
            assert use.tension == pytest.approx((pulls.min(), pulls.max()))
            assert use.holding == pytest.approx(one.pair.holding * (pulls**2).sum(1).mean())
    assert uses[0][0].holding > 0 == uses[0][1].holding
    for into in (0, 1):
        more = 0.0
        for at, one in enumerate(elements):
            length = q[into][:1] @ one.radii
            before, after = (one.pair.stored(length, uses[of][at].ends) for of in (1 - into, into))
            more += np.maximum(after - before, 0).sum()
        taken.append(more)
    assert found.changing == pytest.approx(taken)
    run.save(tmp_path / "run")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "resonance_mj", "springs", str(tmp_path / "run")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "antagonistic pairs of motion 1" in done.stdout
    assert "changing the springs for the next motion takes" in done.stdout
