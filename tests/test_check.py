"""Runs held against [expect]: what passes, what is said when it does not, and what is rewritten."""

import dataclasses
import io
import math
import os
import tomllib

import numpy as np
import pytest
from rich.console import Console

import resonance_mj as rmj
from resonance_mj import cli, library
from resonance_mj.cli import tables
from resonance_mj.evaluation.checks import cases, check, convergence
from resonance_mj.evaluation.checks.check import Band
from resonance_mj.experiments.loading import for_robot
from resonance_mj.springs.spring import equilibrium

# The paper's first motion for ten cycles, and for five at half the speed, under the transfer law.
RUN = """# My arm.
name = "mine"

[robot]
mjcf = "two_link.xml"

[task]
coordinates = ["x", "z"]

[simulation]
timestep = 2e-3  # [s]

[[motion]]
duration = 10.0
shape = "fourier"
offset = [-0.3, 0.0]
sin = [[0.05], [-0.2]]

[[motion]]
duration = 10.0
period = 2.0
shape = "fourier"
offset = [-0.3, 0.0]
sin = [[0.05], [-0.2]]
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "mine.toml"
    path.write_text(RUN)
    return rmj.simulate(rmj.load(path))


def judged(run, expect):
    """Judgements of a run under other expectations, by key and joint."""
    experiment = run.experiment.replace({"expect": expect})
    found = check.judge(dataclasses.replace(run, experiment=experiment))
    return {(one.key.removeprefix("expect."), one.motion, one.joint): one for one in found}


def verdicts(run, expect):
    return {key: one.passed for key, one in judged(run, expect).items()}


# What passes


def test_numbers_pass_up_to_their_tolerance_and_not_beyond(run):
    for index, segment in enumerate(run.summary()["segments"]):
        for figure in ("stiffness", "torque_reduction") if index else ("offset", "tracking_rms"):
            found = segment[figure]
            for away, passes in ((0.999, True), (-0.999, True), (1.001, False), (-1.001, False)):
                for key, width in (("abs", 1e-3), ("rel", 0.01)):
                    widths = [width * (abs(v) if key == "rel" else 1) for v in np.atleast_1d(found)]
                    # The tolerance is relative to what is expected, which is itself away.
                    moved = [
                        value / (1 - away * width * math.copysign(1, value))
                        if key == "rel"
                        else value + away * each
                        for value, each in zip(np.atleast_1d(found), widths, strict=True)
                    ]
                    value = moved if isinstance(found, list) else moved[0]
                    own = {figure: {"value": value, key: width}}
                    expect = {"motion": [own if i == index else {} for i in range(2)]}
                    mine = {k: v for k, v in verdicts(run, expect).items() if k[0] != "status"}
                    assert set(mine.values()) == {passes}, (figure, key, away)


def test_of_two_tolerances_the_wider_counts(run):
    k = run.summary()["segments"][0]["stiffness"][0]
    for tolerances, passes in (
        ({"abs": 1.0, "rel": 0.0}, True),
        ({"abs": 0.0, "rel": 1.0}, True),
        ({"abs": 0.0, "rel": 0.0}, False),
    ):
        expected = {"value": k + 0.5, "joints": ["joint1"], **tolerances}
        found = verdicts(run, {"motion": [{"stiffness": expected}, {}]})
        assert found["motion.0.stiffness", 1, "joint1"] is passes


def test_what_is_expected_of_all_motions_and_of_one_is_judged_both(run):
    found = verdicts(
        run,
        {
            "tracking_rms": {"max": 1.0},
            "motion": [{}, {"tracking_rms": {"max": 0.0}, "status": "ok"}],
        },
    )
    assert found == {
        ("status", 0, ""): True,
        ("tracking_rms", 1, ""): True,
        ("tracking_rms", 2, ""): True,
        ("motion.1.status", 2, ""): True,
        ("motion.1.tracking_rms", 2, ""): False,
    }


def test_numbers_for_named_joints_are_in_the_order_of_the_names(run):
    first, second = run.summary()["segments"][0]["stiffness"]
    expected = {"value": [second, first], "rel": 1e-9, "joints": ["joint2", "joint1"]}
    assert all(verdicts(run, {"motion": [{"stiffness": expected}, {}]}).values())


def test_optimal_is_the_optimum_of_the_robot_s_own_motion(run):
    """Of `rmj.optimum`: the expected values, and what is near enough if no tolerance is given."""
    figures = dict.fromkeys(("stiffness", "offset", "equilibrium", "torque_reduction"), "optimal")
    found = judged(run, figures)
    for index, best in enumerate(rmj.optimum(run.experiment)):
        rms = math.sqrt(best.torque_squared_without_springs)
        last = np.flatnonzero(run.data["segment_of_cycle"] == index + 1)[-1] + 1
        swing = run.data["q"].values[run.data["cycle_of_sample"].values == last].std(axis=0)
        for j, joint in enumerate(("joint1", "joint2")):
            push = max(0.01 * abs(best.offset[j]), 0.001 * rms)
            for figure, value, near in (
                (
                    "stiffness",
                    best.stiffness,
                    max(0.01 * best.stiffness[j], 0.001 * rms / swing[j]),
                ),
                ("offset", best.offset, push),
                ("equilibrium", best.equilibrium, push / best.stiffness[j]),
            ):
                band = found[figure, index + 1, joint].band
                assert band.expected == value[j]
                assert (band.high - band.low) / 2 == pytest.approx(near, rel=1e-6)
        band = found["torque_reduction", index + 1, ""].band
        assert band.expected == pytest.approx(best.torque_reduction)
        # The same 5 % of torque² as of cycles_to_optimum.
        left = 1 - band.low
        assert left == pytest.approx(1.05 * best.torque_squared / rms**2)


def test_transfer_reaches_the_optimum_and_half_a_spring_is_not_it(run):
    names = [("stiffness", 1, joint) for joint in ("joint1", "joint2")]
    optimal = {"stiffness": {"value": "optimal", "rel": 0.05}}
    assert [verdicts(run, optimal)[name] for name in names] == [True, True]
    halved = run.data.assign(stiffness_per_cycle=run.data["stiffness_per_cycle"] / 2)
    half = dataclasses.replace(run, data=halved)
    assert [verdicts(half, optimal)[name] for name in names] == [False, False]


def test_share_and_equilibrium_follow_from_reduction_stiffness_and_offset(run):
    any_ = {"value": 0.0, "abs": 1e9}
    found = judged(run, {"torque_share": any_, "equilibrium": any_, "cycles_to_optimum": any_})
    for index, segment in enumerate(run.summary()["segments"]):
        share = segment["torque_reduction"] / segment["torque_reduction_optimal"]
        assert found["torque_share", index + 1, ""].found == pytest.approx(share)
        reached = found["cycles_to_optimum", index + 1, ""].found
        assert reached == segment["cycles_to_optimum"]
        center = run.data["center"].values[(run.data["cycle_of_sample"] == 10).values][-1]
        if index == 0:
            for j, joint in enumerate(("joint1", "joint2")):
                angle = equilibrium(segment["stiffness"][j], segment["offset"][j], center[j])[1]
                assert found["equilibrium", 1, joint].found == pytest.approx(angle)


def test_thinned_run_is_judged_as_the_whole_one(run):
    """Its samples lack most cycles, its last ones never."""
    thin = rmj.simulate(run.experiment.replace({"simulation.samples": 1}))
    assert thin.data.attrs["thinned"]
    expect = {"equilibrium": "optimal", "stiffness": "optimal", "torque_share": {"min": 0.9}}
    whole = judged(run, expect)
    for key, one in judged(thin, expect).items():
        assert (one.found, one.band) == (whole[key].found, whole[key].band)


@pytest.fixture(scope="module")
def diverged(run):
    """In its first motion."""
    found = rmj.simulate(run.experiment.replace({"law.k_v": 1e5, "law.k_p": 1e5}))
    assert found.status is rmj.Status.DIVERGED
    return found


def test_run_that_diverges_misses_all_but_that_it_diverges(diverged):
    expect = {"stiffness": "optimal", "tracking_rms": {"max": 1e9}, "torque_share": {"min": -1e9}}
    assert not any(verdicts(diverged, expect).values())
    motion = {"status": "diverged"}
    found = verdicts(diverged, {"status": "diverged", "motion": [motion, motion]})
    assert found == dict.fromkeys(found, True)


def test_motion_that_was_whole_before_the_run_diverged_is_ok(run):
    first = run.data.isel(cycle=slice(0, 11))  # one cycle of the second
    broken = dataclasses.replace(run, data=first, status=rmj.Status.DIVERGED)
    found = verdicts(broken, {"motion": [{"status": "ok"}, {"status": "ok"}]})
    assert found == {
        ("status", 0, ""): False,
        ("motion.0.status", 1, ""): True,
        ("motion.1.status", 2, ""): False,
    }


# What there is none of

PENDULUM = """<mujoco><worldbody><body><joint name="hinge" axis="0 1 0" damping="0.02"/>
<geom type="sphere" pos="0 0 -0.4" size="0.03" mass="1.2" contype="0" conaffinity="0"/>
<site name="tool" pos="0 0 -0.5"/></body></worldbody>
<keyframe><key name="home" qpos="0"/></keyframe></mujoco>"""


def hanging(folder, **motion):
    """A pendulum that hangs, under a motion of its tool in x."""
    (folder / "pendulum.xml").write_text(PENDULUM)
    return for_robot(str(folder / "pendulum.xml")).replace(
        {
            "task.coordinates": ["x"],
            "simulation.timestep": 2e-3,
            "motion": [{"duration": 8.0, "period": 2.0, "center": [0.0], "blend": 0} | motion],
        }
    )


@pytest.fixture(scope="module")
def unhelped(tmp_path_factory):
    """It swings slower than it would by itself: of springs that pull, none is the best."""
    folder = tmp_path_factory.mktemp("unhelped")
    return rmj.simulate(hanging(folder, period=4.0, duration=12.0, shape="line", size=(0.1, 0.0)))


@pytest.fixture(scope="module")
def effortless(tmp_path_factory):
    """It hangs still, and needs no torque."""
    folder = tmp_path_factory.mktemp("effortless")
    return rmj.simulate(hanging(folder, center=None, shape="fourier", offset=(0.0,)))


UNDEFINED = {
    "unhelped": {"torque_share": "no spring helps"},
    "effortless": {
        "torque_share": "needs no torque",
        "torque_reduction": "needs no torque",
        "cycles_to_optimum": "needs no torque",
    },
    "diverged": dict.fromkeys(
        ("torque_share", "torque_reduction", "cycles_to_optimum", "stiffness", "tracking_rms"),
        "ended before a cycle",
    ),
}


@pytest.mark.parametrize(
    "passing", [{"min": -1e9}, {"max": 1e9}, {"value": 0.0, "abs": 1e9}, {"value": 1.0, "rel": 1e9}]
)
@pytest.mark.parametrize("of", UNDEFINED)
def test_a_figure_that_there_is_none_of_passes_nothing_and_says_why(of, passing, request):
    found = judged(request.getfixturevalue(of), dict.fromkeys(UNDEFINED[of], passing))
    for (figure, *_), one in found.items():
        if figure != "status":
            assert not one.passed
            assert one.found is None
            assert UNDEFINED[of][figure] in convergence.explain(one).splitlines()[0]


@pytest.mark.parametrize("of", ["unhelped", "effortless", "diverged"])
def test_runs_without_some_figures_are_shown_and_reported(of, request):
    """Every table and every expectation, without a warning that somebody divided by nothing."""
    run = request.getfixturevalue(of)
    figures = dict.fromkeys(("stiffness", "offset", "equilibrium", "torque_reduction"), "optimal")
    others = {key: {"max": 0.0} for key in ("torque_share", "tracking_rms", "cycles_to_optimum")}
    experiment = run.experiment.replace({"expect": {**figures, **others}})
    run = dataclasses.replace(run, experiment=experiment)
    console = Console(file=io.StringIO(), width=120)
    console.print(tables.judgements(run, check.judge(run)))
    console.print(tables.summary(run))
    console.print(tables.certificates(rmj.certify(run)))
    console.print(convergence.report(run, check.judge(run)))
    text = console.file.getvalue()
    assert "nan" not in text
    assert " inf" not in text


def test_springs_that_do_nothing_are_the_optimum_where_none_is_better(unhelped, effortless):
    for run in (unhelped, effortless):
        assert verdicts(run, {"stiffness": "optimal", "offset": "optimal"}) == {
            ("status", 0, ""): True,
            ("stiffness", 1, "hinge"): True,
            ("offset", 1, "hinge"): True,
        }


def test_update_writes_no_number_that_there_is_none_of(tmp_path, capsys):
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    path = tmp_path / "still.toml"
    path.write_text(
        '[robot]\nmjcf = "pendulum.xml"\n[task]\ncoordinates = ["x"]\n[[motion]]\nduration = 2.0\n'
        'shape = "fourier"\noffset = [0.0]\n[expect]\ntorque_share = { value = 1, abs = 1 }\n'
    )
    before = path.read_text()
    assert cli.main(["check", str(path), "--update"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "still.toml: expect.torque_share" in line
    assert "needs no torque" in line
    assert path.read_text() == before


# What is said


def test_plot_and_words_tell_of_a_geometric_convergence_when_it_would_pass():
    """x(i) = 3 - 2 · 0.8^i is within 0.05 of 3 from cycle 17 on, and nears it at that pace."""
    course = 3 - 2 * 0.8 ** np.arange(1, 31)
    band = Band(3.0, False, 2.95, 3.05)
    assert convergence.when(course, band) == "it would have passed in cycles 17 to 30 of 30"
    early = convergence.when(course[:12], band)
    assert "none of the 12 cycles, nearest in cycle 12" in early
    assert early.endswith("in about cycle 17")
    lines = convergence.plot(course, Band(3.0, False, 2.0, 4.0))[:-1]
    dashed = [i for i, line in enumerate(lines) if line.endswith("-")]
    last = next(i for i, line in enumerate(lines) if line.endswith("*"))
    assert [lines[i].split()[0] for i in dashed] == ["4", "2"]
    assert dashed[0] < last < dashed[1]
    first = next(i for i, line in enumerate(lines) if line.partition("|")[2][0] in "*v")
    assert first >= dashed[1]


def test_a_figure_that_was_right_in_between_would_have_passed_there():
    band = Band(None, False, -math.inf, 1.0)
    assert "cycle 2 of 4" in convergence.when(np.array([3.0, 1.0, 1.5, 2.0]), band)
    assert "some of cycles 1 to 3 of 4" in convergence.when(np.array([1.0, 2.0, 1.0, 2.0]), band)
    assert "none of the 2 cycles" in convergence.when(np.array([np.nan, np.nan]), band)


@pytest.mark.parametrize("course", [[1.0], [2.0, 2.0], [np.nan, 1.0], [1e-9, 1e9, 5.0]])
@pytest.mark.parametrize("band", [(1.0, 1.0), (-math.inf, 2.0), (-math.inf, math.inf)])
def test_any_course_can_be_drawn(course, band):
    lines = convergence.plot(np.array(course), Band(None, False, *band))
    assert len(lines) == convergence.HEIGHT + 1
    assert all(len(line) <= convergence.WIDTH + 20 for line in lines)
    marks = sum(line.partition("|")[2].count(mark) for line in lines[:-1] for mark in "*^v")
    assert marks == np.isfinite(course).sum()


def test_report_names_joint_distance_versions_and_why_a_run_ended(run, diverged):
    expect = {
        "versions": {"mujoco": "3.0.0"},
        "motion": [
            {"stiffness": {"value": 1.0, "rel": 0.01, "joints": ["joint2"]}},
            {"torque_share": {"min": 2.0}},
        ],
    }
    experiment = run.experiment.replace({"expect": expect})
    mine = dataclasses.replace(run, experiment=experiment)
    text = convergence.report(mine, check.judge(mine))
    for words in (
        "mine: 2 of 3 expectations missed",
        f"came from mujoco 3.0.0; this run is of mujoco {run.versions['mujoco']}",
        "motion 1, stiffness joint2 [N m/rad]: found",
        "expected 1.000 ± 0.01",
        "motion 2, torque_share: found",
        "expected at least 2",
        "cycle",
    ):
        assert words in text
    ended = dataclasses.replace(diverged, experiment=experiment)
    assert diverged.message in convergence.report(ended, check.judge(ended))
    fine = dataclasses.replace(run, experiment=run.experiment.replace({"expect": {}}))
    assert convergence.report(fine, check.judge(fine)) == ""


def test_bounds_need_no_versions_to_be_explained(run):
    expect = {"versions": {"mujoco": "3.0.0"}, "torque_share": {"min": 2.0}}
    mine = dataclasses.replace(run, experiment=run.experiment.replace({"expect": expect}))
    assert "3.0.0" not in convergence.report(mine, check.judge(mine))


# The command


def written(folder, expect, name="mine.toml"):
    path = folder / name
    path.write_text(RUN + expect)
    return path


FINE = '\n[expect]\nstiffness = { value = "optimal", rel = 0.05 }\n'
MISSED = "\n[expect]\ntorque_share = { min = 1.5 }\n"


def test_check_exits_0_or_1_and_prints_what_was_expected_and_found(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    fine, missed = written(tmp_path, FINE), written(tmp_path, MISSED, "other.toml")
    assert cli.main(["check", str(fine)]) == 0
    table = capsys.readouterr().out
    for words in ("mine: none of 5", "stiffness joint2 [N m/rad]", "optimal", "passed"):
        assert words in table
    assert cli.main(["check", str(fine), str(missed)]) == 1
    out = capsys.readouterr().out
    assert "MISSED" in out
    assert "at least 1.5" in out
    assert "2 of 8 expectations missed in 2 run(s)" in out


def test_keys_of_the_experiment_change_all_that_are_checked(tmp_path, capsys):
    path = written(tmp_path, "\n[expect]\ncycles_to_optimum = { max = 10 }\n")
    assert cli.main(["check", str(path)]) == 0
    assert cli.main(["check", str(path), "--law.eta", "0.01"]) == 1
    assert "cycles_to_optimum" in capsys.readouterr().out


def test_without_names_the_files_here_and_in_runs_are_meant_or_else_the_built_in(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    built_in = [path.stem for path in cases.named([])]
    assert built_in == list(library.experiments())
    (tmp_path / "pyproject.toml").write_text("[tool.mine]\nexpect = 1\n")
    written(tmp_path, "", "without.toml")
    (tmp_path / "runs").mkdir()
    written(tmp_path / "runs", FINE)
    written(tmp_path, FINE + "[", "broken.toml")
    assert [path.name for path in cases.named([])] == ["broken.toml", "mine.toml"]
    assert [path.name for path in cases.named(["runs", "runs/mine.toml"])] == ["mine.toml"]


# Bad input


@pytest.mark.parametrize(
    ("expect", "words"),
    [
        ("stiffness = 3.0", ["expect.stiffness = 3.0", "no tolerance", "rel"]),
        ("stiffness = [3.0, 1.0]", ["expect.stiffness = [3.0, 1.0]", "no tolerance"]),
        ("stiffness = { value = 3.0 }", ["expect.stiffness", "value = 3.0", "no tolerance"]),
        ("stiffness = { value = 3.0, rel = -0.1 }", ["expect.stiffness.rel = -0.1", "0"]),
        ("stiffness = { value = 3.0, abs = nan }", ["expect.stiffness.abs = nan", "finite"]),
        ("stiffness = { value = inf, abs = 1 }", ["expect.stiffness.value = inf", "number"]),
        ('stiffness = { value = "best" }', ["expect.stiffness.value = 'best'", "'optimal'"]),
        ('stiffness = "best"', ["expect.stiffness = 'best'", "'optimal'"]),
        ("stiffness = { rel = 0.1 }", ["expect.stiffness", "value"]),
        ("stiffness = { value = 1, rel = 0.1, max = 2 }", ["expect.stiffness", "value = 1.0"]),
        ("stiffness = { max = 2, rel = 0.1 }", ["expect.stiffness", "no tolerance"]),
        ("stiffness = { min = 2, max = 1 }", ["expect.stiffness", "min = 2", "max = 1"]),
        ("stiffness = { valu = 1 }", ["expect.stiffness.valu", "unknown key", "'value'"]),
        ("stifness = 1", ["expect.stifness", "unknown key", "'stiffness'", "valid keys"]),
        ('torque_share = "optimal"', ["expect.torque_share", "'optimal'", "torque_reduction"]),
        ("tracking_rms = { value = [1], abs = 1 }", ["expect.tracking_rms", "one number"]),
        ('tracking_rms = { max = 1, joints = ["joint1"] }', ["tracking_rms", "joints"]),
        (
            'status = "good"',
            [
                "expect.status = 'good'",
                "'ok', 'not tracking', 'diverging', 'in contact', 'noisy', "
                "'interrupted' or 'diverged'",
            ],
        ),
        ("versions = { mujoco = 4 }", ["expect.versions", "4"]),
        ("stiffness = { value = [1, 2, 3], rel = 1 }", ["stiffness.value", "3 numbers", "joint2"]),
        (
            'stiffness = { value = [1, 2], rel = 1, joints = ["joint1"] }',
            ["expect.stiffness.value = [1.0, 2.0]", "2 numbers", "joint1"],
        ),
        (
            'offset = { value = 1, abs = 1, joints = ["jiont2"] }',
            ["expect.offset.joints = ['jiont2']", "two_link.xml", "'joint2'", "joint1, joint2"],
        ),
        ("[[expect.motion]]", ["expect.motion has 1 table", "2 motions"]),
        ("[[expect.motion]]\n" * 3, ["expect.motion has 3 tables", "2 motions"]),
        (
            "[[expect.motion]]\n[[expect.motion]]\nstiffness = { value = [1], rel = 1 }",
            ["expect.motion.1.stiffness.value = [1.0]", "1 numbers", "2 joints"],
        ),
        ("[[expect.motion]]\nstifness = 1", ["expect.motion.0.stifness", "'stiffness'"]),
    ],
)
def test_bad_expectations_exit_2_in_one_line_that_names_file_key_value_and_remedy(
    expect, words, tmp_path, capsys
):
    path = written(tmp_path, f"\n[expect]\n{expect}\n")
    assert cli.main(["check", str(path)]) == 2
    out, err = capsys.readouterr()
    (line,) = err.splitlines()
    assert line.startswith(f"resonance-mj: {path}: ")
    assert [word for word in words if word not in line] == []
    assert out == ""


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no.toml"], ["no.toml", "does not exist"]),
        (["papr"], ["'papr'", "'paper'"]),
        (["without.toml"], ["without.toml", "[expect]", 'stiffness = "optimal"']),
        (["empty"], ["empty", "[expect]"]),
        (["mine.toml", "--law.bta", "1"], ["law.bta", "'beta'"]),
        (["mine.toml", "--law.beta", "1", "--update"], ["--law.beta", "--update"]),
    ],
)
def test_what_cannot_be_checked_is_said_before_anything_is_simulated(
    arguments, words, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    written(tmp_path, FINE)
    written(tmp_path, "", "without.toml")
    assert cli.main(["check", *arguments]) == 2
    out, err = capsys.readouterr()
    (line,) = err.splitlines()
    assert [word for word in words if word not in line] == []
    assert out == ""


# Rewriting

OLD = """
[expect]  # what my arm must show
torque_share = { min = 0.5 }
stiffness = { value = "optimal", rel = 0.05 }

# The first motion.
[[expect.motion]]
torque_reduction = { value = 0.1, abs = 0.002 }  # was hoped for
offset = { value = [
  1.0,   # joint1
  2.0,   # joint2
], rel = 0.01 }

[[expect.motion]]   # the slow one
tracking_rms = { value = 1e-3, rel = 1e9 }
stiffness = { value = 0, rel = 0.01 }
"""


def test_update_rewrites_the_numbers_missed_and_nothing_else(run, tmp_path, capsys):
    path = written(tmp_path, OLD)
    assert cli.main(["check", str(path)]) == 1
    capsys.readouterr()
    assert cli.main(["check", str(path), "--update"]) == 0
    shown = capsys.readouterr().out
    first, second = run.summary()["segments"]
    text = path.read_text()
    expect = tomllib.loads(text)["expect"]
    new = expect["motion"][0]
    assert new["torque_reduction"]["value"] == pytest.approx(first["torque_reduction"], abs=1e-4)
    assert new["offset"]["value"] == pytest.approx(first["offset"], rel=1e-3)
    assert expect["motion"][1]["stiffness"]["value"] == pytest.approx(second["stiffness"], rel=1e-3)
    assert expect["versions"]["mujoco"] == run.versions["mujoco"]

    # Every other character is as it was: the lines that differ are those of the numbers.
    before = (RUN + OLD).splitlines()
    after = [line for line in text.splitlines() if not line.startswith("versions = ")]
    changed = [pair for pair in zip(before, after, strict=True) if pair[0] != pair[1]]
    assert [one.split("=")[0].strip() for one, _ in changed] == [
        "torque_reduction", "1.0,   # joint1", "2.0,   # joint2", "stiffness",
    ]  # fmt: skip
    assert all(old.partition("#")[2] == new.partition("#")[2] for old, new in changed)
    for old, new in changed:
        assert f"-{old}" in shown
        assert f"+{new}" in shown

    # Now it passes, and there is nothing left to rewrite.
    assert cli.main(["check", str(path)]) == 0
    assert cli.main(["check", str(path), "--update"]) == 0
    assert path.read_text() == text


def test_update_keeps_owner_and_mode_of_the_file(tmp_path):
    path = written(tmp_path, OLD)
    os.chown(path, 1234 if os.getuid() == 0 else -1, -1)
    path.chmod(0o640)
    before = path.stat()
    assert cli.main(["check", str(path), "--update"]) == 0
    after = path.stat()
    assert path.read_text() != RUN + OLD
    assert (after.st_uid, after.st_gid, after.st_mode) == (
        before.st_uid,
        before.st_gid,
        before.st_mode,
    )
    assert [one.name for one in tmp_path.iterdir()] == ["mine.toml"]


def test_update_leaves_requirements_alone_and_says_that_they_are_missed(tmp_path, capsys):
    path = written(tmp_path, MISSED + 'stiffness = { value = "optimal", rel = 0.0 }\n')
    before = path.read_text()
    assert cli.main(["check", str(path), "--update"]) == 1
    assert path.read_text() == before
    assert "torque_share: missed" in capsys.readouterr().err


def test_update_refuses_where_a_run_did_not_end_well_and_writes_no_file(tmp_path, capsys):
    fine = written(tmp_path, OLD)
    bad = written(tmp_path, OLD + "\n[law]\nk_v = 1e5\nk_p = 1e5\n", "bad.toml")
    before = fine.read_text(), bad.read_text()
    assert cli.main(["check", str(fine), str(bad), "--update"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert [
        word for word in ("bad.toml", "diverged", "no file is updated") if word not in line
    ] == []
    assert (fine.read_text(), bad.read_text()) == before


def test_update_refuses_one_number_for_motions_that_differ(tmp_path, capsys):
    path = written(tmp_path, "\n[expect]\noffset = { value = 1.0, rel = 1e-6 }\n")
    before = path.read_text()
    assert cli.main(["check", str(path), "--update"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert [word for word in ("expect.offset", "[[expect.motion]]") if word not in line] == []
    assert path.read_text() == before


@pytest.mark.parametrize(
    "layout",
    [
        "[expect]\r\nmotion = [{}, {}]\r\nstiffness = {{ value = {}, rel = 0.5 }}\r\n",
        "[[expect.motion]]\nstiffness.value = {}\nstiffness.rel = 0.5\n[[expect.motion]]\n",
        "[expect]\nversions = {{ mujoco = '1' }}\n[expect.stiffness]\nvalue = {}\nrel = 0.5\n",
    ],
)
def test_update_keeps_any_layout_of_toml(layout, run, tmp_path):
    """Line ends too; only the value and the versions differ."""
    path = tmp_path / "mine.toml"
    text = layout.replace("[{}, {}]", "[{{}}, {{}}]").format("[1e6, 1e6]")
    path.write_bytes((RUN + text).encode())
    assert cli.main(["check", str(path), "--update"]) == 0
    after = path.read_bytes().decode()
    assert after.startswith(RUN)
    expect = tomllib.loads(after)["expect"]
    assert expect["versions"]["mujoco"] == run.versions["mujoco"]
    kept = [line for line in after[len(RUN) :].splitlines(keepends=True) if "versions" not in line]
    old = [line for line in text.splitlines(keepends=True) if "versions" not in line]
    different = [pair for pair in zip(old, [k for k in kept if k != "[expect]\n" or k in old],
                                      strict=True) if pair[0] != pair[1]]  # fmt: skip
    assert len(different) == 1
    assert "1e6" in different[0][0]
    assert different[0][0].endswith("\r\n") == different[0][1].endswith("\r\n")
