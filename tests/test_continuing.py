"""A run that goes on from another does what one that never ended does."""

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.errors import ExperimentError

SIGNALS = ("q", "dq", "x", "tau", "u", "y", "stiffness", "offset")


def experiment(name, cycles, **changes):
    one = rmj.load(name)
    motion = one.motion[0].model_dump() | {"duration": cycles * one.motion[0].period}
    return one.replace({"motion": [motion], "expect": {}, **changes})


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("paper", {}),
        ("paper-running", {}),
        ("two-link-transfer", {}),
        ("seven-joint", {"simulation.integrator": "RK4"}),
        *(
            pytest.param(name, {}, marks=pytest.mark.slow)
            for name in ("seven-joint", "six-joint-pose")
        ),
        ("two-link-transfer", {"law.kind": "joint-space"}),
    ],
)
def test_cut_in_two_and_saved_between_it_has_the_same_bits(name, changes, tmp_path):
    whole = rmj.simulate(experiment(name, 6, **changes))
    begun = rmj.simulate(experiment(name, 3, **changes))
    loaded = rmj.Run.load(begun.save(tmp_path / "begun"))
    gone_on = rmj.simulate(experiment(name, 3, **changes), after=loaded)
    for signal in SIGNALS:
        rest = whole.data[signal].values[len(begun.data["time"]) :]
        np.testing.assert_array_equal(gone_on.data[signal].values, rest, err_msg=signal)


def test_another_motion_begins_where_the_one_before_is():
    """By a passage, as between motions in a row, whose gains are of the mean of both."""
    both = rmj.load("two-link-changes").motion[:2]
    arm = rmj.load("two-link-changes").replace({"expect": {}})
    in_a_row = rmj.simulate(arm.replace({"motion": [motion.model_dump() for motion in both]}))
    first, second = (arm.replace({"motion": [motion.model_dump()]}) for motion in both)
    gone_on = rmj.simulate(second, after=rmj.simulate(first))
    rest = in_a_row.data.isel(time=slice(-len(gone_on.data["time"]), None))
    for signal in SIGNALS:
        np.testing.assert_allclose(gone_on.data[signal], rest[signal], atol=1e-9, err_msg=signal)


def test_another_law_goes_on_with_springs_and_torque():
    begun = rmj.simulate(experiment("two-link-transfer", 12))
    held = rmj.simulate(experiment("two-link-transfer", 2, **{"law.kind": "learning"}), after=begun)
    assert held.status is rmj.Status.OK
    assert held.data["tracking_rms"].values[0] < 2 * begun.data["tracking_rms"].values[-1]
    reduced = begun.data["torque_reduction"].values[-1]
    assert held.data["torque_reduction"].values[-1] == pytest.approx(reduced, abs=1e-3)


def test_what_cannot_go_on_is_refused():
    two, seven = experiment("two-link-transfer", 2), experiment("seven-joint", 2)
    begun = rmj.simulate(two)
    with pytest.raises(ExperimentError, match=r"'seven-joint' cannot go on .* its joints are"):
        rmj.simulate(seven, after=begun)
    motion = {"shape": "line", "center": [-0.3], "size": [0.02, 0.0], "duration": 2.0}
    along_x = {"task.coordinates": ["x"], "motion": [motion], "law": {}, "expect": {}}
    with pytest.raises(ExperimentError, match=r"its coordinates are \['x'\]"):
        rmj.simulate(rmj.load("two-link-transfer").replace(along_x), after=begun)
    broken = rmj.simulate(experiment("paper", 9, **{"law.beta": 400.0}))
    assert broken.status is rmj.Status.DIVERGED
    with pytest.raises(ExperimentError, match="ended as diverged in its cycle"):
        rmj.simulate(two, after=broken)


@pytest.mark.slow
def test_the_command_goes_on_from_a_folder(tmp_path, capsys):
    line = ["run", "two-link-transfer", "--quiet", "--motion.1.duration=1"]
    assert cli.main([*line, "--motion.0.duration=3", "--out", str(tmp_path / "a")]) in (0, 1)
    more = ["--after", str(tmp_path / "a"), "--out", str(tmp_path / "b"), "--motion.0.duration=2"]
    assert cli.main([*line, *more]) in (0, 1)
    capsys.readouterr()
    first, then = (rmj.Run.load(tmp_path / name).data for name in "ab")
    gap = np.abs(then["q"].values[0] - first["q_end"].values).max()
    assert gap == 0.0
