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


@pytest.mark.parametrize("name", [run for run in RUNS if not run.startswith("paper")])
def test_a_run_reaches_the_optimum_within_ten_cycles_and_stays(name):
    (segment,) = rmj.simulate(rmj.load(name)).summary()["segments"]
    assert segment["cycles_to_optimum"] <= 10
    assert segment["torque_squared"] < 1.02 * segment["torque_squared_optimal"]
    assert segment["tracking_rms"] < 1.5e-3
    assert min(segment["stiffness"]) >= 0
