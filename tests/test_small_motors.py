"""Motors that a motion asks for more than they give without springs: it grows, and springs help."""

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.experiments.loading import for_robot
from resonance_mj.plan.plan import plan_for
from resonance_mj.status import Status

ARM = """<mujoco><compiler angle="radian"/><worldbody>
<body name="l1"><joint name="j1" axis="0 -1 0" damping=".03"/>
<geom type="capsule" fromto="0 0 0 .35 0 0" size=".02" mass="2" contype="0" conaffinity="0"/>
<body name="l2" pos=".35 0 0"><joint name="j2" axis="0 -1 0" damping=".02"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1.5" contype="0" conaffinity="0"/>
<body name="l3" pos=".3 0 0"><joint name="j3" axis="0 -1 0" damping=".01"/>
<geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".8" contype="0" conaffinity="0"/>
<site name="tool" pos=".2 0 0"/></body></body></body></worldbody>
<actuator>{motors}</actuator></mujoco>"""


def an_arm(folder, limits=None):
    limits = [None] * 3 if limits is None else limits
    motors = "".join(
        f'<motor joint="j{j + 1}"'
        + ("" if limit is None else f' ctrlrange="{-limit:.6g} {limit:.6g}"')
        + "/>"
        for j, limit in enumerate(limits)
    )
    (folder / "arm.xml").write_text(ARM.format(motors=motors))
    return for_robot(str(folder / "arm.xml")).replace({"robot.home": [0.5, -1.0, 0.8]})


@pytest.fixture(scope="module")
def strong(tmp_path_factory):
    return plan_for(an_arm(tmp_path_factory.mktemp("strong")))


def small(folder, strong, share, **changes):
    """The same motion with motors of a quarter more than the optimum needs, or a share of all."""
    (best,), (motion,) = strong.optima, strong.experiment.motion
    peaks = (np.abs(t).max(axis=0) for t in (best.torque, best.torque_without_springs))
    left, without = peaks
    as_before = {f"motion.0.{k}": getattr(motion, k) for k in ("size", "center", "plane")}
    experiment = an_arm(folder, np.maximum(1.25 * left, share * without))
    return experiment.replace(as_before | {"motion.0.duration": 40.0} | changes)


@pytest.mark.parametrize("share", [1.0, 0.5, 0.3, 0.03])
def test_motors_as_small_as_springs_allow_bring_the_arm_to_its_optimum(tmp_path, strong, share):
    run = rmj.simulate(small(tmp_path, strong, share))
    (motion,) = run.motions
    assert run.status is Status.OK, run.message
    assert motion.verdict == "at optimum"
    assert motion.tracking_rms[-1] < 1e-3
    assert run.experiment.motion[0].blend == 12
    assert any("motion.0 grows over 12 cycles" in note for note in run.notes)
    # The motors never gave more than they can.
    low, high = run.plan.robot.torque_limit.T
    tau = run.data["tau"].values
    assert (tau >= low).all()
    assert (tau <= high).all()


def test_without_growing_the_same_motors_lose_the_motion_and_the_run_says_so(tmp_path, strong):
    run = rmj.simulate(small(tmp_path, strong, 0.03, **{"motion.0.blend": 1}))
    assert run.status is not Status.OK
    assert "motor is at its limit" in run.message


def test_strong_motors_and_laws_that_set_no_springs_begin_in_one_cycle(tmp_path, strong):
    assert strong.experiment.motion[0].blend == 1
    (tmp_path / "other").mkdir()
    learning = small(tmp_path / "other", strong, 0.3, **{"law.kind": "learning"})
    assert plan_for(learning).experiment.motion[0].blend == 1
    assert plan_for(small(tmp_path, strong, 1.3)).experiment.motion[0].blend == 1


def test_a_duration_that_is_given_is_kept_and_another_grows_with_the_motion(tmp_path, strong):
    given = small(tmp_path, strong, 0.3, **{"motion.0.duration": 10.0})
    (motion,) = plan_for(given).experiment.motion
    assert (motion.blend, motion.cycles) == (5, 10)
    (best,), (as_before,) = strong.optima, strong.experiment.motion
    limits = 1.25 * np.abs(best.torque).max(axis=0)
    keys = {f"motion.0.{k}": getattr(as_before, k) for k in ("size", "center", "plane")}
    (motion,) = plan_for(an_arm(tmp_path, limits).replace(keys)).experiment.motion
    assert (motion.blend, motion.cycles) == (12, 32)


def test_the_law_learns_in_a_passage_of_four_cycles_and_in_none_that_is_shorter(strong):
    for blend, learns in ((3, False), (4, True)):
        run = rmj.simulate(
            strong.experiment.replace({"motion.0.blend": blend, "motion.0.duration": 6.0})
        )
        second = run.data["u"].values[run.data["cycle_of_sample"].values == 2]
        assert second.any() == learns


@pytest.mark.parametrize("share", [0.9, 0.5])
def test_motors_too_weak_for_the_motion_with_any_springs_leave_a_bounded_error_that_is_said(
    tmp_path, strong, share
):
    left = np.abs(strong.optima[0].torque).max(axis=0)
    (motion,) = strong.experiment.motion
    keys = {f"motion.0.{k}": getattr(motion, k) for k in ("size", "center", "plane")}
    run = rmj.simulate(an_arm(tmp_path, share * left).replace(keys | {"motion.0.duration": 60.0}))
    assert any("even with the best springs" in note for note in run.notes)
    errors = run.motions[0].tracking_rms
    assert len(errors) == 60
    assert errors[-10:].max() < 1.1 * errors[-20:-10].max() + 1e-4
    if not run.motions[0].tracks[-1]:
        assert run.status is Status.NOT_TRACKING
        assert "motor is at its limit" in run.message


@pytest.mark.parametrize("spare", [1.5, 1.25, 1.05])
def test_small_motors_pass_from_one_motion_to_the_next_by_way_of_a_small_one(spare):
    """What lies between these two motions needs more than their optima's peaks."""
    base = rmj.load("two-link-transfer").replace({"law": {}})
    changes = {
        f"motion.{i}.{key}": v for i in (0, 1) for key, v in (("duration", 40.0), ("blend", None))
    }
    base = base.replace(changes)
    peaks = np.max([np.abs(best.torque).max(axis=0) for best in plan_for(base).optima], axis=0)
    run = rmj.simulate(base.replace({"reality.motor_torque": (spare * peaks).tolist()}))
    assert run.status is Status.OK, run.message
    assert [motion.verdict for motion in run.motions] == ["at optimum"] * 2
    assert [motion.passage.sum() for motion in run.motions] == [12, 12]
    assert max(motion.tracking_rms[-1] for motion in run.motions) < 1e-4
