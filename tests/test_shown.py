"""What Python and notebooks show of results."""

import re

import numpy as np
import pytest

import resonance_mj as rmj


@pytest.fixture(scope="module")
def run():
    changes = {"motion.0.duration": 12.0, "motion.1.duration": 15.0}
    return rmj.simulate(rmj.load("two-link-transfer").replace(changes))


def test_a_run_is_a_line_with_its_status_and_what_was_reached(run):
    first, second = (f"{100 * motion.torque_reduction[-1]:.1f}" for motion in run.motions)
    words = (
        rf"<Run 'two-link-transfer': ok, 27 cycles, torque² less by {first}.% \(best 96\.6.%\), "
    )
    assert re.fullmatch(words + rf"{second}.% \(best 96\.2.%\)>", repr(run))


def test_the_springs_of_a_run_are_those_of_its_last_cycle_with_names_and_units(run):
    best = rmj.optimum(run.experiment)[1]
    np.testing.assert_allclose(run.stiffness, best.stiffness, rtol=0.02)
    np.testing.assert_allclose(run.equilibrium, best.equilibrium, rtol=0.02)
    assert list(run.stiffness["joint"].values) == ["joint1", "joint2"]
    assert (run.stiffness.units, run.equilibrium.units) == ("N m/rad", "rad")


def test_a_notebook_shows_a_run_as_a_table_in_which_nothing_is_executed(run):
    page = run._repr_html_()
    assert page.count("<tr>") == 3
    assert "motion 2" in page
    assert "k joint2 (best)" in page
    assert f"{run.motions[1].stiffness_optimal[1]:.3f}" in page
    hostile = rmj.simulate(rmj.load("paper").replace({"motion.0.duration": 1.0}))
    object.__setattr__(hostile, "message", "<script>alert(1)</script>")
    assert "<script>" not in hostile._repr_html_()


def test_a_run_without_a_whole_cycle_is_shown_too():
    broken = rmj.simulate(rmj.load("paper").replace({"law.k_v": 1e6}))
    assert broken.status is rmj.Status.DIVERGED
    assert repr(broken) == "<Run 'paper': diverged, 0 cycles, torque² less by –>"
    assert "diverged" in broken._repr_html_()


def test_an_optimum_and_certificates_are_lines(run):
    assert re.fullmatch(
        r"<Optimum: stiffness \[3\.0\d+, -2\.7\d*\], equilibrium \[.*\], torque² less by 96\.6.%>",
        repr(rmj.optimum(run.experiment)[0]),
    )
    found = rmj.certify(run)
    judged = [item for item in found.items if item.holds is not None]
    assert f"{sum(map(bool, (item.holds for item in judged)))} of {len(judged)} hold" in repr(found)


def test_a_comparison_is_a_line_and_a_table():
    short = rmj.load("paper").replace({"motion.0.duration": 2.0, "motion.1.duration": 1.0})
    found = rmj.compare(short, long=0)
    assert repr(found).startswith("<Comparison of 'paper': ")
    assert found._repr_html_().count("<tr>") == 1 + len(found.rows())
