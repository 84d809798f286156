"""Cheap checks over every robot and every run that come with the package."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.loading import for_robot
from resonance_mj.robots.robot import build

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
    for kind, count in (("body", model.nbody), ("joint", model.njnt), ("actuator", model.nu)):
        for index in range(count):
            element = getattr(model, kind)(index)
            assert element.name, f"{kind} {index} has no name"


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


def two_cycles(name):
    experiment = rmj.load(name)
    short = [motion.model_dump() | {"duration": 2 * motion.period} for motion in experiment.motion]
    return experiment.replace({"motion": short})


@pytest.fixture(scope="module")
def together():
    return dict(zip(RUNS, rmj.simulate_many(list(map(two_cycles, RUNS)), threads=2), strict=True))


@pytest.mark.parametrize("name", RUNS)
def test_two_cycles_of_every_run_are_finite_and_the_same_bits_alone_and_in_a_batch(name, together):
    """Of all robots and laws at once, on two threads."""
    alone = rmj.simulate(two_cycles(name))
    assert alone.status is together[name].status is not rmj.Status.DIVERGED
    assert alone.message == together[name].message
    for signal, values in alone.data.items():
        if values.dtype.kind == "f" and "equilibrium" not in signal and signal != "stiffness_most":
            assert np.isfinite(values).all(), signal
        assert values.values.tobytes() == together[name].data[signal].values.tobytes(), signal


@pytest.mark.parametrize(
    "name", [run for run in RUNS if not run.startswith(("paper", "two-link-transfer"))]
)
def test_an_arm_touches_nothing_on_its_way_and_its_springs_are_springs(name):
    """Whether it reaches the optimum is what the run itself expects: runs/ is collected too."""
    run = rmj.simulate(rmj.load(name).replace({"motion.0.duration": 4.0}), strict=True)
    assert (run.data.stiffness.values >= 0).all()
    robot = build(run.experiment)
    data = mujoco.MjData(robot.model)
    for q in run.data.q.values[::50]:
        data.qpos[robot.qpos_address] = q
        mujoco.mj_fwdPosition(robot.model, data)
        assert data.ncon == data.nefc == 0


def test_every_run_says_what_it_must_show():
    """Springs, torque and status of each motion, as numbers or as the optimum."""
    for name in RUNS:
        expect = rmj.load(name).expect
        assert (expect.status is rmj.Status.OK) == (name != "paper-transpose")
        for motion in expect.motion or [expect]:
            figures = expect.figures() | motion.figures()
            assert {"stiffness", "torque_reduction", "tracking_rms"} <= set(figures), name
