"""All laws on one experiment: the same runs as one by one, figures of them, and a verdict."""

import csv
import io
import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.cli import comparison_tables
from resonance_mj.evaluation import comparison
from resonance_mj.evaluation.comparison import Comparison, Verdict
from resonance_mj.experiments.loading import for_robot
from resonance_mj.pictures.figures import comparison_figure
from resonance_mj.robots.robot import build

MOTIONS = {"motion.0.duration": 3.0, "motion.1.duration": 4.0, "simulation.timestep": 2e-3}


@pytest.fixture(scope="module")
def paper():
    return rmj.load("paper").replace(MOTIONS)


@pytest.fixture(scope="module")
def compared(paper):
    told = []
    found = rmj.compare(paper, long=20, progress=lambda *counts: told.append(counts))
    assert told[-1] == (9 * (3 + 4) + 9 * (3 + 20),) * 2
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    return found


def row(compared, law, motion):
    (found,) = (r for r in compared.rows() if (r["law"], r["motion"]) == (law, motion))
    return found


def test_every_law_is_compared_in_every_motion(compared):
    rows = compared.rows()
    assert len(rows) == 18
    assert [r["law"] for r in rows[::2]] == [one.name for one in comparison.CONTENDERS]
    assert {r["motion"] for r in rows} == {1, 2}


@pytest.mark.parametrize("name", ["printed", "printed-transpose", "transfer", "computed-torque"])
def test_a_comparisons_run_is_that_of_its_experiment_alone(paper, compared, name):
    alone = rmj.simulate({one.name: each for one, each in comparison.contending(paper)}[name])
    np.testing.assert_array_equal(compared.runs[name].data["tau"], alone.data["tau"])


def test_as_printed_is_the_paper(paper, compared):
    np.testing.assert_array_equal(
        compared.runs["printed"].data["tau"], rmj.simulate(paper).data["tau"]
    )


def test_figures_of_a_row_are_those_of_the_runs_samples(compared):
    data = compared.runs["fixed"].data
    last = data.sel(time=data["cycle_of_sample"] == 3)
    tau, dq = last["tau"].values, last["dq"].values
    found = row(compared, "fixed", 1)
    assert found["energy"] == pytest.approx(2e-3 * np.abs(tau * dq).sum())
    assert found["peak_torque"] == np.abs(tau).max()
    without = float(data["torque_squared_without_springs"][0])
    best = 1 - float(data["torque_squared_optimal"][0]) / without
    assert found["share"] == pytest.approx((1 - (tau**2).sum(axis=1).mean() / without) / best)
    assert found["status"] == "ok"


def test_the_bound_reaches_the_possible_reduction_and_feedback_alone_none(compared):
    for motion in (1, 2):
        assert row(compared, "computed-torque", motion)["share"] == pytest.approx(1, abs=2e-3)
        assert abs(row(compared, "feedback", motion)["share"]) < 0.3
        assert row(compared, "feedback", motion)["cycles_to_optimum"] is None


def test_the_long_run_repeats_the_last_motion(compared):
    for run in compared.long.values():
        assert run.data["segment_of_cycle"].values.tolist() == [1] * 3 + [2] * 20
    rows = compared.rows()
    assert all((r["long_run"] is not None) == (r["motion"] == 2) for r in rows)
    assert row(compared, "computed-torque", 2)["long_run"] == "holds the optimum"


def test_a_law_that_diverges_is_said_to_do_so_with_the_cycle():
    """As printed with β = 10 within 20 cycles, long before the transfer with the same gain."""
    motion = rmj.load("paper").motion[1].model_dump() | {"duration": 60.0}
    paper = rmj.load("paper").replace({"motion": [motion], "law.beta": 10.0, "law.q_c": "mean"})
    laws = {one.name: each for one, each in comparison.contending(paper)}
    names = ("printed", "transfer")
    runs = dict(zip(names, rmj.simulate_many([laws[name] for name in names]), strict=True))
    found = Comparison(paper, {name: name for name in names}, runs, runs)
    run = found.long["printed"]
    assert run.status is rmj.Status.DIVERGED
    cycle = found.verdict("printed").diverged
    assert 0 <= cycle - run.data.sizes["cycle"] <= 1
    assert f"in cycle {cycle} of the run" in run.message
    assert row(found, "printed", 1)["long_run"] == f"DIVERGED at {cycle}"
    assert row(found, "transfer", 1)["long_run"] == "holds the optimum"


PENDULUM = """<mujoco><worldbody><body><joint name="hinge" axis="0 1 0" damping="0.02"/>
<geom type="sphere" pos="0 0 -0.4" size="0.03" mass="1.2" contype="0" conaffinity="0"/>
<site name="tool" pos="0 0 -0.5"/></body></worldbody>
<keyframe><key name="home" qpos="0"/></keyframe></mujoco>"""


@pytest.mark.parametrize(
    ("changes", "undefined"),
    [
        pytest.param(
            {"shape": "line", "size": (0.1, 0.0), "center": [0.0], "period": 4.0},
            ["share"],
            marks=pytest.mark.slow,
        ),
        ({"shape": "fourier", "offset": (0.0,), "blend": 0}, ["share", "torque_reduction"]),
        pytest.param(
            {"shape": "line", "size": (0.1, 0.0), "center": [0.0], "k_v": 1e7},
            [],
            marks=pytest.mark.slow,
        ),
    ],
    ids=["no spring helps", "no torque", "diverged in the first cycle"],
)
def test_what_a_comparison_cannot_say_it_leaves_out(changes, undefined, tmp_path):
    """In the rows, the files and the table."""
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    motion = dict(changes)
    k_v = motion.pop("k_v", None)
    experiment = for_robot(str(tmp_path / "pendulum.xml")).replace(
        {
            "task.coordinates": ["x"],
            "simulation.timestep": 4e-3,
            "motion": [{"duration": 3 * motion.get("period", 1.0)} | motion],
            "law.k_v": k_v,
            "law.k_p": k_v,
        }
    )
    found = rmj.compare(experiment, long=20)
    by_law = {one["law"]: one for one in found.rows()}
    for one in by_law.values():
        assert [one[key] for key in undefined] == [None] * len(undefined)
    if k_v:
        assert by_law["feedback"]["status"] == "diverged"
        assert by_law["feedback"]["peak_torque"] is None
        assert by_law["feedback"]["long_run"] == "DIVERGED at 1"
    rows = json.loads((found.save(tmp_path) / "compare.json").read_text(encoding="utf-8"))
    assert rows == found.rows()
    console = Console(file=io.StringIO(), width=120)
    console.print(comparison_tables.comparison(found))
    assert "nan" not in console.file.getvalue()


@pytest.mark.parametrize(
    ("verdict", "text"),
    [
        (Verdict(None, 0.96, 1.04), "holds the optimum"),
        (Verdict(None, 1.2, 1.25), "1.25 × optimum"),
        (Verdict(None, 1.2, 3.4), "1.2-3.4 × optimum"),
        (Verdict(None, 0.5, 0.51), "0.51 × optimum"),
        (Verdict(169, np.inf, np.inf), "DIVERGED at 169"),
        (Verdict(0, np.inf, np.inf), "DIVERGED before"),
        (Verdict(None, np.nan, np.nan), "the optimum needs no torque"),
    ],
)
def test_verdicts_say_what_was_measured(verdict, text):
    assert str(verdict) == text


@pytest.mark.slow
def test_a_comparison_is_written_as_tables_and_runs(compared, tmp_path):
    compared.save(tmp_path)
    rows = json.loads((tmp_path / "compare.json").read_text(encoding="utf-8"))
    assert rows == compared.rows()
    with (tmp_path / "compare.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert [float(line["energy"]) for line in table] == [r["energy"] for r in rows]
    run = rmj.Run.load(tmp_path / "transfer")
    np.testing.assert_array_equal(run.data["q"], compared.runs["transfer"].data["q"])
    assert {path.name for path in tmp_path.iterdir() if path.is_dir()} == set(compared.runs)
    with xr.open_dataset(tmp_path / "long.nc", engine="h5netcdf") as long:
        for name, one in compared.long.items():
            mine = long["torque_squared"].sel(law=name).dropna("cycle")
            np.testing.assert_array_equal(mine, one.data["torque_squared"])


def test_the_figure_shows_every_law_in_every_panel_and_says_what_became_of_it(compared):
    drawn = comparison_figure.figure(compared)
    torque, tracking, lasting = drawn.axes
    for ax in (torque, tracking, lasting):
        assert ax.get_yscale() == "log"
    for ax, name in ((torque, "torque_squared"), (tracking, "tracking_rms")):
        for line, run in zip(ax.lines, compared.runs.values(), strict=False):
            values = run.data[name].values
            shown = line.get_ydata()
            assert np.corrcoef(np.log(shown[3:]), np.log(values[3:]))[0, 1] > 0.999999
    (legend,) = drawn.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert len(texts) == 9
    assert "computed torque\nholds the optimum" in texts


def test_without_a_long_run_the_figure_and_the_table_do_without(compared):
    short = replace(compared, long={})
    assert len(comparison_figure.figure(short).axes) == 2
    assert all(r["long_run"] is None for r in short.rows())


def test_experiments_without_adaptation_gains_get_the_papers_per_inertia():
    plain = for_robot("planar_three_link.xml")
    inertia = np.diag(build(plain).inertia)
    by_name = {one.name: found for one, found in comparison.contending(plain)}
    for name in ("printed", "printed-lead", "joint-space"):
        np.testing.assert_allclose(by_name[name].law.gamma_k, 200 * inertia)
        np.testing.assert_allclose(by_name[name].law.gamma_qe, 500 * inertia)
    assert by_name["transfer"] == plain
    paper = rmj.load("paper")
    for one, found in comparison.contending(paper):
        if one.name.startswith("printed"):
            assert found.law.gamma_k == paper.law.gamma_k


def test_a_law_of_ones_own_is_compared_too(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(
        "def learn(u, y, q, stiffness, offset, center, parameters):\n"
        "    return u - parameters[0] * y, stiffness, offset, center\n"
    )
    mine = for_robot("two_link.xml").replace(
        {"law.kind": str(path), "law.parameters": (1.0,), "motion": [{"duration": 3.0}]}
    )
    found = rmj.compare(mine, long=0)
    assert isinstance(found, Comparison)
    assert found.titles["own"] == "mine.py"
    assert row(found, "own", 1)["status"] == str(rmj.simulate(mine).status)


@pytest.mark.parametrize("long", [-1, 1, 19])
def test_a_long_run_that_is_too_short_to_tell_is_refused(paper, long):
    with pytest.raises(rmj.ResonanceError, match=rf"long = {long}: 0 .* at least 20"):
        rmj.compare(paper, long=long)


def command(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "resonance_mj.cli", *arguments],
        capture_output=True, text=True, check=False, **options,
    )  # fmt: skip


def test_the_command_prints_the_table_and_writes_the_figure(tmp_path):
    short = ["--motion.0.duration=1", "--motion.1.duration=1", "--simulation.timestep=2e-3"]
    done = command("compare", "paper", "--long", "20", *short, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for title in ("feedback only", "as printed, Jᵀ", "transfer", "computed torque"):
        assert done.stdout.count(f"\n {title} ") == 2
    assert "20 cycles" in done.stdout
    folder = tmp_path / "runs" / "paper-compare"
    for name in ("compare.svg", "compare.png", "compare.json", "compare.csv"):
        assert (folder / name).stat().st_size > 0
    assert (folder / "transfer" / "summary.json").is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["paper", "--long", "five"], ["--long", "five"]),
        (["paper", "--long", "5"], ["long = 5", "20"]),
        (["paper", "--out", "/dev/null/x"], ["/dev/null"]),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["compare", *arguments]) == 2
    error = capsys.readouterr().err
    assert len(error.strip().splitlines()) == 1
    assert [word for word in words if word not in error] == []
    assert list(tmp_path.iterdir()) == []
