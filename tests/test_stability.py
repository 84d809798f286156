"""Stability of the learning before a run: against MuJoCo, against exact operators, against runs."""

import math

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.errors import StabilityError
from resonance_mj.laws import equations
from resonance_mj.laws.stability import sampled_loop, stability
from resonance_mj.laws.stability.divergence import POSES, divergences
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots.robot import build

PENDULUM = """
<mujoco>
  <worldbody>
    <body>
      <joint name="hinge" axis="0 1 0" damping="0.3" armature="0.002"/>
      <geom type="sphere" pos="0.05 0 -0.4" size="0.03" mass="1.2" contype="0" conaffinity="0"/>
      <site name="tool" pos="0 0 -0.5"/>
    </body>
  </worldbody>
</mujoco>
"""

GIVEN = """
import numpy as np

def learn(u, y, q, stiffness, offset, center, parameters):
    phase = 2 * np.pi * np.arange(len(u)) / len(u)
    given = sum(np.cos(h * phase + h) for h in parameters[2:])
    following = np.zeros_like(u)
    following[:, int(parameters[0])] = parameters[1] * given
    return following, stiffness, offset, center
"""
"""A law that plays a sum of harmonics to one joint in every cycle."""

HARMONICS = (1, 4, 20, 90, 250, 421, 499)


def at_rest(robot, coordinates, home, center, changes):
    """An experiment that keeps an arm at a pose without gravity, for four cycles of 1 s."""
    still = {"duration": 4.0, "shape": "fourier", "offset": center, "blend": 0}
    return rmj.load("paper").replace(
        {
            "robot": {"mjcf": str(robot), "tool": "tool", "home": home},
            "task.coordinates": coordinates,
            "simulation.gravity": (0.0, 0.0, 0.0),
            "motion": [still],
            **changes,
        }
    )


def measured_response(experiment, folder, size):
    """Y / U of each pair of joints at `HARMONICS` in MuJoCo, under a small torque (H, n, n)."""
    law = folder / "given.py"
    law.write_text(GIVEN)
    runs = [
        rmj.simulate(
            experiment.replace(
                {"law.kind": str(law), "law.parameters": [joint, size * 1e-4, *HARMONICS]}
            )
        )
        for joint in range(size)
    ]
    columns = []
    for joint, run in enumerate(runs):
        last = run.data.isel(time=slice(-1000, None))
        y, u = (np.fft.rfft(last[name].values, axis=0)[list(HARMONICS)] for name in ("y", "u"))
        columns.append(y / u[:, joint, None])
    return np.stack(columns, axis=-1)


def predicted_response(experiment):
    plan = plan_for(experiment)
    loop = sampled_loop.along(
        experiment,
        plan.kinematics,
        plan.gains,
        plan.joints[0].q[:1],
        stiffness=np.broadcast_to(experiment.springs.initial_stiffness, plan.robot.n),
        q_c=np.asarray(experiment.law.q_c),
    )
    z = stability.on_circle(np.array(HARMONICS), 1000)
    return (loop.C[:, None] @ loop.state(z))[0]


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_the_sampled_response_of_a_pendulum_is_that_of_mujoco_up_to_half_the_sampling(
    integrator, tmp_path
):
    """With damping, a spring, feedback, and (6), (7) that follow y."""
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    experiment = at_rest(
        tmp_path / "pendulum.xml",
        ["x"],
        [0.3],
        [-0.5 * math.sin(0.3)],
        {
            "simulation.integrator": integrator,
            "law.k_v": 60.0,
            "law.k_p": 300.0,
            "law.gamma_k": 50.0,
            "law.gamma_qe": 200.0,
            "law.q_c": [-0.4],
            "law.q_s": [0.0],
            "springs.initial_stiffness": 7.0,
            "springs.initial_equilibrium": 0.3,
        },
    )
    predicted = predicted_response(experiment)
    # k = 7 with q_e at home exerts nothing there, whatever q_c.
    measured = measured_response(experiment, tmp_path, 1)
    np.testing.assert_allclose(measured, predicted, rtol=2e-4)


@pytest.mark.parametrize(
    "law",
    [
        {"law.jacobian": "inverse"},
        {"law.jacobian": "transpose"},
        {"law.jacobian": None, "law.k_v": None, "law.k_p": None, "law.omega": 60.0},
    ],
)
def test_the_sampled_response_of_two_joints_is_that_of_mujoco_for_each_feedback(law, tmp_path):
    experiment = at_rest(
        "two_link.xml",
        ["x", "z"],
        [4.00114, -2.00057],
        [-0.3, 0.0],
        {"law.gamma_k": 0.0, "law.gamma_qe": 0.0, "law.q_c": [0.0, 0.0]} | law,
    )
    start = plan_for(experiment).joints[0].q[0]
    experiment = experiment.replace({"robot.home": start.tolist()})
    measured, predicted = measured_response(experiment, tmp_path, 2), predicted_response(experiment)
    largest = np.abs(predicted).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(measured / largest, predicted / largest, atol=1e-3)


@pytest.mark.parametrize("jacobian", ["inverse", "transpose", "damped"])
@pytest.mark.parametrize("near", [False, True])
def test_the_error_signal_is_linearised_as_the_law_computes_it(jacobian, near):
    """For the damped inverse at a usual pose and near a singular one, with joints to spare."""
    robot = build(rmj.load("paper" if jacobian == "inverse" else "planar-three-link"))
    n, m = robot.n, robot.m
    J = np.random.default_rng(2).normal(size=(m, n))
    J[1] = J[0] + (0.01 if near else 1.0) * J[1]
    found = sampled_loop.error_signal(robot, jacobian, J[None], 7.0, 3.0)[0]
    for column in range(2 * n):
        dq, q = np.zeros(n), np.zeros(n)
        (q if column < n else dq)[column % n] = 1.0
        y, rate, s = np.zeros(n), J @ dq, J @ q
        if jacobian == "inverse":
            equations.error_inverse(J, rate, 7.0, s, np.zeros((n, n)), y)
        elif jacobian == "transpose":
            equations.error_transpose(J, rate, 7.0, s, y)
        else:
            drift = dq + 3.0 * q
            work = np.zeros((m + 1, m))
            equations.error_damped(J, rate, 7.0, s, drift, 0.1 * robot.usual, work, y)
        np.testing.assert_allclose(found[:, column], y, rtol=1e-6, atol=1e-7)


# How poses are put together


def alone(motion, cycles, changes=(), shift=0.0):
    """A motion of `paper-centered` alone, begun `shift` of a cycle later, at rest at its start."""
    paper = rmj.load("paper-centered")
    given = paper.motion[motion]
    turn = np.exp(-2j * np.pi * shift * np.arange(1, 3))
    sin, cos = (
        np.array([[*row, *(0.0,) * (2 - len(row))] for row in rows or ((), ())])
        for rows in (given.sin, given.cos)
    )
    turned = (cos + 1j * sin) * turn
    repeated = given.model_dump() | {
        "duration": float(cycles),
        "sin": turned.imag.tolist(),
        "cos": turned.real.tolist(),
    }
    experiment = paper.replace({"motion": [repeated], **dict(changes)})
    return experiment.replace({"robot.home": rmj.optimum(experiment)[0].q[0].tolist()})


def prediction(experiment):
    one = plan_for(experiment)
    (why,) = divergences(one.experiment, one.loaded, one.gains, one.joints, one.optima, one.q_c)
    return why


def loops(experiment):
    """The sampled arm at every time step of its motion, and the loop of learning from some."""
    one = plan_for(experiment)
    (joints,), (best,) = one.joints, one.optima

    def along(q):
        return sampled_loop.along(
            one.experiment, one.kinematics, one.gains, q, stiffness=best.stiffness, q_c=one.q_c
        )

    steps = len(joints.q)
    at = joints.q[np.arange(POSES) * steps // POSES]
    examined = stability.examined(steps, one.gains.harmonics)
    learns = stability.learning_loop(along(at), one.gains.learning, steps, examined)
    return along(joints.q), learns


@pytest.mark.parametrize(("beta", "stable"), [(10.0, True), (15.0, False)])
def test_coupled_harmonics_grow_as_those_of_the_arm_that_moves(beta, stable):
    """Against the exact operator of the time-varying arm over a cycle, on its first 12 harmonics.

    In motion 2 the arm comes near to where its feedback is weak. If that pose were held learning
    would diverge, but the arm is there for a short time.
    """
    kept, lead = 12, 1
    arm, learns = loops(alone(1, 2, {"law.beta": beta, "law.lead": lead, "law.harmonics": kept}))
    steps, n = len(arm.A), 2
    phase = 2 * np.pi * np.arange(steps)[:, None] / steps * np.arange(1, kept + 1)
    basis = np.concatenate([np.ones((steps, 1)), np.cos(phase), np.sin(phase)], axis=1)
    size = basis.shape[1]
    basis /= np.linalg.norm(basis, axis=0)
    u = np.einsum("ts,ij->tisj", basis, np.eye(n)).reshape(steps, n, -1)
    x, y = np.zeros((arm.A.shape[-1], size * n)), np.zeros_like(u)
    for _ in range(3):
        for t in range(steps):
            y[t] = arm.C[t] @ x
            x = arm.A[t] @ x + arm.B[t] @ u[t]
    P = np.eye(size * n) - beta * np.einsum("tia,tib->ab", u, np.roll(y, -lead, axis=0))
    exact = np.abs(np.linalg.eigvals(P)).max()
    coupled = np.abs(np.linalg.eigvals(np.eye(size * n) - learns.coupled(lead))).max()
    assert learns.multiplier(lead).max() > 2, "a pose that is held"
    assert coupled == pytest.approx(exact, rel=0.02)
    assert (exact <= 1 + stability.GROWTH_LOW) == stable
    assert (learns.margin(lead) >= 1) == stable


@pytest.mark.parametrize(("size", "angle"), [(0.3, 0.0), (1.7, 0.4), (0.02, -1.2), (5.0, 1.3)])
def test_the_gain_margin_is_where_the_factor_of_a_harmonic_leaves_the_unit_circle(size, angle):
    """|1 - s a e^{jφ}| = 1 at s = 2 cos φ / a."""
    mu = np.array([[[size * np.exp(1j * angle)]]])
    loop = stability.LearningLoop(1000, np.array([500]), mu[..., None], mu)
    assert loop.margin(0) == pytest.approx(2 * math.cos(angle) / size, rel=1e-3)


def test_a_lead_turns_the_factor_of_a_harmonic_and_a_low_pass_takes_it_out():
    """A response one sample late has the wrong sign at half the sampling, and a lead cures it."""
    steps, harmonics = 1000, np.arange(501)
    late = 0.1 * np.exp(-2j * np.pi * harmonics / steps)[None, :, None]
    loop = stability.LearningLoop(steps, harmonics, late[..., None], late)
    np.testing.assert_allclose(loop.multiplier(0)[0, -1], 1.1)
    np.testing.assert_allclose(loop.multiplier(1), 0.9)
    np.testing.assert_allclose(loop.multiplier(2)[0, -1], 1.1)
    assert loop.margin(0) < 1
    assert loop.margin(1) > 19
    # 2 cos(ωΔt) > 0.1 up to a little less than a quarter of the sampling frequency.
    most = math.floor(steps * math.acos(0.05) / (2 * math.pi))
    assert abs(loop.most_harmonics(0) - most) <= 1
    assert loop.margin(0, most - 1) >= 1
    assert loop.margin(0, most + 1) < 1


# Against runs


def torque_ratio(run):
    """Torque² of each cycle as a multiple of that without springs."""
    without = float(run.data["torque_squared_without_springs"][0])
    return run.data["torque_squared"].values / without


def growth_at_half_the_sampling(run, cycles):
    """Growth per cycle of the learned torque at 500 Hz, over the last cycles."""
    u = run.data["u"].values.reshape(-1, 1000, 2)
    alternating = (u * (-1.0) ** np.arange(1000)[:, None]).mean(axis=1)
    size = np.linalg.norm(alternating, axis=1)[-cycles:]
    return np.exp(np.polyfit(np.arange(cycles), np.log(size), 1)[0]) - 1


@pytest.mark.parametrize(
    ("motion", "beta", "lead", "cycles"), [(0, 10.0, 0, 25), (1, 3.0, 0, 80), (1, 3.0, 2, 85)]
)
def test_learning_diverges_as_fast_and_as_soon_as_predicted(motion, beta, lead, cycles):
    experiment = alone(motion, cycles, {"law.beta": beta, "law.lead": lead})
    onset = prediction(experiment).onset
    run = rmj.simulate(experiment)
    assert run.status is rmj.Status.DIVERGED
    worse = int(np.flatnonzero(torque_ratio(run) <= 1)[-1]) + 2
    assert onset.fastest == 500
    assert onset.cycle == pytest.approx(worse, abs=max(1, 0.05 * worse))
    assert onset.growth == pytest.approx(growth_at_half_the_sampling(run, 5), rel=0.03)


def test_what_grows_grows_as_in_the_pose_at_the_beginning_of_the_cycle():
    """The same motion begun elsewhere grows at another rate: that of the pose there."""
    rates = []
    for shift in (0.0, 0.24):
        experiment = alone(1, 80, {"law.beta": 3.0}, shift)
        predicted = prediction(experiment).onset.growth
        measured = growth_at_half_the_sampling(rmj.simulate(experiment), 5)
        assert measured == pytest.approx(predicted, rel=0.03)
        rates.append(predicted)
    assert rates[1] > 1.2 * rates[0]


def test_a_motion_with_a_passage_diverges_later_as_predicted():
    experiment = alone(0, 45, {"law.beta": 10.0, "motion.0.blend": 1})
    onset = prediction(experiment).onset
    run = rmj.simulate(experiment)
    worse = int(np.flatnonzero(torque_ratio(run) <= 1)[-1]) + 2
    assert onset.cycle == pytest.approx(worse, abs=0.1 * worse)
    assert worse > 30, "without the passage 19"


def test_what_is_said_not_to_diverge_does_not():
    """Each of the lead, the harmonics and the β that are offered, and not much more of them."""
    printed = alone(0, 60, {"law.beta": 10.0})
    why = prediction(printed)
    led = printed.replace({"law.beta": 15.0, "law.lead": 1})
    limit = 15.0 * prediction(led).margin
    assert 12 < limit < 15
    cured = [
        printed.replace({"law.lead": why.lead}),
        printed.replace({"law.harmonics": why.harmonics}),
        led.replace({"law.beta": 0.97 * limit}),
    ]
    for experiment in cured:
        assert prediction(experiment) is None
    runs = rmj.simulate_many([*cured, led.replace({"law.beta": 1.1 * limit})])
    for run in runs[:-1]:
        assert run.status is rmj.Status.OK
        assert torque_ratio(run)[-20:].max() < 0.2
    assert runs[-1].status is rmj.Status.DIVERGED


# What is said


def said(changes, name="paper"):
    return plan_for(rmj.load(name).replace(changes)).unstable


def test_the_law_as_printed_is_said_to_diverge_after_the_cycles_of_its_run():
    first, second = said({})
    assert "learning diverges about cycle 250 of such a motion as motion.0, and this run " in first
    assert "ends at cycle 40: with law.beta = 1 and law.lead = 0 harmonics of 1/T from " in first
    assert "500 (500 Hz) fastest, by 2.7 % in a cycle; law.lead = 1 or law.harmonics" in first
    assert "motion.1" in second
    assert set(plan_for(rmj.load("paper")).notes) >= {first, second}


def test_where_no_lead_is_enough_a_lead_with_a_smaller_gain_is_said():
    (first, *_) = said({"law.beta": 15.0})
    offered = first.split("law.lead = 1 with law.beta = ")[1].split()[0]
    assert 5 < float(offered) < 15
    rest = said({"law.lead": 1, "law.beta": float(offered)})
    assert not [line for line in rest if "motion.0" in line]


def test_a_share_of_the_feedback_that_is_too_large_is_said_with_one_that_is_not():
    changes = {"law.eta": 4.0, "motion.0.duration": 4.0}
    (line,) = said(changes, "planar-three-link")
    assert "of 4: with law.eta = 4 and law.lead = 1 " in line
    offered = float(line.split("law.eta = ")[-1].split()[0])
    assert 1.0 < offered < 4.0
    assert not said(changes | {"law.eta": offered}, "planar-three-link")


def test_a_law_that_does_not_learn_or_has_a_file_of_its_own_is_not_said_to_diverge(tmp_path):
    assert not said({"law.beta": 0.0})
    law = tmp_path / "given.py"
    law.write_text(GIVEN)
    assert not said({"law.kind": str(law), "law.parameters": [0.0, 0.0, 1.0]})


def test_strict_refuses_what_will_diverge_before_the_first_step():
    paper = rmj.load("paper")
    stable = paper.replace({"law.lead": 1, "motion.0.duration": 2.0, "motion.1.duration": 2.0})
    begun = []
    for refused in (
        lambda: rmj.simulate(paper, strict=True, progress=lambda *cycles: begun.append(cycles)),
        lambda: rmj.simulate_many([stable, paper], strict=True),
        lambda: rmj.simulate(paper.replace({"law.k_v": 3000.0}), strict=True),
    ):
        with pytest.raises(
            StabilityError, match=r"experiment 'paper': .*motion\.0.* \(and 1 more\)"
        ):
            refused()
    assert not begun
    assert rmj.simulate(stable, strict=True).status is rmj.Status.OK


def test_run_strict_exits_with_2_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["run", "paper", "--strict"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("resonance-mj: experiment 'paper': learning diverges about cycle 250")
    assert not list(tmp_path.iterdir())
