"""The law inside MuJoCo's control callback: one source, two ways to run, and one global pointer."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, Thread

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.callback import callback
from resonance_mj.callback.callback import installed
from resonance_mj.errors import CallbackError, DivergedWarning
from resonance_mj.laws import adjusting
from resonance_mj.laws.memory import Memory
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots.robot import build
from resonance_mj.simulation.loading import load_law, load_motion

TWO_LINK = library.robots()["two_link.xml"]


def short(changes=(), cycles=2):
    """The paper's first motion for a few cycles."""
    paper = rmj.load("paper")
    motion = paper.motion[0].model_dump() | {"duration": float(cycles)}
    return paper.replace({"motion": [motion], **dict(changes)})


def assert_equal_to_the_last_bit(one, other):
    assert (one.status, one.message, one.steps) == (other.status, other.message, other.steps)
    assert set(one.data.variables) == set(other.data.variables)
    for name in one.data.variables:
        here, there = one.data[name].values, other.data[name].values
        np.testing.assert_array_equal(here, there, err_msg=name)
        if here.dtype.kind == "f":
            np.testing.assert_array_equal(np.signbit(here), np.signbit(there), err_msg=name)


# One source, two ways to run

LAWS = {
    "as printed": {},
    "Jacobian transpose": {"law.jacobian": "transpose"},
    "read ahead": {"law.lead": 3, "law.beta": 3.0, "law.q_c": "mean", "law.q_s": "mean"},
    "bounded springs": {
        "springs.stiffness": [0.0, 4.0],
        "springs.equilibrium": [-1.0, 1.0],
        "law.q_c": "mean",
        "springs.initial_stiffness": [3.0, 1.0],
        "springs.initial_equilibrium": [4.0, -2.0],
    },
    "diverging": {"law.k_v": 1e4},
}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # the interpreted law's own overflow
@pytest.mark.parametrize(
    ("integrator", "law"),
    [
        ("Euler", "as printed"),
        ("implicitfast", "as printed"),
        ("RK4", "as printed"),
        ("implicitfast", "Jacobian transpose"),
        ("RK4", "Jacobian transpose"),
        ("implicitfast", "read ahead"),
        ("Euler", "bounded springs"),
        ("implicitfast", "diverging"),
    ],
)
def test_compiled_and_interpreted_law_agree_to_the_last_bit(integrator, law, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # for MuJoCo's log of the diverging run
    experiment = short({"simulation.integrator": integrator, **LAWS[law]})
    compiled, interpreted = rmj.simulate(experiment), rmj.simulate(experiment, interpret=True)
    assert_equal_to_the_last_bit(compiled, interpreted)
    assert (compiled.status == rmj.Status.DIVERGED) == (law == "diverging")


# One pointer for the whole process


def pointer():
    return callback.pointer("control")


@pytest.mark.parametrize("interpret", [False, True])
def test_callback_is_in_place_within_the_block_and_gone_after_it(interpret):
    assert not pointer()
    with installed(interpret=interpret):
        assert pointer()
    assert not pointer()


@pytest.mark.parametrize("interpret", [False, True])
def test_callback_is_gone_after_an_exception_within_the_block(interpret):
    with pytest.raises(ZeroDivisionError), installed(interpret=interpret):
        raise ZeroDivisionError
    assert not pointer()
    with installed(interpret=interpret):
        assert pointer()


def test_callback_is_gone_after_a_simulation_that_was_interrupted():
    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        rmj.simulate(short(), progress=interrupt)
    assert not pointer()
    assert rmj.simulate(short(cycles=1)).status == rmj.Status.OK


def test_a_law_within_a_law_of_one_thread_is_refused_and_leaves_the_first_in_place():
    with installed():
        before = pointer()
        with (
            pytest.raises(CallbackError, match="another law is running"),
            installed(interpret=True),
        ):
            pass
        assert pointer() == before
        with installed():
            assert pointer() == before
        assert pointer() == before
    assert not pointer()


def test_a_simulation_within_a_simulation_does_not_disturb_it():
    experiment, within = short(), []

    def progress(done, total):
        within.append(rmj.simulate(experiment))
        # Not "remove it": that would take the law away from the simulation that is running.
        with pytest.raises(CallbackError, match="another law is running in this thread"):
            rmj.simulate(experiment, interpret=True)

    disturbed = rmj.simulate(experiment, progress=progress)
    alone = rmj.simulate(experiment)
    assert len(within) == 2
    for run in (disturbed, *within):
        assert_equal_to_the_last_bit(run, alone)


def test_threads_that_begin_at_once_have_the_same_callback():
    """Else one would wait until the runs of the other have ended."""
    rmj.simulate(short())
    both = Barrier(2)

    def begun(_):
        both.wait()
        return callback._compiled()

    for _ in range(20):
        callback._compiled.cache_clear()
        with ThreadPoolExecutor(2) as pool:
            one, other = pool.map(begun, range(2))
        assert one is other


def test_threads_simulate_side_by_side_and_end_as_one_by_one(tmp_path):
    """Eight at once, of compiled laws that share the callback and one that must wait for it."""
    law = tmp_path / "law.py"
    law.write_text(
        "def command(J, error, rate, q, dq, u, parameters, y, tau):\n"
        "    for j in range(len(tau)):\n"
        "        y[j] = dq[j]\n"
        "        tau[j] = u[j] - parameters[0] * y[j]\n"
    )
    mine = {"law": {}, "law.kind": str(law), "law.parameters": [2.0]}
    kinds = [
        (short(cycles=8), False),
        (short({"law": {}, "law.kind": "transfer"}, cycles=6), False),
        (short({"law": {}, "law.kind": "joint-space"}, cycles=6), False),
        (short(cycles=1), True),
        (short(mine, cycles=3), False),
    ]
    jobs = [kinds[index % len(kinds)] for index in range(16)]

    def simulated(job):
        experiment, interpret = job
        return rmj.simulate(experiment, interpret=interpret)

    alone = [simulated(kind) for kind in kinds]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(simulated, jobs, timeout=120))
    assert not pointer()
    for index, run in enumerate(together):
        assert_equal_to_the_last_bit(run, alone[index % len(kinds)])


def test_a_run_that_diverges_warns_whoever_called(tmp_path, monkeypatch):
    with pytest.warns(DivergedWarning, match=r"paper: motion 1 diverged .* try smaller") as said:
        run = rmj.simulate(short(LAWS["diverging"]))
    assert run.status is rmj.Status.DIVERGED
    assert said[0].filename == __file__


def test_a_thread_whose_law_is_another_waits_until_the_first_has_ended():
    order = []

    def other():
        with installed(interpret=True):
            order.append("other")

    with installed():
        thread = Thread(target=other)
        thread.start()
        thread.join(0.3)
        order.append("first")
    thread.join(30)
    assert order == ["first", "other"]
    assert not pointer()


@pytest.fixture
def foreign():
    """Another program's control callback, installed."""
    calls = []

    def control(model, data):
        calls.append(data.time)

    mujoco.set_mjcb_control(control)
    yield control
    mujoco.set_mjcb_control(None)


def test_foreign_callback_is_refused_and_left_in_place(foreign):
    with pytest.raises(CallbackError, match="mjcb_control, is installed"), installed():
        pass
    assert mujoco.get_mjcb_control() is foreign


@pytest.mark.parametrize("run", [rmj.simulate, lambda experiment: rmj.simulate_many([experiment])])
def test_simulation_under_a_foreign_callback_says_so(foreign, run):
    """MuJoCo calls it while it compiles a model: the refusal must come before that."""
    with pytest.raises(CallbackError, match="mjcb_control, is installed"):
        run(short())
    assert mujoco.get_mjcb_control() is foreign


@pytest.mark.parametrize(
    "name",
    [
        "control",
        "passive",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("act_gain", "contactfilter")),
    ],
)
def test_a_users_callback_is_named_before_anything_is_compiled(name):
    """In a process of its own, in which nothing has been simulated yet."""
    code = f"""import mujoco, resonance_mj as rmj
def mine(*_):
    raise RuntimeError("not yours to call")
mujoco.set_mjcb_{name}(mine)
for run in (rmj.simulate, rmj.optimum):
    try:
        run(rmj.load("paper"))
    except rmj.ResonanceError as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) == 2
    assert all(f"mjcb_{name}, is installed" in line for line in lines)
    assert done.stderr == ""


def test_other_models_are_left_alone_while_the_law_is_installed():
    """The pointer is global: a model in another thread, without a controller's block, meets it too.

    So does every model that is compiled meanwhile.
    """
    spec = mujoco.MjSpec.from_file(str(TWO_LINK))
    spec.nuserdata = 60  # with fewer, a law that takes them for its own would write beyond them
    model = spec.compile()
    alone, met = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_step(model, alone, 10)
    stiffness = model.jnt_stiffness.copy()
    with installed():
        mujoco.mj_step(model, met, 10)
    np.testing.assert_array_equal(met.userdata, 0)
    np.testing.assert_array_equal(met.qpos, alone.qpos)
    np.testing.assert_array_equal(met.ctrl, 0)
    np.testing.assert_array_equal(model.jnt_stiffness, stiffness)


# What happens in a time step


@pytest.fixture
def spied(monkeypatch):
    """What MuJoCo shows the interpreted law at each callback, before and after the law acts."""
    seen = []
    law = callback._interpreted

    def spy(command, model, data):
        before = {
            "stiffness": model.jnt_stiffness.copy(),
            "equilibrium": model.qpos_spring.copy(),
            "spring": data.qfrc_passive + model.dof_damping * data.qvel,
            "q": data.qpos.copy(),
            "time": data.time,
        }
        law(command, model, data)
        seen.append(before | {"ctrl": data.ctrl.copy()})

    monkeypatch.setattr(callback, "_interpreted", spy)
    return seen


def column(seen, name):
    return np.array([one[name] for one in seen])


@pytest.mark.parametrize(("integrator", "stages"), [("Euler", 1), ("implicitfast", 1), ("RK4", 4)])
def test_law_acts_once_per_time_step_and_every_stage_has_the_same_springs_and_motor_torque(
    spied, integrator, stages
):
    run = rmj.simulate(short({"simulation.integrator": integrator}, cycles=1), interpret=True)
    steps = len(run.data["time"])
    assert len(spied) == stages * steps
    for name, recorded in (
        ("stiffness", "stiffness"),
        ("equilibrium", "equilibrium"),
        ("ctrl", "tau"),
    ):
        per_stage = column(spied, name).reshape(steps, stages, 2)
        for stage in range(stages):
            np.testing.assert_array_equal(per_stage[:, stage], run.data[recorded])
    # The stages are RK4's: the law held its torque and springs while the time and the arm moved.
    if stages == 4:
        times = column(spied, "time").reshape(steps, 4)
        dt = run.experiment.simulation.timestep
        np.testing.assert_allclose(
            times - times[:, :1], [[0, dt / 2, dt / 2, dt]] * steps, atol=1e-12
        )


def test_recorded_springs_are_those_whose_torque_mujoco_applies(spied):
    """The model's passive torque, its damping taken out, is -k (q - q_e) at every recorded time."""
    run = rmj.simulate(short(), interpret=True)
    k, q, q_e = (run.data[name].values for name in ("stiffness", "q", "equilibrium"))
    np.testing.assert_array_equal(column(spied, "q"), q)
    spring = column(spied, "spring")
    scale = np.abs(k) * (np.abs(q) + np.abs(q_e)) + 10
    assert (np.abs(spring + k * (q - q_e)) <= 1e-14 * scale).all()
    offset, center = run.data["offset"].values, run.data["center"].values
    assert (np.abs(spring - (offset - k * (q - center))) <= 1e-14 * scale).all()


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_springs_adapt_by_explicit_euler_steps_of_6_and_7(integrator):
    """To the last bit, and on over the boundary of two cycles and of two motions."""
    paper = rmj.load("paper")
    run = rmj.simulate(
        paper.replace(
            {
                "motion.0.duration": 2.0,
                "motion.1.duration": 1.0,
                "simulation.integrator": integrator,
            }
        )
    )
    k, offset, q, y = (run.data[name].values for name in ("stiffness", "offset", "q", "y"))
    law, dt = run.experiment.law, run.experiment.simulation.timestep
    q_c = np.array(law.q_c)
    np.testing.assert_array_equal(k[0], 0.0)
    np.testing.assert_array_equal(k[1:], (k + dt * (np.array(law.gamma_k) * (q - q_c) * y))[:-1])
    np.testing.assert_array_equal(offset[1:], (offset + dt * (-np.array(law.gamma_qe) * y))[:-1])
    ends = run.data["stiffness_per_cycle"].values
    np.testing.assert_array_equal(ends[:-1], k[1000::1000])


def test_bounded_springs_never_leave_their_bounds():
    run = rmj.simulate(short(LAWS["bounded springs"], cycles=5))
    k, offset = run.data["stiffness"].values, run.data["offset"].values
    assert ((k >= 0) & (k <= 4)).all()
    assert (np.abs(offset) <= k * 1.0).all()
    away = run.data["equilibrium"].values - run.data["center"].values
    assert (np.abs(away) <= 1 + 1e-12).all()
    assert (np.abs(offset) == k).any()  # the bounds were met


def test_springs_at_their_bounds_take_the_step_of_6_and_7_and_then_the_nearest_feasible_spring():
    """Nearest in the metric Δk²/γ_k + Δq̄_e²/γ_qe of (16): no feasible spring gets farther away."""
    run = rmj.simulate(short(LAWS["bounded springs"], cycles=5))
    k, offset, q, y, q_c = (
        run.data[name].values for name in ("stiffness", "offset", "q", "y", "center")
    )
    dt = run.experiment.simulation.timestep
    gamma_k, gamma_qe = np.array(run.experiment.law.gamma_k), np.array(run.experiment.law.gamma_qe)
    step_k = (k + dt * gamma_k * (q - q_c) * y)[:-1]
    step_offset = (offset - dt * gamma_qe * y)[:-1]

    def distance(to_k, to_offset, from_k, from_offset):
        return (to_k - from_k) ** 2 / gamma_k + (to_offset - from_offset) ** 2 / gamma_qe

    cut = distance(k[1:], offset[1:], step_k, step_offset)
    assert (cut > 1e-12).mean() > 0.1  # the bounds cut many steps short, and not all
    assert (cut < 1e-20).mean() > 0.1
    # The feasible set is the triangle 0 <= k <= 4, |q̄_e| <= k: its corners bound all of it.
    for corner in ((0.0, 0.0), (4.0, -4.0), (4.0, 4.0)):
        before = distance(*corner, step_k, step_offset)
        assert (distance(*corner, k[1:], offset[1:]) + cut <= before + 1e-12).all()


# A model with more in it than the arm


def test_numbers_that_a_model_s_author_keeps_in_userdata_are_untouched(tmp_path):
    mjcf = tmp_path / "noted.xml"
    text = TWO_LINK.read_text(encoding="utf-8")
    mjcf.write_text(text.replace("<worldbody>", '<size nuserdata="5"/><worldbody>', 1))
    experiment = short({"robot.mjcf": str(mjcf)})
    one = plan_for(experiment)
    model = one.robot.model
    assert model.nuserdata == 5 + one.layout.size

    data = mujoco.MjData(model)
    data.userdata[:5] = notes = [3.0, 1.0, 4.0, 1.0, 5.0]
    data.qpos[:] = one.robot.qpos
    memory = Memory(data.userdata[None], one.layout)
    load_law(memory, 0, one)
    load_motion(memory, 0, one, 0)
    springs = model.jnt_stiffness, model.qpos_spring, model.dof_damping
    adjusting.write_springs(memory.block(0), *springs)
    with installed():
        mujoco.mj_step(model, data, 1000)
    np.testing.assert_array_equal(data.userdata[:5], notes)
    plain = rmj.simulate(short())
    np.testing.assert_array_equal(memory.recorded("tau", 1000)[0], plain.data["tau"][:1000])
    assert_equal_to_the_last_bit(rmj.simulate(experiment), plain)


def test_law_finds_its_arm_among_other_bodies(tmp_path):
    """A free body stands before the arm, and the motors stand in reverse order."""
    mjcf = tmp_path / "crowded.xml"
    text = TWO_LINK.read_text(encoding="utf-8")
    text = text.replace(
        '<body name="link1">',
        '<body name="stone" pos="0 5 0"><freejoint/><inertial pos="0 0 0" mass="1" '
        'diaginertia="1 1 1"/><site name="mark"/></body><body name="link1">',
        1,
    )
    first, second = (f'<motor name="motor{i}" joint="joint{i}" gear="1"/>' for i in (1, 2))
    text = text.replace(first, "HERE").replace(second, first).replace("HERE", second)
    text = text[: text.index("<keyframe>")] + text[text.index("</keyframe>") + len("</keyframe>") :]
    mjcf.write_text(text)
    experiment = short({"robot.mjcf": str(mjcf)})
    robot = build(experiment)
    assert robot.joints == ("joint1", "joint2")
    assert robot.model.nv == 2, "the stone is held"
    crowded, plain = rmj.simulate(experiment), rmj.simulate(short())
    for name in ("q", "dq", "x", "y", "tau", "u", "stiffness", "offset"):
        np.testing.assert_allclose(
            crowded.data[name], plain.data[name], rtol=1e-9, atol=1e-9, err_msg=name
        )
