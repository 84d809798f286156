"""Poses of many joint angles at once are MuJoCo's, and a motion's are on one branch."""

import mujoco
import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.motions import rotations
from resonance_mj.motions.forward_kinematics import Chain
from resonance_mj.motions.inverse_kinematics import STRIDE, InverseKinematics
from resonance_mj.plan.plan import plan_for

ARMS = ["paper", "scara", "six-joint-pose", "seven-joint"]  # a slide, three rotations, seven axes


@pytest.fixture(scope="module", params=ARMS)
def robot(request):
    return plan_for(rmj.load(request.param)).robot


@pytest.fixture(scope="module")
def states(robot):
    rng = np.random.default_rng(5)
    return rng.uniform(-3, 3, (40, robot.n)), rng.uniform(-9, 9, (40, robot.n))


def inverse_of(robot):
    data = mujoco.MjData(robot.model)
    return InverseKinematics(robot, data, Chain(robot, data))


def test_poses_jacobians_and_their_rates_are_those_of_mujoco(robot, states):
    chain, model, data = Chain(robot), robot.model, mujoco.MjData(robot.model)
    poses = chain.poses(states[0])
    J, drift = chain.jacobians(poses), chain.drifts(poses, states[1])
    for i, (q, dq) in enumerate(zip(*states, strict=True)):
        data.qpos[robot.qpos_address], data.qvel[robot.dof_address] = q, dq
        mujoco.mj_forward(model, data)
        assert poses.position[i] == pytest.approx(data.site_xpos[robot.site], abs=1e-14)
        assert poses.orientation[i].ravel() == pytest.approx(data.site_xmat[robot.site], abs=1e-13)
        full, rate = np.zeros((6, model.nv)), np.zeros((6, model.nv))
        mujoco.mj_jacSite(model, data, full[:3], full[3:], robot.site)
        body, at = model.site_bodyid[robot.site], data.site_xpos[robot.site]
        mujoco.mj_jacDot(model, data, rate[:3], rate[3:], at, body)
        columns = np.ix_(robot.coordinate, robot.dof_address)
        assert J[i] == pytest.approx(full[columns], abs=1e-13)
        assert drift[i] == pytest.approx(rate[columns] @ dq, abs=1e-10)


def test_the_error_to_a_position_nearby_is_what_the_jacobian_makes_of_the_way_there(robot, states):
    chain, q = Chain(robot), robot.home + 0.01 * states[0]
    way = 1e-6 * states[1]
    target, poses = chain.positions(chain.poses(q + way)), chain.poses(q)
    expected = (chain.jacobians(poses) @ way[..., None])[..., 0]
    assert chain.errors(poses, target) == pytest.approx(expected, abs=1e-9)


def test_rotations_of_many_are_those_of_one():
    rng = np.random.default_rng(2)
    r = rng.normal(size=(30, 3)) * np.geomspace(1e-12, 1.5, 30)[:, None]
    home, one, back = np.linalg.qr(rng.normal(size=(3, 3)))[0], np.empty((3, 3)), np.empty(3)
    many = rotations.turned(r, home)
    for i in range(30):
        rotations.rotation(r[i], home, one)
        assert many[i] == pytest.approx(one, abs=1e-14)
        rotations.rotation_vector(many[i], home, back)
        assert rotations.between(many, home)[i] == pytest.approx(back, abs=1e-14)


@pytest.mark.parametrize("name", ["paper", "six-joint-pose"])
def test_a_motion_has_the_joint_angles_that_its_positions_have_one_by_one(name):
    plan = plan_for(rmj.load(name))
    inverse, x = inverse_of(plan.robot), plan.desired(0).x
    at_once = inverse.along(x, plan.robot.home, 0.0)
    q = plan.robot.home
    for i, position in enumerate(x):
        q, error, J = inverse.solved(position, q)
        assert np.abs(error).max() < 1e-11
        assert at_once.q[i] == pytest.approx(q, abs=1e-9)
        assert at_once.J[i] == pytest.approx(J, abs=1e-9)


def test_of_a_motion_out_of_reach_the_first_such_position_is_the_last_that_is_looked_at():
    robot = plan_for(rmj.load("paper")).robot
    t = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    center = Chain(robot).positions(Chain(robot).poses(robot.home[None]))[0]
    x = center * (1 + 1.03 * (1 - np.cos(t))[:, None])  # outwards from the base, and back
    found = inverse_of(robot).along(x, robot.home, 0.0)
    reach = 0.3 + 0.25
    first = int(np.argmax(np.linalg.norm(x, axis=1) > reach))
    assert not found.reached
    assert 0 < first == len(found.q) - 1
    assert first % STRIDE
    assert found.away == pytest.approx(np.linalg.norm(x[first]) - reach, rel=1e-3)
