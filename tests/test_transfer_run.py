"""The transfer law on the paper's arm: at the optimum in ten cycles, and there to stay."""

import re
from functools import cache

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.loading import for_robot


@cache
def run():
    return rmj.simulate(rmj.load("two-link-transfer"))


def torque_beside_the_optimum(segment):
    data = run().data
    mine = data["segment_of_cycle"].values == segment
    optimal = data["torque_squared_optimal"].sel(segment=segment).item()
    return data["torque_squared"].values[mine] / optimal


@pytest.mark.parametrize(("segment", "cycle"), [(1, 10), (2, 15)])
def test_torque_is_within_five_percent_of_the_optimum_soon_and_stays(segment, cycle):
    ratio = torque_beside_the_optimum(segment)
    assert np.abs(ratio[cycle - 1 :] - 1).max() < 0.05
    assert run().summary()["segments"][segment - 1]["cycles_to_optimum"] <= cycle


@pytest.mark.parametrize("segment", [1, 2])
def test_stiffness_ends_within_one_percent_of_the_optimum_of_either_sign(segment):
    found = run().summary()["segments"][segment - 1]
    np.testing.assert_allclose(found["stiffness"], found["stiffness_optimal"], rtol=0.01)
    assert (min(found["stiffness_optimal"]) < 0) == (segment == 1)


def test_tracking_is_exact_to_ten_micrometres_because_velocity_is_the_integrators_own():
    assert run().summary()["segments"][1]["tracking_rms"] < 1e-5
    half_a_step_apart = rmj.simulate(
        rmj.load("two-link-transfer").replace({"law.velocity": "jacobian"})
    )
    assert half_a_step_apart.summary()["segments"][1]["tracking_rms"] > 1e-4


def test_learning_leaves_no_feedback_torque_so_that_all_torque_can_be_transferred():
    data = run().data
    last = data["cycle_of_sample"].values == data.sizes["cycle"]
    tau, u = data["tau"].values[last], data["u"].values[last]
    assert np.sqrt(((tau - u) ** 2).mean()) < 0.01 * np.sqrt((tau**2).mean())


def spring_torque(q, at):
    data = run().data
    k, offset, center = (data[name].values[at][0] for name in ("stiffness", "offset", "center"))
    return -k * (q - center) + offset


@pytest.mark.parametrize("cycle", [5, 20, 60])
def test_springs_are_handed_torque_without_a_jump_of_the_total(cycle):
    cycles = run().data["cycle_of_sample"].values
    here, there = cycles == cycle, cycles == cycle + 1
    q = run().data["q"].values[here]
    handed = spring_torque(q, there) - spring_torque(q, here)
    # With what the springs took over, the motors' torque is what was learned: 20 harmonics.
    learned = run().data["u"].values[there] + handed
    spectrum = np.abs(np.fft.rfft(learned, axis=0))
    assert spectrum[21:].max() < 1e-9 * spectrum.max()


def test_a_joint_that_stands_still_gets_no_stiffness_and_stays_stable():
    """The task leaves the SCARA's wrist free: its angle fades away, torque over angle does not."""
    experiment = rmj.load("scara")
    motion = experiment.motion[0].model_dump() | {"duration": 60.0}
    found = rmj.simulate(experiment.replace({"motion": [motion]}))
    assert found.status is rmj.Status.OK, found.message
    assert found.data["q"].values[-1000:, -1].std() < 1e-4
    assert found.data["stiffness"].values[-1, -1] < 1e-3


@pytest.mark.parametrize("damping", [2.0, 20.0, 500.0])
def test_damped_joints_follow_their_path_because_the_gain_has_their_damping(tmp_path, damping):
    text = library.robots()["two_link.xml"].read_text()
    assert text.count("damping=") == 2
    (tmp_path / "arm.xml").write_text(re.sub(r'damping="[^"]*"', f'damping="{damping}"', text))
    experiment = for_robot(str(tmp_path / "arm.xml"))
    found = rmj.simulate(experiment, strict=True).summary()["segments"][0]
    assert found["tracking_rms"] < 5e-4
    assert found["cycles_to_optimum"] <= 15


def test_an_arm_of_millimetres_and_milligrams_reaches_its_optimum_though_it_falls_fast(tmp_path):
    (tmp_path / "arm.xml").write_text(
        """<mujoco><compiler angle="radian"/><worldbody>
        <body><joint name="j1" axis="0 -1 0" damping="2e-11"/>
          <geom type="capsule" size="2e-4" fromto="0 0 0 .003 0 0" mass="1e-6"/>
          <inertial pos=".0015 0 0" mass="1e-6" diaginertia="3e-12 3e-12 3e-12"/>
          <body pos=".003 0 0"><joint name="j2" axis="0 -1 0" damping="2e-11"/>
            <geom type="capsule" size="2e-4" fromto="0 0 0 .0025 0 0" mass="1e-6"/>
            <inertial pos=".0012 0 0" mass="1e-6" diaginertia="2e-12 2e-12 2e-12"/>
            <site name="tool" pos=".0025 0 0"/></body></body></worldbody>
        <keyframe><key name="home" qpos="1.2 .8"/></keyframe></mujoco>"""
    )
    run = rmj.simulate(for_robot(str(tmp_path / "arm.xml")))
    found = run.summary()["segments"][0]
    assert run.status is rmj.Status.OK
    assert found["cycles_to_optimum"] <= 12
    slow = run.experiment.replace({"law.alpha": 10.0, "law.omega": 60.0})
    assert rmj.simulate(slow).status is not rmj.Status.OK


@pytest.mark.parametrize("friction", [2.0, 40.0])
def test_joints_with_dry_friction_break_loose_and_follow_their_path(tmp_path, friction):
    text = library.robots()["two_link.xml"].read_text()
    rough = text.replace("damping=", f'frictionloss="{friction}" damping=')
    (tmp_path / "arm.xml").write_text(rough)
    run = rmj.simulate(for_robot(str(tmp_path / "arm.xml")), strict=True)
    assert run.status is rmj.Status.OK
    assert run.motions[0].cycles_to_optimum <= 12
    assert run.motions[0].tracking_rms[-1] < 1e-3


@pytest.mark.parametrize("motors", [4.0, 6.0])
def test_motors_that_cannot_hold_the_arm_without_springs_reach_the_optimum_with_them(
    tmp_path, motors
):
    limit = f'ctrlrange="{-motors} {motors}"'
    text = library.robots()["two_link.xml"].read_text()
    text = re.sub(r"<actuator>.*</actuator>", "", text, flags=re.S).replace(
        "</mujoco>",
        f'<actuator><motor joint="joint1" {limit}/><motor joint="joint2" {limit}/></actuator>'
        "</mujoco>",
    )
    (tmp_path / "arm.xml").write_text(text)
    run = rmj.simulate(for_robot(str(tmp_path / "arm.xml")).replace({"motion.0.duration": 30.0}))
    needed = run.plan.loaded[0].torque(run.plan.joints[0])
    assert np.abs(needed).max() > motors
    assert np.abs(run.data["tau"].values).max() <= motors
    assert run.status is rmj.Status.OK
    assert run.motions[0].cycles_to_optimum <= 20


def test_an_arm_in_millimetres_behaves_as_it_does_in_metres(tmp_path):
    arm = """<mujoco><compiler angle="radian"/><option gravity="0 0 {g}"/><worldbody>
      <body><joint name="j1" axis="0 -1 0" damping="{d1}"/>
        <geom type="capsule" size="{r}" fromto="0 0 0 {l1} 0 0" mass="{m1}" contype="0"/>
        <body pos="{l1} 0 0"><joint name="j2" axis="0 -1 0" damping="{d2}"/>
          <geom type="capsule" size="{r}" fromto="0 0 0 {l2} 0 0" mass="{m2}" contype="0"/>
          <site name="tool" pos="{l2} 0 0"/></body></body></worldbody>
      <keyframe><key name="home" qpos=".6 -1.2"/></keyframe></mujoco>"""
    found = []
    for name, metre, kilogram in (("m", 1.0, 1.0), ("mm", 1e3, 10.0)):
        lengths = {"l1": 0.3 * metre, "l2": 0.25 * metre, "r": 0.02 * metre, "g": -9.8 * metre}
        damping = {"d1": 0.2 * kilogram * metre**2, "d2": 0.1 * kilogram * metre**2}
        masses = {"m1": 3 * kilogram, "m2": 2 * kilogram}
        (tmp_path / f"{name}.xml").write_text(arm.format(**lengths, **damping, **masses))
        motion = rmj.simulate(for_robot(str(tmp_path / f"{name}.xml"))).motions[0]
        found.append((motion.torque_reduction, motion.tracking_rms / motion.size))
    np.testing.assert_allclose(found[1][0], found[0][0], atol=0.01)
    np.testing.assert_allclose(found[1][1], found[0][1], rtol=0.2, atol=1e-5)
