"""What a run says of itself is what one who watches the arm would say."""

import re
import subprocess
import sys

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.errors import MotionError
from resonance_mj.experiments.loading import for_robot
from resonance_mj.motions.kinematics import JointMotion
from resonance_mj.simulation.ending import _faster
from resonance_mj.status import Status

ARM = """<mujoco><compiler angle="{angle}"/>
<default><geom type="capsule" size=".02" contype="{solid}" conaffinity="{solid}"/></default>
<worldbody>{beside}
  <body name="link1"><joint name="joint1" axis="0 -1 0" damping=".2"{range1}/>
    <geom fromto="0 0 0 .3 0 0" mass="3" contype="0" conaffinity="0"/>
    <body name="link2" pos=".3 0 0"><joint name="joint2" axis="0 -1 0" damping=".1"{range2}/>
      <geom fromto="0 0 0 .25 0 0" mass="2"/><site name="tool" pos=".25 0 0"/></body></body>
</worldbody>{motors}
<keyframe><key name="home" qpos=".6 -1.2"/></keyframe></mujoco>"""
PARTS = {"angle": "radian", "solid": 1, "beside": "", "range1": "", "range2": "", "motors": ""}
GROUND = '<geom name="ground" type="plane" size="2 2 .1" pos="0 0 {}"{}/>'


def an_arm(folder, settings=(), **parts):
    """The default experiment of a two-joint arm in a vertical plane, with parts of its file."""
    (folder / "arm.xml").write_text(ARM.format(**PARTS | parts))
    return for_robot(str(folder / "arm.xml")).replace(dict(settings))


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return rmj.simulate(an_arm(tmp_path_factory.mktemp("plain")))


def test_a_tool_that_follows_its_path_is_ok_and_at_the_optimum(plain):
    assert plain.status is Status.OK
    assert plain.message == ""
    assert plain.motions[0].verdict == "at optimum"
    assert plain.motions[0].tracks[-1]


def test_the_size_of_a_path_is_its_largest_extent(plain):
    x = plain.motions[0].samples["x_desired"].values
    assert plain.motions[0].size == pytest.approx(np.ptp(x, axis=0).max(), rel=1e-6)


def test_a_limp_arm_does_not_track_and_is_not_at_any_optimum(tmp_path):
    run = rmj.simulate(an_arm(tmp_path, {"law.omega": 0.0}))
    found = run.summary()["segments"][0]
    assert run.status is Status.NOT_TRACKING
    assert found["tracking_rms"] > 0.02 * run.motions[0].size
    assert found["cycles_to_optimum"] is None
    assert run.motions[0].verdict == "off path"
    assert "does not follow motion 1" in run.message


def test_a_run_too_short_to_learn_does_not_track_and_is_told_to_go_on(tmp_path):
    run = rmj.simulate(an_arm(tmp_path, {"motion.0.duration": 2.0}))
    assert run.status is Status.NOT_TRACKING
    assert "motion.0.duration" in run.message


def test_an_arm_that_lies_on_the_floor_says_so_and_its_optimum_has_no_floor(tmp_path, plain):
    ground = GROUND.format(0.1, "")
    run = rmj.simulate(an_arm(tmp_path, _motion_of(plain), beside=ground))
    assert run.status in (Status.NOT_TRACKING, Status.DIVERGED)
    assert "ground touches link" in run.message
    assert "robot.contacts" in run.message
    assert any("along motion.0 ground touches" in note for note in run.plan.notes)
    np.testing.assert_allclose(
        run.plan.optima[0].stiffness, plain.plan.optima[0].stiffness, rtol=1e-9
    )


def test_a_motion_of_no_size_keeps_clear_of_what_stands_in_the_way(tmp_path, plain):
    lowest = plain.motions[0].samples["x_desired"].values[:, 1].min()
    beside = GROUND.format(lowest - 0.01, "")
    run = rmj.simulate(an_arm(tmp_path, beside=beside))
    assert run.status is Status.OK
    assert run.motions[0].size < 0.9 * plain.motions[0].size
    with pytest.raises(MotionError, match=r"ground touches link.*robot\.contacts"):
        rmj.simulate(an_arm(tmp_path, beside=GROUND.format(2.0, "")))


def test_where_home_leaves_no_room_a_motion_has_its_center_beside_it_and_says_so(tmp_path):
    ground = GROUND.format(0.02, "")  # through the tool at home
    run = rmj.simulate(an_arm(tmp_path, beside=ground))
    assert any("motion.0: its center is" in note and "ground" in note for note in run.notes)
    assert run.status is Status.OK
    away = np.subtract(run.experiment.motion[0].center, run.plan.robot.position[[0, 2]])
    assert 0.05 < np.linalg.norm(away) < 0.15
    with pytest.raises(MotionError, match="ground touches link2"):
        rmj.simulate(an_arm(tmp_path, {"motion.0.center": (0.454, 0.028)}, beside=ground))


def test_a_motion_of_no_size_is_one_that_the_motors_can_make_with_springs(tmp_path, plain):
    run = rmj.simulate(an_arm(tmp_path, motors=motors_of(0.3)))
    assert run.motions[0].size < 0.9 * plain.motions[0].size
    assert np.abs(run.plan.optima[0].torque).max() < 0.3


def test_a_light_touch_that_leaves_the_path_as_it_is_has_a_status_of_its_own(tmp_path, plain):
    lowest = plain.motions[0].samples["x_desired"].values[:, 1].min()
    soft = GROUND.format(lowest - 0.01, ' solref="-200 -20" solimp=".1 .2 .1"')
    run = rmj.simulate(an_arm(tmp_path, _motion_of(plain), beside=soft))
    assert run.motions[0].tracks[-1]
    assert run.status is Status.IN_CONTACT
    assert re.search(r"ground touches link\d", run.message)


def test_torque_that_grows_from_nothing_is_no_division_by_it():
    still = {"shape": "fourier", "sin": [], "cos": [], "duration": 4.0, "blend": 0}
    rest = [still | {"offset": [-0.3, 0.0]}]
    experiment = rmj.load("two-link-transfer").replace(
        {"motion": rest, "simulation.gravity": [0.0, 0.0, 0.0], "law.beta": 0.0}
    )
    assert rmj.simulate(experiment).status in (Status.OK, Status.NOT_TRACKING)
    assert not _faster(np.zeros(12))
    assert not _faster(np.array([0.0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9]))
    assert _faster(np.r_[0.0, 0.001 * 1.1 ** np.arange(9) ** 1.1])
    assert not _faster(0.001 * (1 - 0.5 ** np.arange(1, 13)))


def test_a_run_that_still_tracks_while_its_torque_grows_is_diverging_and_ends_so():
    unstable = {"law.lead": 0, "law.harmonics": 200, "motion.0.duration": 25.0}
    experiment = rmj.load("two-link-transfer").replace(unstable)
    run = rmj.simulate(experiment.replace({"motion": experiment.model_dump()["motion"][:1]}))
    assert run.motions[0].tracks[-1]
    assert run.status is Status.DIVERGING
    assert re.search(
        r"torque² of motion 1 has grown to .* ever faster; try law.lead = 1", run.message
    )
    longer = run.experiment.replace({"motion.0.duration": 50.0})
    assert rmj.simulate(longer).status is Status.DIVERGED
    calm = rmj.simulate(longer.replace({"law.lead": 1, "law.harmonics": 20}))
    assert calm.status is Status.OK


def test_without_contacts_the_arm_passes_through_and_nothing_is_said(tmp_path):
    inside = GROUND.format(0.1, "")
    run = rmj.simulate(an_arm(tmp_path, {"robot.contacts": False}, beside=inside))
    assert run.status is Status.OK
    assert not any("touch" in note for note in run.notes)


def test_ranges_read_as_degrees_are_named_with_the_cure(tmp_path, plain):
    degrees = {"angle": "degree", "range1": ' range="-3 3"', "range2": ' range="-2.5 2.5"'}
    with pytest.raises(MotionError, match=r'joint1 and joint2: less.*compiler angle="radian"/>'):
        rmj.simulate(an_arm(tmp_path, **degrees))
    run = rmj.simulate(an_arm(tmp_path, _motion_of(plain), **degrees))
    assert run.status is not Status.OK
    assert "is at the end of its range, -0.0524 to 0.0524" in run.message
    assert '<compiler angle="radian"/>' in run.message


def test_the_optimum_of_a_motion_beyond_a_joint_s_range_is_without_the_stop_s_force(tmp_path):
    free = rmj.simulate(an_arm(tmp_path))
    q = free.motions[0].samples["q"].values[:, 1]
    middle = (q.min() + q.max()) / 2
    stopped = an_arm(tmp_path, _motion_of(free), range2=f' range="{middle - 3} {middle}"')
    run = rmj.simulate(stopped)
    np.testing.assert_allclose(
        run.plan.optima[0].stiffness, free.plan.optima[0].stiffness, rtol=1e-9
    )
    assert any("beyond its range" in note for note in run.plan.notes)
    assert any("joint2 is at the end of its range" in note for note in run.notes)


def _motion_of(run):
    motion = run.experiment.motion[0]
    return {"motion.0.size": motion.size, "motion.0.center": motion.center}


def motors_of(most):
    joints = (f'<motor joint="joint{i}" ctrlrange="{-most} {most}"/>' for i in (1, 2))
    return f"<actuator>{''.join(joints)}</actuator>"


def test_weak_motors_are_named_with_their_share_of_the_cycle(tmp_path, plain):
    run = rmj.simulate(an_arm(tmp_path, _motion_of(plain), motors=motors_of(0.1)))
    assert run.status is Status.NOT_TRACKING
    assert re.search(r"joint\d's motor is at its limit, -0.1 to 0.1 N m, for \d+", run.message)
    assert "motion.0.period" in run.message


def test_springs_hold_an_arm_that_its_motors_cannot_from_the_first_step(tmp_path):
    run = rmj.simulate(an_arm(tmp_path, motors=motors_of(2.0)))
    first = run.data.isel(time=0)
    weight = run.plan.kinematics.torque(
        JointMotion(run.plan.robot.home[None], np.zeros((1, 2)), np.zeros((1, 2)))
    )[0]
    spring = -first["stiffness"] * (run.plan.robot.home - first["center"]) + first["offset"]
    assert abs(weight[0]) > 2.0
    np.testing.assert_allclose(spring[0], weight[0], rtol=1e-9)
    assert run.status is Status.OK
    assert any("springs hold joint1" in note for note in run.plan.notes)


def test_pure_resonance_is_at_the_optimum_though_it_needs_no_torque(tmp_path):
    (tmp_path / "cart.xml").write_text(
        '<mujoco><worldbody><body name="cart"><joint name="x" type="slide" axis="1 0 0"/>'
        '<geom size=".1" mass="2"/></body></worldbody></mujoco>'
    )
    run = rmj.simulate(for_robot(str(tmp_path / "cart.xml")))
    assert run.motions[0].torque_squared_optimal < 1e-6 * (
        run.motions[0].torque_squared_without_springs
    )
    assert run.motions[0].cycles_to_optimum <= 15


def noisy(**changes):
    """Fifteen cycles of the paper's arm, of whose encoders the law is not told."""
    paper = rmj.load("two-link-transfer")
    motion = [paper.motion[0].model_dump(exclude_none=True) | {"duration": 15.0}]
    asked = {"law": {}, "springs": {}, "expect": {}, "motion": motion}
    asked |= {"reality.encoder_noise": 1e-3}
    return rmj.simulate(paper.replace(asked | changes))


def test_motors_that_act_on_noise_are_not_ok_though_the_tool_follows_its_path(tmp_path):
    """Their torque² recomputed from the samples: most is beyond the twentieth harmonic."""
    run = noisy(**{"law.listens": False})
    (motion,) = run.motions
    assert motion.tracks[-1]
    assert run.status == "noisy"
    last = motion.samples["cycle_of_sample"].values == motion.cycles[-1]
    power = np.abs(np.fft.rfft(motion.samples["tau"].values[last], axis=0)) ** 2
    power[1:] *= 2
    share = power[21:].sum() / power.sum()
    assert share > 0.9
    for words in (f"{100 * share:.0f}", "act on noise", "listens", "law.omega", "encoder_noise"):
        assert words in run.message, run.message
    assert motion.torque_squared[-1] > 5 * motion.torque_squared_without_springs
    run.save(tmp_path / "noisy")
    assert rmj.Run.load(tmp_path / "noisy").status == "noisy"


def test_the_law_that_listens_is_ok_under_the_same_noise():
    assert noisy().status == "ok"


def test_the_command_ends_with_1_and_says_why(tmp_path):
    an_arm(tmp_path)
    ended = subprocess.run(
        [sys.executable, "-m", "resonance_mj.cli", "run", "--robot", "arm.xml", "--law.omega", "0"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 1
    assert "off path" in ended.stdout
    assert ended.stderr.count("\n") == 1
    assert "not tracking" in ended.stderr


def test_a_motion_where_joints_are_free_has_the_optimum_of_the_motion_made_if_it_was(tmp_path):
    limp = for_robot("seven_joint.xml").replace({"law.omega": 0.0, "motion.0.duration": 3.0})
    lost = rmj.simulate(limp)
    assert lost.motions[0].optimum_of == "desired"
    assert lost.motions[0].torque_squared_optimal == pytest.approx(
        lost.plan.optima[0].torque_squared
    )


def test_a_nearly_singular_home_gets_a_motion_beside_it_that_comes_to_the_optimum():
    """Wrist and base axes nearly line up: the pose there could only be held."""
    home = [1.586, -0.1718, -1.019, 0.0379, 0.6595, -1.5781, -0.597]
    given = {"robot.home": home, "task.coordinates": ["x", "y", "z", "rotation"]}
    run = rmj.simulate(for_robot("seven_joint.xml").replace(given))
    assert any("its center is" in note for note in run.plan.notes)
    assert (run.status, run.motions[0].verdict) == (Status.OK, "at optimum")
    assert run.motions[0].tracking_rms[-1] < 1.5e-3


def test_a_motion_of_a_given_size_that_leaves_the_reach_about_home_gets_a_center_beside_it():
    """The paper's arm is 0.55 m long; with this home it reaches 2 mm further than its tool is."""
    given = {"robot.home": [0.2, 0.2], "motion.0.size": [0.04, 0.04], "motion.0.duration": 20.0}
    run = rmj.simulate(for_robot("two_link.xml").replace(given))
    said = [note for note in run.plan.notes if "its center is" in note]
    assert len(said) == 1
    assert "out of the arm's reach" in said[0]
    motion = run.experiment.motion[0]
    assert motion.size == (0.04, 0.04)
    assert (run.status, run.motions[0].verdict) == (Status.OK, "at optimum")
    for elsewhere in ({"motion.0.center": [0.52, 0.16]}, {"motion.0.size": [0.6, 0.6]}):
        impossible = for_robot("two_link.xml").replace(given | elsewhere)
        with pytest.raises(rmj.ResonanceError, match=r"motion\.0: out of the arm's reach"):
            rmj.simulate(impossible)
