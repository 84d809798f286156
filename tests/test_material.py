"""Springs that are not linear: as they are simulated, the best, and a law that finds out."""

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize

import resonance_mj as rmj
from resonance_mj.errors import ResonanceError
from resonance_mj.experiments.law_section import KINDS
from resonance_mj.pictures.figures import springs as springs_figure
from resonance_mj.plan.plan import plan_for
from resonance_mj.results.cycles import kept
from resonance_mj.springs.bounds import UNBOUNDED, JointBounds
from resonance_mj.springs.fit import fit
from resonance_mj.springs.material import TURNS, Material

STIFFENING = {"spring_stiffening": 2.0}
LOSSY = {"spring_hysteresis": 0.1}


def arm(name, reality, cycles=60, **changes):
    experiment = rmj.load(name)
    changes = {"law": {}, "springs": {}, "expect": {}, "reality": reality} | changes
    for index, motion in enumerate(experiment.motion):
        changes[f"motion.{index}.duration"] = cycles * motion.period
    return experiment.replace(changes)


def really(reality, k, x, v):
    """Torque of springs of stiffness k, x from their equilibrium, moving with v."""
    error, c, h, d = (
        reality.get(f"spring_{name}", 0.0)
        for name in ("error", "stiffening", "hysteresis", "damping")
    )
    loaded = k * (1 + np.array(error)) * (x + c * x**3)
    return -loaded - h * np.abs(loaded) * np.tanh(v / TURNS) - d * k * v


@pytest.mark.parametrize(
    ("integrator", "interpret"),
    [
        ("Euler", False),
        ("RK4", False),
        pytest.param("Euler", True, marks=pytest.mark.slow),
        pytest.param("RK4", True, marks=pytest.mark.slow),
    ],
)
def test_a_spring_swings_as_its_differential_equation_says(interpret, integrator):
    """M q̈ + ... = τ + τ_s: torques of inverse dynamics, of the accelerations that were made."""
    reality = {
        "spring_stiffening": 1.5,
        "spring_hysteresis": 0.2,
        "spring_damping": 0.01,
        "spring_error": [0.3, -0.2],
    }
    given = arm("two-link-transfer", reality, cycles=2)
    changes = {"simulation.integrator": integrator, "simulation.timestep": 2.5e-4}
    springs = {"springs.initial_stiffness": [20.0, 5.0], "law.kind": "learning"}
    run = rmj.simulate(given.replace(changes | springs), interpret=interpret)
    one = kept(run)[1]
    dt = run.experiment.simulation.timestep
    robot = run.plan.robot
    data, missing = mujoco.MjData(robot.model), []
    robot.model.jnt_stiffness[:] = 0.0
    robot.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    for i in range(50, len(one.q) - 1, 37):
        x = one.q[i] - one.center - one.offset[i] / one.stiffness[i]
        data.qpos[:], data.qvel[:] = one.q[i], one.dq[i]
        data.qacc[:] = (one.dq[i + 1] - one.dq[i - 1]) / (2 * dt)
        mujoco.mj_inverse(robot.model, data)
        exerted = one.tau[i] + really(reality, one.stiffness[i], x, one.dq[i])
        missing.append(data.qfrc_inverse - exerted)
    size = np.abs(really(reality, one.stiffness, one.q - one.center, one.dq)).max(axis=0)
    assert (np.median(np.abs(missing), axis=0) < 0.01 * size).all()


def test_a_spring_that_is_twice_as_stiff_as_it_is_set_to_be_is_one_of_twice_the_stiffness():
    """Two runs of a law that keeps its springs, to rounding."""
    keeps = {"law.kind": "learning", "springs.initial_equilibrium": [4.5, -1.0]}
    soft = arm("two-link-transfer", {"spring_error": 1.0}, 5, **keeps)
    stiff = arm("two-link-transfer", {}, 5, **keeps)
    runs = [
        rmj.simulate(one.replace({"springs.initial_stiffness": k}))
        for one, k in ((soft, [4.0, 3.0]), (stiff, [8.0, 6.0]))
    ]
    np.testing.assert_allclose(runs[0].data["q"], runs[1].data["q"], atol=1e-9)


@pytest.mark.parametrize("reality", [STIFFENING, LOSSY, {"spring_damping": 0.02}])
def test_the_best_springs_are_those_that_another_solver_finds(reality):
    rng = np.random.default_rng(3)
    t = np.arange(400) * 2 * np.pi / 400
    q = np.stack([0.6 * np.sin(t), 0.2 + 0.3 * np.cos(t) + 0.1 * np.sin(2 * t)], axis=1)
    dq = np.gradient(q, t, axis=0)
    torque = -np.array([30.0, 12.0]) * (q - [0.4, -0.3]) + 3 * np.sin(np.outer(t, [2, 3]))
    torque += rng.normal(0, 0.5, torque.shape)
    zero = np.zeros(2)
    given = dict.fromkeys(Material._fields, zero)
    given |= {key.removeprefix("spring_"): zero + value for key, value in reality.items()}
    bounds = JointBounds(
        (zero, np.full(2, 200.0)),
        (zero - 2, zero + 2),
        np.zeros(2, bool),
        material=Material(**given),
    )
    best = fit(q, torque, bounds, q.mean(axis=0), dq)
    left = torque - best.torque(q, dq)
    for j in range(2):

        def cost(p, j=j):
            spring = really(reality, p[0], q[:, j] - p[1], dq[:, j])
            return float(((torque[:, j] - spring) ** 2).mean())

        mean = q[:, j].mean()
        box = [(0.0, 200.0), (mean - 2, mean + 2)]
        tries = [minimize(cost, (k, mean + e), bounds=box) for k in (5, 40) for e in (-1, 0, 1)]
        assert (left[:, j] ** 2).mean() <= 1.0001 * min(one.fun for one in tries)


def test_springs_of_no_material_are_the_linear_ones_to_the_best_of_a_search():
    t = np.arange(200) * 2 * np.pi / 200
    q = np.stack([np.sin(t), np.cos(t) + 0.3 * np.sin(2 * t)], axis=1)
    torque = -np.array([30.0, 12.0]) * (q - [0.4, -0.3]) + np.sin(np.outer(t, [2, 3]))
    plain = fit(q, torque, UNBOUNDED, q.mean(axis=0))
    zero = np.zeros(2)
    hooke = UNBOUNDED._replace(material=Material(zero, zero, zero, zero))
    found = fit(q, torque, hooke, q.mean(axis=0), np.zeros_like(q))
    np.testing.assert_allclose(found.stiffness, plain.stiffness, rtol=1e-4)
    np.testing.assert_allclose(found.offset, plain.offset, rtol=1e-3)


ROWS = {
    "cubic": STIFFENING,
    "hysteresis": LOSSY,
    "damped": {"spring_damping": 0.01},
    "off by a third": {"spring_error": 0.33},
    "all of it": STIFFENING | LOSSY | {"spring_error": -0.2},
}


def judged(run, reality):
    """Torque² of the last cycle of each motion, and of the best springs, from what was recorded."""
    last = {cycle.motion: cycle for cycle in kept(run)}
    for index, motion in enumerate(run.motions):
        cycle = last[index]
        k = cycle.stiffness  # 0 where a joint needs no spring
        at = cycle.center + np.divide(cycle.offset, k, out=np.zeros_like(k), where=k != 0)
        total = cycle.tau + really(reality, cycle.stiffness, cycle.q - at, cycle.dq)
        needed = run.plan.needed(index)
        if run.plan.robot.m == run.plan.robot.n:
            # What the springs are said to exert is what the motion lacks of the motors.
            assert ((total - needed) ** 2).mean() < 0.03**2 * (needed**2).mean()
        best = 0.0
        for j in range(total.shape[1]):
            q, mean = cycle.q[:, j], cycle.q[:, j].mean()
            places = np.linspace(mean - np.pi, mean + np.pi, 2001)[:, None]
            unit = -really(_of_joint(reality, j), 1.0, q - places, cycle.dq[:, j])
            k = np.maximum(-(unit @ total[:, j]) / (unit**2).sum(axis=1), 0.0)
            left = ((total[:, j] + k[:, None] * unit) ** 2).mean(axis=1)
            best += left.min()
        yield motion, (cycle.tau**2).sum(axis=1).mean(), best


def _of_joint(reality, j):
    error = np.broadcast_to(reality.get("spring_error", 0.0), j + 1)[j]
    return reality | {"spring_error": float(error)}


@pytest.mark.parametrize(
    ("row", "name"),
    [
        ("cubic", "two-link-transfer"),
        *(pytest.param(row, "two-link-transfer", marks=pytest.mark.slow) for row in list(ROWS)[1:]),
        *(pytest.param(row, "seven-joint", marks=pytest.mark.slow) for row in ROWS),
    ],
)
def test_the_law_comes_within_three_percent_of_the_best_that_such_springs_can_do(row, name):
    reality = ROWS[row]
    run = rmj.simulate(arm(name, reality))
    assert run.status == "ok", run.message
    for motion, torque_squared, best in judged(run, reality):
        assert torque_squared <= 1.03 * best
        assert motion.torque_squared_optimal == pytest.approx(best, rel=0.01)
        assert motion.tracking_rms[-1] < 1e-4
    if "spring_stiffening" in reality:
        assert any("springs are not linear" in note for note in run.notes)


def test_a_law_that_is_given_the_best_springs_leaves_what_is_said_to_be_least():
    run = rmj.simulate(arm("two-link-transfer", STIFFENING, 30, **{"law.kind": "fixed"}))
    for motion in run.motions:
        assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=2e-3)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.slow
def test_every_law_runs_with_such_springs(kind):
    given = arm("two-link-transfer", STIFFENING | LOSSY, 2, **{"law.kind": kind})
    run = rmj.simulate(given)
    assert np.isfinite(run.data["tau"]).all()
    # A model that is right is told the springs as they are.
    if kind == "computed-torque":
        last = run.motions[1]
        assert last.torque_squared[-1] == pytest.approx(last.torque_squared_optimal, rel=0.05)


def test_linear_springs_are_believed_and_nothing_is_said():
    run = rmj.simulate(arm("seven-joint", {}, 10))
    assert not any("not linear" in note for note in run.notes)


@pytest.mark.slow
def test_such_runs_step_together_are_interrupted_and_go_on_with_the_same_bits(tmp_path):
    asked = arm("two-link-transfer", STIFFENING | LOSSY, 25)
    whole = rmj.simulate(asked)
    together = rmj.simulate_many([asked, arm("two-link-transfer", {}, 25)])[0]
    done = []
    part = rmj.simulate(asked, progress=lambda *one: done.append(one), stop=lambda: len(done) == 18)
    part.save(tmp_path / "run")
    resumed = rmj.simulate(asked, resume=rmj.Run.load(tmp_path / "run"))
    for other in (together, resumed):
        for name in ("q", "tau", "stiffness", "offset"):
            assert np.array_equal(other.data[name], whole.data[name])
    further = rmj.simulate(
        arm("two-link-transfer", STIFFENING | LOSSY, 10).replace({"motion": [asked.motion[1]]}),
        after=whole,
    )
    assert further.data["torque_squared"][0] == pytest.approx(
        float(whole.data["torque_squared"][-1]), rel=0.02
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"springs.cost": "peak"}, ["springs.cost", "reality.spring_*"]),
        ({"springs.weights": [1.0, 2.0]}, ["springs.weights"]),
        ({"reality.spring_error": [0.1]}, ["reality.spring_error", "2 are needed"]),
        ({"reality.spring_error": -1.0}, ["reality.spring_error", "greater than -1"]),
        ({"reality.spring_hysteresis": 1.0}, ["reality.spring_hysteresis"]),
        ({"reality.spring_stifening": 1.0}, ["'spring_stiffening'"]),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(changes, words):
    with pytest.raises(ResonanceError) as caught:
        rmj.simulate(arm("two-link-transfer", LOSSY, 2).replace(changes))
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


def test_what_is_of_linear_springs_alone_is_refused_of_others():
    run = rmj.simulate(arm("two-link-transfer", LOSSY, 3))
    with pytest.raises(ResonanceError, match="not linear"):
        rmj.certify(run)


def test_the_spring_that_is_drawn_as_the_best_is_the_best_such_spring():
    """Where the law has come to it, its own curve and that of the optimum are one."""
    run = rmj.simulate(arm("two-link-transfer", STIFFENING, 40))
    figure = springs_figure.draw(run, 7.0)
    panels = [ax for ax in figure.axes if ax.lines]
    assert len(panels) == 4
    for ax in panels:
        drawn = {line.get_label() or i: line for i, line in enumerate(ax.lines)}
        curves = [line.get_xydata() for line in drawn.values() if len(line.get_xdata()) > 100]
        _motor, own, needed, best = curves
        size = np.abs(needed[:, 1]).max()
        assert np.abs(own[: len(best), 1] - best[:, 1]).max() < 0.05 * size


def test_a_controller_of_a_real_arm_finds_springs_that_nobody_has_described():
    """MuJoCo's arm, stepped here, with cubic springs; the controller is told of none of it."""
    asked = arm("seven-joint", {}, 30, **{"law.doubts": True})
    controller, c = rmj.Controller(asked), 2.0
    robot = plan_for(asked).robot
    model, data, J = robot.model, mujoco.MjData(robot.model), np.zeros((3, robot.model.nv))
    data.userdata[:] = 0.0
    model.jnt_stiffness[:] = 0.0
    data.qpos[robot.qpos_address] = robot.home
    spent = []
    for _ in range(controller.cycles):
        k, offset, center = controller.springs
        rest = center + np.divide(offset, k, out=np.zeros_like(k), where=k != 0)
        tau, exerted, q = (np.empty((controller.steps, robot.n)) for _ in range(3))
        for i in range(controller.steps):
            mujoco.mj_step1(model, data)
            mujoco.mj_jacSite(model, data, J, None, robot.site)
            q[i] = data.qpos[robot.qpos_address]
            x = q[i] - rest
            exerted[i] = -k * (x + c * x**3)
            tau[i] = controller.step(
                q[i],
                data.qvel[robot.dof_address],
                data.site_xpos[robot.site][robot.coordinate],
                J[np.ix_(robot.coordinate, robot.dof_address)],
            )
            data.ctrl[robot.actuator_id] = tau[i]
            data.qfrc_applied[robot.dof_address] = exerted[i]
            mujoco.mj_step2(model, data)
        spent.append((tau**2).sum(axis=1).mean())
        controller.end_cycle()
    total, best = tau + exerted, 0.0
    for j in range(robot.n):
        places = np.linspace(q[:, j].mean() - np.pi, q[:, j].mean() + np.pi, 2001)[:, None]
        unit = (q[:, j] - places) + c * (q[:, j] - places) ** 3
        stiff = np.maximum(-(unit @ total[:, j]) / (unit**2).sum(axis=1), 0.0)
        best += ((total[:, j] + stiff[:, None] * unit) ** 2).mean(axis=1).min()
    assert spent[-1] <= 1.05 * best
    run = controller.run()
    assert run.motions[0].tracking_rms[-1] < 1e-4
    assert any("springs are not linear" in note for note in run.notes)
