"""The robustness map, and the two laws that only it compares."""

import csv
import json

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.cli import main
from resonance_mj.evaluation import robustness
from resonance_mj.pictures.figures import robustness_figure
from resonance_mj.plan.plan import plan_for

FEW = tuple(
    one._replace(strengths=one.strengths[-2:])
    for one in robustness.IMPERFECTIONS
    if one.name in ("encoder_noise", "motors", "payload", "preset")
)


@pytest.fixture(scope="module")
def found():
    """A map of one motion, three imperfections and three laws."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(robustness, "IMPERFECTIONS", FEW)
        patch.setattr(robustness, "LAWS", ("feedback", "transfer"))
        patch.setattr(robustness, "MORE", robustness.MORE[1:])
        patch.setattr(robustness, "CYCLES", 25)
        return robustness.robustness(rmj.load("seven-joint"))


def test_each_law_is_under_each_imperfection_at_each_strength(found):
    rows = [("ideal", 0.0)] + [(one.name, each) for one in FEW for each in one.strengths]
    laws = ["feedback", "transfer", "wrong-model"]
    assert [(c.imperfection, c.strength, c.law) for c in found.cells] == [
        (*row, law) for row in rows for law in laws
    ]
    assert {cell.status for cell in found.cells if cell.law == "transfer"} == {"ok"}


def test_what_is_kept_is_what_the_recorded_torque_says(found):
    """An ideal arm's feedback saves nothing and follows nothing, the transfer saves all."""
    ideal = {cell.law: cell for cell in found.cells if cell.imperfection == "ideal"}
    assert ideal["transfer"].kept == pytest.approx(1.0, abs=0.005)
    assert ideal["transfer"].share == pytest.approx(1.0, abs=0.005)
    assert ideal["feedback"].share == pytest.approx(0.0, abs=1e-9)
    assert ideal["feedback"].status == "not tracking"
    run = rmj.simulate(rmj.load("seven-joint").replace({"law": {"kind": "feedback"}}))
    motion = run.motions[0]
    spent = 1 - motion.torque_squared[-5:].mean() / motion.torque_squared_without_springs
    assert ideal["feedback"].kept == pytest.approx(
        spent / motion.torque_reduction_optimal, rel=0.02
    )
    noisy = [cell for cell in found.cells if cell.law == "wrong-model" and cell.strength == 1e-3]
    assert noisy[0].kept < 0.5 < ideal["wrong-model"].kept


def test_a_run_that_is_not_well_has_no_figure_beside_it_and_the_colour_of_none(found):
    off = next(cell for cell in found.cells if cell.status == "not tracking")
    assert robustness.written(off) == "off path"
    assert robustness_figure._level(off) == -1
    gone = robustness.Cell("feedback", "ideal", 0.0, None, None, None, "diverged", "why")
    assert robustness.written(gone) == "diverged"
    worse = robustness.Cell("feedback", "ideal", 0.0, 0.0, -4.2, 0.0, "ok", "")
    assert robustness.written(worse) == "5 ×"
    assert robustness_figure._level(worse) == 0


def test_the_command_prints_draws_and_writes_the_map(found, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(robustness, "robustness", lambda experiment, progress: found)
    assert main(["compare", "seven-joint", "--reality", "--out", str(tmp_path)]) == 0
    assert "payload of 40 %" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {
        "robustness.csv",
        "robustness.png",
        "robustness.svg",
    }
    with (tmp_path / "robustness.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["kept"]) for row in rows] == [cell.kept for cell in found.cells]
    assert main(["compare", "seven-joint", "--out", str(tmp_path), "--reality", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[1]["law"] == "transfer"
    assert main(["run", "seven-joint", "--reality"]) == 2
    assert "a value must follow" in capsys.readouterr().err


def test_springs_by_motor_torque_change_against_it():
    """K̇ = -ε Ω Φ F: each step of stiffness and offset is by the motors' torque of the step."""
    changes = {"law.kind": "motor-torque", "motion.0.duration": 3.0, "motion.1.duration": 1.0}
    run = rmj.simulate(rmj.load("two-link-transfer").replace(changes))
    data, dt = run.data, run.experiment.simulation.timestep
    k, offset, q, tau = (data[name].values for name in ("stiffness", "offset", "q", "tau"))
    z = q - data["center"].values
    np.testing.assert_allclose(np.diff(k, axis=0), -dt * 10.0 * (z * tau)[:-1], atol=1e-12)
    np.testing.assert_allclose(np.diff(offset, axis=0), dt * 1.0 * tau[:-1], atol=1e-12)


def test_springs_by_motor_torque_come_to_the_optimum_of_the_paper_s_arm():
    run = rmj.simulate(rmj.load("two-link-transfer").replace({"law": {"kind": "motor-torque"}}))
    assert run.status is rmj.Status.OK
    for motion in run.motions:
        assert motion.torque_squared[-1] < 1.05 * motion.torque_squared_optimal


def test_a_wrong_model_asks_for_so_much_more_torque():
    changes = {"law": {"kind": "computed-torque", "overestimate": 0.1}, "motion.0.duration": 2.0}
    run = rmj.simulate(rmj.load("two-link-transfer").replace(changes))
    plan = plan_for(run.experiment)
    needed = plan.loaded[0].torque(plan.joints[0])
    given = 1.1 * needed - plan.optima[0].springs.torque(plan.joints[0].q)
    np.testing.assert_allclose(run.data["u"].values[: len(given)], given, atol=1e-9)


def test_where_no_spring_helps_there_is_nothing_to_keep():
    none = {"springs.stiffness": [0.0, 0.0], "springs.equilibrium": [0.0, 0.0]}
    changes = {"law.kind": "transfer", "motion.0.duration": 15.0, "motion.1.duration": 15.0}
    run = rmj.simulate(rmj.load("two-link-transfer").replace(changes | none))
    figures = robustness.figures(run)
    assert (figures["share"], figures["kept"]) == (None, None)
    assert figures["tracking_rms"] == max(motion.tracking_rms[-1] for motion in run.motions)
    cell = robustness.Cell("transfer", "ideal", 0.0, **figures)
    assert robustness.written(cell) == "–"
    assert robustness_figure._level(cell) == -1
