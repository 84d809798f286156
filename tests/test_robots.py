"""Cheap checks over every robot and every run that come with the package."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiment import for_robot
from resonance_mj.robot import build

ROBOTS = library.robots()
RUNS = library.experiments()


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_has_what_a_picture_and_a_run_need(name):
    model = mujoco.MjModel.from_xml_path(str(ROBOTS[name]))
    assert model.ncam >= 1
    assert model.nlight >= 1
    assert (model.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE)).any()
    assert model.site("tool").id >= 0
    assert model.key("home").id >= 0
    assert model.nmesh == 0


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_at_home_is_well_conditioned_and_touches_nothing(name):
    robot = build(for_robot(name))
    assert np.linalg.eigvalsh(robot.inertia).min() > 0
    assert robot.usual > 0
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.qpos
    mujoco.mj_forward(robot.model, data)
    assert data.ncon == 0


@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "two_link.xml"])
def test_each_link_has_the_inertia_of_the_solid_primitives_that_are_drawn(name):
    given = mujoco.MjModel.from_xml_path(str(ROBOTS[name]))
    spec = mujoco.MjSpec.from_file(str(ROBOTS[name]))
    for body in spec.bodies[1:]:
        body.explicitinertial = False
        for geom in body.geoms:
            geom.mass, geom.density = np.nan, 1.0
    solid = spec.compile()
    for i in range(1, given.nbody):
        inertia = []
        for model in (given, solid):
            axes = np.empty(9)
            mujoco.mju_quat2Mat(axes, model.body_iquat[i])
            axes = axes.reshape(3, 3)
            per_mass = axes @ np.diag(model.body_inertia[i]) @ axes.T / model.body_mass[i]
            inertia.append(per_mass)
        np.testing.assert_allclose(given.body_ipos[i], solid.body_ipos[i], atol=1e-5)
        scale = np.trace(inertia[1])
        np.testing.assert_allclose(inertia[0] / scale, inertia[1] / scale, atol=1e-4)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_home_is_the_same_each_time_and_within_the_joints_ranges(name):
    robot, again = build(for_robot(name)), build(for_robot(name))
    np.testing.assert_array_equal(robot.home, again.home)
    limited = robot.model.jnt_limited[robot.joint_id].astype(bool)
    low, high = robot.model.jnt_range[robot.joint_id].T
    assert ((low < robot.home) & (robot.home < high) | ~limited).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_has_a_run_and_a_line_in_the_readme(name):
    assert any(rmj.load(run).robot.mjcf == name for run in RUNS)
    assert name in (library.folder("mjcf") / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", RUNS)
def test_two_cycles_of_every_run_are_finite_and_the_same_twice(name):
    experiment = rmj.load(name)
    short = [motion.model_dump() | {"duration": 2 * motion.period} for motion in experiment.motion]
    experiment = experiment.replace({"motion": short})
    first, second = rmj.simulate(experiment), rmj.simulate(experiment)
    assert first.status is rmj.Status.OK
    for signal in ("q", "tau", "stiffness", "offset"):
        assert np.isfinite(first.data[signal]).all()
        np.testing.assert_array_equal(first.data[signal], second.data[signal])


@pytest.mark.parametrize(
    "name", [run for run in RUNS if not run.startswith(("paper", "two-link-transfer"))]
)
def test_a_run_is_predicted_to_be_stable_reaches_the_optimum_within_ten_cycles_and_stays(name):
    run = rmj.simulate(rmj.load(name), strict=True)
    for segment in run.summary()["segments"]:
        assert segment["cycles_to_optimum"] <= 10
        assert segment["torque_squared"] < 1.02 * segment["torque_squared_optimal"]
        assert segment["tracking_rms"] < 1.5e-3
        assert min(segment["stiffness"]) >= 0
    robot = build(run.experiment)
    data = mujoco.MjData(robot.model)
    for q in run.data.q.values[::50]:
        data.qpos[robot.qpos_address] = q
        mujoco.mj_fwdPosition(robot.model, data)
        assert data.ncon == data.nefc == 0
