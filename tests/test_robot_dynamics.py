"""The arm in MuJoCo is the arm of Sec. VI-A: closed forms, finite differences, conservation."""

import mujoco
import numpy as np
import pytest
import two_link

import resonance_mj as rmj
from resonance_mj.motions.kinematics import Kinematics
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots.options import INTEGRATORS
from resonance_mj.robots.robot import build

MOTIONS = (two_link.first_motion, two_link.second_motion)


@pytest.fixture(scope="module")
def experiment():
    return rmj.load("paper")


@pytest.fixture(scope="module")
def robot(experiment):
    return build(experiment)


@pytest.fixture(scope="module")
def joint_motions(experiment):
    return plan_for(experiment).joints


def states(count, seed=1):
    """Random angles, velocities and accelerations (count, 2), far beyond those of the motions."""
    rng = np.random.default_rng(seed)
    return (
        rng.uniform(-np.pi, np.pi, (count, 2)),
        rng.uniform(-20, 20, (count, 2)),
        rng.uniform(-500, 500, (count, 2)),
    )


def test_inverse_dynamics_is_the_closed_form_of_the_paper_s_arm(robot):
    data = mujoco.MjData(robot.model)
    for q, dq, ddq in zip(*states(100), strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
        mujoco.mj_inverse(robot.model, data)
        closed_form = two_link.inverse_dynamics(q, dq, ddq)
        np.testing.assert_allclose(data.qfrc_inverse, closed_form, rtol=1e-11, atol=1e-11)


def test_closed_form_loses_energy_to_viscosity_alone():
    """dE/dt = -q̇ᵀ D q̇ without torque: it ties R, the Coriolis torque, g and D to each other."""
    q, dq, _ = states(100)
    ddq = two_link.forward_dynamics(q, dq, np.zeros_like(q))
    h = 1e-6

    def energy(at):
        q_at, dq_at = q + at * dq + at**2 / 2 * ddq, dq + at * ddq
        return two_link.kinetic(q_at, dq_at) + two_link.potential(q_at)

    power = (energy(h) - energy(-h)) / (2 * h)
    np.testing.assert_allclose(power, -(dq**2 @ two_link.D), rtol=1e-6, atol=1e-5)


def test_acceleration_under_torque_is_the_closed_form(robot):
    """The motors' controls arrive at the joints as torques, one to one."""
    data = mujoco.MjData(robot.model)
    q, dq, _ = states(50, seed=2)
    tau = np.random.default_rng(3).uniform(-50, 50, q.shape)
    for i in range(len(q)):
        data.qpos[:], data.qvel[:], data.ctrl[robot.actuator_id] = q[i], dq[i], tau[i]
        mujoco.mj_forward(robot.model, data)
        closed_form = two_link.forward_dynamics(q[i], dq[i], tau[i])
        np.testing.assert_allclose(data.qacc, closed_form, rtol=1e-10, atol=1e-9)


def test_joint_springs_exert_minus_k_times_q_minus_q_e_also_where_k_is_negative(robot):
    model = build(rmj.load("paper")).model
    data = mujoco.MjData(model)
    rng = np.random.default_rng(4)
    for q, dq, _ in zip(*states(50, seed=5), strict=True):
        k, q_e = rng.uniform(-30, 30, 2), rng.uniform(-5, 5, 2)
        model.jnt_stiffness[robot.joint_id] = k
        model.qpos_spring[robot.qpos_address] = q_e
        data.qpos[:], data.qvel[:] = q, dq
        mujoco.mj_forward(model, data)
        spring = data.qfrc_passive + two_link.D * dq
        np.testing.assert_allclose(spring, -k * (q - q_e), rtol=1e-12, atol=1e-12)


def test_tool_position_and_jacobian_are_those_of_sec_6a(robot):
    kinematics = Kinematics(robot)
    for q in states(50)[0]:
        np.testing.assert_allclose(kinematics.position(q), two_link.position(q), atol=1e-15)
        np.testing.assert_allclose(kinematics.jacobian(q), two_link.jacobian(q), atol=1e-15)


def test_jacobian_is_the_derivative_of_the_tool_position(robot):
    kinematics, h = Kinematics(robot), 1e-5
    for q in states(20, seed=6)[0]:
        columns = [
            (kinematics.position(q + step) - kinematics.position(q - step)) / (2 * h)
            for step in h * np.eye(2)
        ]
        np.testing.assert_allclose(kinematics.jacobian(q), np.stack(columns, axis=1), atol=1e-10)


@pytest.mark.parametrize("number", [0, 1])
def test_joint_motion_is_the_closed_form_inverse_kinematics_on_the_branch_of_home(
    joint_motions, number
):
    found = joint_motions[number]
    t = np.arange(len(found.q)) / len(found.q)
    q, dq, ddq = two_link.joint_motion(*MOTIONS[number](t))
    assert (found.q[:, 1] < 0).all()
    np.testing.assert_allclose(found.q, q, atol=1e-9)
    np.testing.assert_allclose(found.dq, dq, atol=1e-8)
    np.testing.assert_allclose(found.ddq, ddq, atol=1e-7)


@pytest.mark.parametrize("number", [0, 1])
def test_velocity_and_acceleration_are_the_derivatives_of_the_joint_angles(joint_motions, number):
    """Fourth-order differences of the periodic samples, whose error is h⁴/30 times a derivative."""
    q, dq, ddq = joint_motions[number]
    h = 1.0 / len(q)

    def derivative(v):
        near = np.roll(v, -1, axis=0) - np.roll(v, 1, axis=0)
        far = np.roll(v, -2, axis=0) - np.roll(v, 2, axis=0)
        return (8 * near - far) / (12 * h)

    np.testing.assert_allclose(dq, derivative(q), atol=1e-6)
    np.testing.assert_allclose(ddq, derivative(dq), atol=1e-5)


@pytest.mark.parametrize("number", [0, 1])
def test_torque_of_a_joint_motion_is_the_closed_form_whatever_springs_the_model_has(
    experiment, joint_motions, number
):
    robot = build(experiment)
    robot.model.jnt_stiffness[:] = 7.0
    torque = Kinematics(robot).torque(joint_motions[number])
    closed_form = two_link.inverse_dynamics(*joint_motions[number])
    np.testing.assert_allclose(torque, closed_form, rtol=1e-10, atol=1e-10)


FLYWHEEL = """<mujoco><option gravity="0 0 0" timestep="0.001"/><worldbody><body>
<joint name="hinge" axis="0 1 0"/><inertial pos="0 0 0" mass="1" diaginertia="0.02 0.02 0.02"/>
</body></worldbody></mujoco>"""
OMEGA = 2 * np.pi * 3  # [rad/s]


def energy_left(integrator):
    """Share of a free 3 Hz oscillation's energy that 10 s at 1 ms leave, mean over a period each.

    The mean removes the ripple of ± ωh/2 that every explicit first-order integrator shows within a
    period.
    """
    model = mujoco.MjModel.from_xml_string(FLYWHEEL)
    model.opt.integrator = integrator
    model.jnt_stiffness[:] = 0.02 * OMEGA**2
    model.qpos_spring[:] = 0.4
    data = mujoco.MjData(model)
    data.qpos[:] = 1.0

    def mean_energy_of_three_periods():
        energy = 0.0
        for _ in range(1000):
            mujoco.mj_step(model, data)
            energy += data.qvel[0] ** 2 + OMEGA**2 * (data.qpos[0] - 0.4) ** 2
        return energy

    before = mean_energy_of_three_periods()
    mujoco.mj_step(model, data, 9_000)
    return mean_energy_of_three_periods() / before


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_every_allowed_integrator_keeps_the_energy_of_a_free_spring(integrator):
    assert energy_left(INTEGRATORS[integrator]) == pytest.approx(1.0, abs=0.01)


def test_integrator_discrete_dissipates_a_free_spring_and_is_refused(experiment):
    """It takes the spring's torque at the end of the step, as backward Euler does.

    Each step divides the energy by 1 + (ωh)²: after 10 s 3 % are left, and a minimum of torque that
    is found with it is not one of (3).
    """
    left = energy_left(mujoco.mjtIntegrator.mjINT_DISCRETE)
    assert left == pytest.approx((1 + (OMEGA * 1e-3) ** 2) ** -10_000, rel=0.02)
    assert left < 0.05
    with pytest.raises(rmj.ResonanceError, match=r"discrete.*dissipates"):
        experiment.replace({"simulation.integrator": "discrete"})


@pytest.mark.parametrize("home", [(np.pi, 0.0), (0.0, 0.0)])
def test_motion_is_found_from_a_home_pose_that_is_exactly_stretched(home):
    """There the Jacobian is singular, and no small step brings the tool nearer to its base."""
    found = rmj.optimum(rmj.load("paper").replace({"robot.home": home}))
    assert all(0.7 < best.torque_reduction < 1 for best in found)
