"""What is said before a run starts."""

import re

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.cli import main
from resonance_mj.experiments.loading import for_robot
from resonance_mj.plan.plan import plan_for


def notes(changes):
    return plan_for(rmj.load("paper").replace(changes)).notes


def said(lines, words):
    return [line for line in lines if words in line]


def test_the_papers_gains_are_stable_and_nothing_is_said():
    assert not said(notes({}), "unstable")


def test_feedback_that_sampling_makes_unstable_is_said_with_the_largest_stable_gain():
    lines = said(notes({"law.k_v": 3000.0}), "unstable when sampled")
    largest = min(float(line.rsplit(" ", 1)[1]) for line in lines)
    assert 200 < largest < 3000
    assert not said(notes({"law.k_v": 0.99 * largest}), "unstable")
    assert said(notes({"law.k_v": 1.01 * largest}), "unstable")


def test_the_predicted_limit_is_where_runs_diverge():
    (line, *_) = said(notes({"law.k_v": 3000.0}), "motion.0")
    largest = float(line.rsplit(" ", 1)[1])
    base = {"motion.0.duration": 2.0, "motion.1.duration": 1.0, "law.beta": 0.0}
    held, broken = (
        rmj.simulate(rmj.load("paper").replace(base | {"law.k_v": k * largest})) for k in (0.7, 1.5)
    )
    assert np.abs(held.data["dq"].sel(time=slice(0, 2))).max() < 30
    assert broken.status is rmj.Status.DIVERGED or np.abs(broken.data["dq"]).max() > 30


def test_a_motor_too_weak_for_the_motion_is_named_with_the_ratio(tmp_path):
    text = library.robots()["two_link.xml"].read_text()
    weak = text.replace('<motor name="motor1"', '<motor ctrlrange="-0.5 0.5" name="motor1"')
    (tmp_path / "weak.xml").write_text(weak)
    lines = said(notes({"robot.mjcf": str(tmp_path / "weak.xml")}), "asks joint1 for")
    assert len(lines) == 2, "of two motions each the side that asks for more"
    assert "its motor gives 0.5, " in lines[0]


@pytest.mark.parametrize(("reach", "near"), [(0.54999, True), (0.54, False)])
def test_a_motion_near_a_singular_pose_is_said(reach, near):
    """The arm is stretched, and singular, at 0.55 m."""
    changes = {"motion.0.offset": [0.05 - reach, 0.0], "motion.0.sin": [[0.05], [0.0]]}
    assert bool(said(notes(changes), "motion.0 comes near a singular pose")) is near


@pytest.mark.parametrize("damping", [0.2, 20.0])
def test_what_damping_takes_is_said_where_it_leaves_little_to_springs(damping, tmp_path):
    """D q̇ is in quadrature with q: no spring can exert it."""
    text = library.robots()["two_link.xml"].read_text()
    path = tmp_path / "arm.xml"
    path.write_text(re.sub(r'damping="[^"]*"', f'damping="{damping}"', text))
    plan = plan_for(for_robot(str(path)))
    (best,), (joints,) = plan.optima, plan.joints
    share = ((damping * joints.dq) ** 2).sum() / (best.torque_without_springs**2).sum()
    lines = said(plan.notes, "damping and dry friction alone take")
    assert bool(lines) == (share > 0.3) == (damping > 1)
    if lines:
        assert f"{100 * share:.0f}" in lines[0]
        assert share < 1 - best.torque_reduction + 0.01


def test_notes_are_short_on_the_command_line_and_whole_where_it_is_asked(capsys, tmp_path):
    short = ["run", "paper", "--motion.0.duration", "1", "--motion.1.duration", "1"]
    short += ["--out", str(tmp_path)]
    main(short)
    brief = capsys.readouterr().out
    main([*short, "--explain"])
    explained = capsys.readouterr().out
    assert "warning: learning diverges about cycle 250" in brief
    assert "would not diverge … (more: --explain)" in brief
    assert "fastest, by" not in brief
    assert "fastest, by" in explained
    assert "--explain" not in explained
    assert any("fastest, by" in note for note in rmj.Run.load(tmp_path).notes)
