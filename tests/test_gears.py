"""Motors behind gears that give way and have play: as they swing, and under the law."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.errors import ResonanceError
from resonance_mj.experiments.loading import for_robot
from resonance_mj.plan.plan import plan_for
from resonance_mj.results.cycles import kept

PENDULUM = """<mujoco><option timestep="1e-4" gravity="0 0 {gravity}"/><worldbody><body>
<joint name="hinge" axis="0 1 0" armature="{armature}"/>
<geom type="sphere" pos="0 0 -0.5" size="0.03" mass="1.2" contype="0" conaffinity="0"/>
<site name="tool" pos="0 0 -0.5"/></body></worldbody>
<keyframe><key name="home" qpos="0.4"/></keyframe></mujoco>"""
STIFF = {"joint_stiffness": 10000.0, "rotor_inertia": 0.1}
SEVEN = {
    "joint_stiffness": [20000.0, 20000.0, 10000.0, 10000.0, 2000.0, 2000.0, 200.0],
    "rotor_inertia": [0.5, 0.5, 0.2, 0.2, 0.05, 0.05, 0.05],
}


def pendulum(tmp_path, reality, gravity=0.0, armature=0.0):
    (tmp_path / "arm.xml").write_text(PENDULUM.format(gravity=gravity, armature=armature))
    changes = {"reality": reality, "simulation.timestep": 1e-4, "simulation.gravity": None}
    return for_robot(str(tmp_path / "arm.xml")).replace(changes)


def arm(name, reality, cycles=40):
    experiment = rmj.load(name)
    changes = {"law": {}, "springs": {}, "expect": {}, "reality": reality}
    for index, motion in enumerate(experiment.motion):
        changes[f"motion.{index}.duration"] = cycles * motion.period
    return experiment.replace(changes)


def test_a_rotor_swings_against_its_joint_at_the_rate_of_two_inertias_and_a_spring(tmp_path):
    turned, stiffness = 0.05, 300.0
    reality = {"joint_stiffness": stiffness, "rotor_inertia": turned}
    plan = plan_for(pendulum(tmp_path, reality))
    model, data = plan.robot.model, mujoco.MjData(plan.robot.model)
    still = plan_for(pendulum(tmp_path, {})).robot.inertia[0, 0]
    rate = np.sqrt(stiffness * (1 / still + 1 / turned))
    data.qpos[1] = 0.01
    swings = []
    for _ in range(20_000):
        mujoco.mj_step(model, data)
        swings.append(data.qpos[1] - data.qpos[0])
    crossings = np.flatnonzero(np.diff(np.sign(swings)))
    period = 2 * np.diff(crossings).mean() * model.opt.timestep
    assert 2 * np.pi / period == pytest.approx(rate, rel=1e-3)


@pytest.mark.parametrize("play", [0.0, 0.02])
def test_a_load_rests_on_one_side_of_the_play_and_on_the_spring(tmp_path, play):
    reality = {"joint_stiffness": 300.0, "rotor_inertia": 0.5, "backlash": play}
    model = plan_for(pendulum(tmp_path, reality, gravity=-9.81)).robot.model
    data = mujoco.MjData(model)
    model.dof_damping[:] = 2.0
    data.qpos[:] = 0.4
    for _ in range(100_000):
        weight = 1.2 * 9.81 * 0.5 * np.sin(data.qpos[0])
        data.ctrl[0] = weight - 50 * (data.qpos[1] - 0.4) - 20 * data.qvel[1]
        mujoco.mj_step(model, data)
    weight = 1.2 * 9.81 * 0.5 * np.sin(data.qpos[0])
    assert np.abs(data.qvel).max() < 1e-4
    assert data.qpos[1] - data.qpos[0] == pytest.approx(play / 2 + weight / 300.0, rel=1e-3)


def test_a_motion_needs_what_it_needs_with_the_rotor_on_the_joint_itself(tmp_path):
    """So do the gains; the inertia of the file's armature is the rotor's if none is given."""
    rigid = plan_for(pendulum(tmp_path, {}, gravity=-9.81, armature=0.2))
    given = [
        plan_for(pendulum(tmp_path, reality, gravity=-9.81, armature=armature))
        for reality, armature in (
            ({"joint_stiffness": 5000.0, "rotor_inertia": 0.2}, 0.0),
            ({"joint_stiffness": 5000.0}, 0.2),
        )
    ]
    for plan in given:
        np.testing.assert_allclose(plan.robot.inertia, rigid.robot.inertia, rtol=1e-6)
        np.testing.assert_allclose(plan.needed(0), rigid.needed(0), rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    ("name", "reality", "error"),
    [
        ("two-link-transfer", STIFF, 2e-4),
        ("seven-joint", SEVEN | {"backlash": 0.0005}, 1e-3),
        pytest.param(
            "two-link-transfer", STIFF | {"backlash": 0.001}, 5e-4, marks=pytest.mark.slow
        ),
        pytest.param("two-link-transfer", STIFF | {"preset": "lab"}, 3e-3, marks=pytest.mark.slow),
    ],
)
def test_the_law_finds_the_springs_by_the_encoders_of_the_rotors(name, reality, error):
    run = rmj.simulate(arm(name, reality))
    assert run.status == "ok", run.message
    last = {cycle.motion: cycle for cycle in kept(run)}
    for index, motion in enumerate(run.motions):
        spent = (last[index].tau ** 2).sum(axis=1).mean()
        assert motion.torque_squared[-1] == pytest.approx(spent)
        assert spent <= 1.05 * motion.torque_squared_optimal
        off = last[index].x - last[index].x_desired
        assert np.sqrt((off**2).sum(axis=1).mean()) == pytest.approx(motion.tracking_rms[-1])
        assert motion.tracking_rms[-1] < error


@pytest.mark.slow
def test_such_arms_step_together_and_go_on_with_the_same_bits(tmp_path):
    asked = arm("two-link-transfer", STIFF | {"backlash": 0.001}, 6)
    whole = rmj.simulate(asked)
    together = rmj.simulate_many([asked, arm("two-link-transfer", {}, 6)])[0]
    softer = rmj.simulate_many(
        [arm("two-link-transfer", STIFF | {"joint_stiffness": 5e3}, 6), asked]
    )
    done = []
    part = rmj.simulate(asked, progress=lambda *one: done.append(one), stop=lambda: len(done) == 4)
    part.save(tmp_path / "run")
    resumed = rmj.simulate(asked, resume=rmj.Run.load(tmp_path / "run"))
    for other in (together, softer[1], resumed):
        for name in ("q", "tau", "stiffness"):
            assert np.array_equal(other.data[name], whole.data[name])


def test_compiled_and_interpreted_law_agree_to_the_last_bit():
    short = arm("two-link-transfer", STIFF | {"backlash": 0.001}, 1)
    compiled, interpreted = (rmj.simulate(short, interpret=one).data for one in (False, True))
    for name in ("q", "tau", "y"):
        assert np.array_equal(compiled[name], interpreted[name])


@pytest.mark.parametrize(
    ("reality", "words"),
    [
        ({"backlash": 0.01}, ["backlash = 0.01", "joint_stiffness"]),
        ({"rotor_inertia": 0.01}, ["rotor_inertia", "joint_stiffness"]),
        ({"joint_stiffness": 1e4}, ["rotor_inertia", "joint1", "armature"]),
        ({"joint_stiffness": 0.0}, ["joint_stiffness", "greater than 0"]),
        ({"joint_stiffness": 1e7, "rotor_inertia": 0.1}, ["joint1", "at most", "time step"]),
        ({"joint_stiffness": [1e4], "rotor_inertia": 0.1}, ["joint_stiffness", "2 are needed"]),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(reality, words):
    with pytest.raises(ResonanceError) as caught:
        rmj.simulate(arm("two-link-transfer", reality, 2))
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


@pytest.mark.opengl
@pytest.mark.slow
def test_a_run_of_such_an_arm_is_saved_read_drawn_and_filmed(tmp_path):
    rmj.simulate(arm("two-link-transfer", STIFF, 2)).save(tmp_path / "run")
    run = rmj.Run.load(tmp_path / "run")
    rmj.plot(run, tmp_path, figures=["overview"])
    small = rmj.RenderOptions(size=(320, 240))
    film = rmj.render(run, tmp_path / "film.gif", stop=0.3, options=small)
    assert film.stat().st_size > 1000
