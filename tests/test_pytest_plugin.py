"""The pytest plugin in real processes, the assertions, and the runs that the fixture shares."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

import resonance_mj as rmj
from resonance_mj import pytest_plugin, testing
from resonance_mj.experiments.loading import for_robot
from resonance_mj.plan import plan

RUN = """
[robot]
mjcf = "two_link.xml"

[simulation]
timestep = 2e-3

[[motion]]
duration = 10.0
"""
SPRINGS = '\n[expect]\nstiffness = { value = "optimal", rel = 0.2 }\n'


def run_pytest(folder, *arguments):
    """A pytest process that knows nothing of this project but the installed plugin."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")}
    return subprocess.run(
        [sys.executable, "-m", "pytest", *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A project with a good run, a bad one, one that cannot be read, and Python tests."""
    folder = tmp_path_factory.mktemp("project")
    files = {
        "pytest.ini": "[pytest]\nresonance = true\n",
        "good.toml": RUN + SPRINGS,
        "missed.toml": RUN + "\n[expect]\nstiffness = { value = 99, rel = 0.1 }\n",
        "broken.toml": RUN + "\n[expect]\nstiffness = { value = [1, 2, 3], rel = 0.1 }\n",
        "plain.toml": RUN,
        "other.toml": "[project]\nname = 'mine'\n",
        "runs/saved/run.nc": "",
        "runs/saved/experiment.toml": RUN + SPRINGS,
        "test_springs.py": """
import pytest
from resonance_mj.testing import assert_converged, assert_optimal, assert_stiffness

@pytest.mark.parametrize("times", range(2))
def test_fixture(resonance_run, times):
    run = resonance_run("plain.toml")
    assert run is not resonance_run("plain.toml", {"springs.stiffness": [0.0, 1.0]})
    assert_converged(run)
    assert_optimal(run, rel=0.2)
    with pytest.raises(AssertionError, match="stiffness joint2"):
        assert_stiffness(run, 99.0, rel=0.1)
""",
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def outcomes(process):
    """Lines of pytest's short summary, sorted, by their first two words."""
    lines = process.stdout.splitlines()
    kinds = ("PASSED", "FAILED", "ERROR", "SKIPPED")
    return sorted(" ".join(line.split()[:2]) for line in lines if line.startswith(kinds))


@pytest.mark.slow
def test_workers_collect_what_holds_expect_and_say_what_is_missed(project):
    process = run_pytest(project, "-n", "2", "-rA", "--junitxml=verdicts.xml")
    assert outcomes(process) == [
        "ERROR broken.toml",
        "FAILED missed.toml::missed",
        "PASSED good.toml::good",
        "PASSED test_springs.py::test_fixture[0]",
        "PASSED test_springs.py::test_fixture[1]",
    ]
    for words in (
        "broken.toml: expect.stiffness.value = [1.0, 2.0, 3.0]: 3 numbers for 2 joints",
        "missed: 2 of 3 expectations missed",
        "stiffness joint1 [N m/rad]: found",
        "too low",
        "it would have passed in none of the 10 cycles",
        "-----",
    ):
        assert words in process.stdout
    assert "Traceback" not in process.stdout
    assert "convergence.py" not in process.stdout
    # Continuous integration reads it all from pytest's own report.
    (report,) = ElementTree.parse(project / "verdicts.xml").getroot()
    failures = {case.get("name"): case.findtext("failure") for case in report.iter("testcase")}
    assert "stiffness joint1 [N m/rad]: found" in failures["missed"]
    assert failures["good"] is None


@pytest.mark.slow
def test_names_and_the_first_failure_select_and_stop_as_for_any_test(project):
    """Here asked for by the option, and by the ini setting above."""
    asked = ("-o", "resonance=false", "--resonance")
    process = run_pytest(
        project, *asked, "-x", "-k", "missed or fixture", "-rA", "--ignore=broken.toml"
    )
    assert outcomes(process) == ["FAILED missed.toml::missed"]


def test_plugin_is_there_but_asleep_where_nobody_asked(tmp_path):
    """No TOML file is a test, and nothing heavy was imported."""
    (tmp_path / "good.toml").write_text(RUN + SPRINGS)
    (tmp_path / "test_light.py").write_text(
        "import sys\n"
        "def test_light(pytestconfig):\n"
        "    assert pytestconfig.pluginmanager.hasplugin('resonance-mj')\n"
        "    assert not {'numpy', 'mujoco', 'pydantic', 'numba'} & set(sys.modules)\n"
    )
    process = run_pytest(tmp_path, "-rA")
    assert outcomes(process) == ["PASSED test_light.py::test_light"], process.stdout


# The assertions


@pytest.fixture(scope="module")
def experiment(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "mine.toml"
    path.write_text(RUN)
    return rmj.load(path)


@pytest.fixture(scope="module")
def run(experiment):
    return rmj.simulate(experiment)


def test_assertions_hold_for_what_the_summary_says_and_fail_beside_it(run):
    (segment,) = run.summary()["segments"]
    reached, k = segment["cycles_to_optimum"], segment["stiffness"]
    testing.assert_converged(run, cycles=reached)
    testing.assert_stiffness(run, k, rel=1e-12)
    testing.assert_stiffness(run, k[1], abs=1e-9, joints=["joint2"], motion=1)
    testing.assert_optimal(run, rel=0.2)
    for failing in (
        lambda: testing.assert_converged(run, cycles=reached - 1),
        lambda: testing.assert_stiffness(run, [k[0], k[1] * 1.02], rel=0.01),
        lambda: testing.assert_stiffness(run, k[1], abs=1e-9, joints=["joint1"]),
        lambda: testing.assert_optimal(run, rel=1e-12),
    ):
        with pytest.raises(AssertionError, match="expectations missed"):
            failing()


def test_assertions_on_a_run_that_diverged_say_so(experiment):
    diverged = rmj.simulate(experiment.replace({"law.k_v": 1e5, "law.k_p": 1e5}))
    with pytest.raises(AssertionError, match="diverged in cycle 1"):
        testing.assert_converged(diverged)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda run: testing.assert_stiffness(run, 3.0), ["value = 3.0", "no tolerance"]),
        (lambda run: testing.assert_stiffness(run, [1.0], rel=0.1), ["1 numbers", "2 joints"]),
        (
            lambda run: testing.assert_optimal(run, joints=["joint3"]),
            ["'joint3'", "joint1, joint2"],
        ),
        (lambda run: testing.assert_optimal(run, motion=2), ["motion = 2", "1 to 1"]),
        (lambda run: testing.assert_optimal(run, rel=-1.0), ["expect.stiffness.rel = -1.0"]),
    ],
)
def test_assertions_refuse_bad_input_as_a_file_does(run, call, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        call(run)
    assert [word for word in words if word not in str(caught.value)] == []


# The runs that tests share

CUBE = (
    "".join(f"v {x} {y} {z}\n" for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1))
    + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
)
ARM = """
<mujoco>
  <include file="options.xml"/>
  <asset><mesh name="block" file="block.obj"/></asset>
  <worldbody><body name="upper">
    <joint name="shoulder" axis="0 1 0" damping="0.1"/>
    <geom type="mesh" mesh="block" mass="1"/>
    <body name="lower" pos="0.3 0 0">
      <joint name="elbow" axis="0 1 0" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0.25 0 0" size="0.02" mass="0.5"/>
      <site name="tool" pos="0.25 0 0"/>
    </body>
  </body></worldbody>
  <keyframe><key name="home" qpos="0.4 1.2"/></keyframe>
</mujoco>
"""
INCLUDED = "<mujoco><option gravity='0 0 -9.8'/></mujoco>"
CSV = "phase,x,z\n0,0.3,-0.2\n0.25,0.31,-0.2\n0.5,0.32,-0.22\n0.75,0.31,-0.21\n"


@pytest.fixture
def drawn(tmp_path):
    """An arm of several files that follows a path in another, for three cycles."""
    files = {"arm.xml": ARM, "block.obj": CUBE, "options.xml": INCLUDED, "path.csv": CSV}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    motion = {"shape": "csv", "file": str(tmp_path / "path.csv"), "duration": 3.0}
    return for_robot(str(tmp_path / "arm.xml")).replace(
        {"motion": [motion], "simulation.timestep": 2e-3}
    )


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("arm.xml", 'mass="0.5"', 'mass="0.6"'),
        ("arm.xml", 'qpos="0.4 1.2"', 'qpos="0.5 1.2"'),
        ("options.xml", "-9.8", "-3.7"),
        ("block.obj", "0.1 0.1 0.1", "0.1 0.1 0.3"),
        ("path.csv", "0.32,-0.22", "0.32,-0.21"),
    ],
)
def test_a_run_is_simulated_anew_when_any_file_has_changed_that_it_depends_on(
    drawn, resonance_run, tmp_path, name, old, new
):
    before = resonance_run(drawn)
    assert again(before, resonance_run(drawn))
    path = tmp_path / name
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    fresh = rmj.simulate(drawn)
    assert not fresh.data.identical(before.data)
    assert resonance_run(drawn).data.equals(fresh.data)
    # What it was before is found again.
    path.write_text(text)
    assert again(before, resonance_run(drawn))


def again(run, other):
    """Whether two runs were simulated at once: no other takes the same time to the nanosecond."""
    return run.simulation_wall_s == other.simulation_wall_s and run.data.equals(other.data)


def test_a_robot_named_from_another_folder_is_another_robot(drawn, resonance_run, monkeypatch):
    folder = Path(drawn.robot.mjcf).parent
    for name, mass in (("one", "0.5"), ("other", "0.7")):
        (folder / name).mkdir()
        for file in ("block.obj", "options.xml"):
            shutil.copy(folder / file, folder / name)
        (folder / name / "arm.xml").write_text(ARM.replace('mass="0.5"', f'mass="{mass}"'))
    runs = []
    for name in ("one", "other"):
        monkeypatch.chdir(folder / name)
        runs.append(resonance_run(drawn.replace({"robot.mjcf": "arm.xml"})))
    assert not runs[0].data.equals(runs[1].data)


def test_a_run_has_the_name_and_expectations_that_it_is_asked_for_with(experiment, resonance_run):
    first = resonance_run(experiment)
    expect = {"stiffness": "optimal"}
    other = resonance_run(experiment, {"name": "other", "expect": expect})
    assert again(first, other)
    assert other.experiment.name == "other"
    assert other.experiment.expect.stiffness.value == "optimal"
    assert other.plan.experiment == other.experiment


def test_one_test_cannot_change_the_run_of_another(experiment, resonance_run):
    resonance_run(experiment).data["torque_squared"].values[:] = 0.0
    assert resonance_run(experiment).data["torque_squared"].values.all()


def test_a_file_that_changes_while_a_run_is_made_leaves_no_run_of_what_it_was(
    drawn, resonance_run, tmp_path, monkeypatch
):
    """Between a look at the files and the run."""
    looked, edited = plan.plan_for, CSV.replace("0.32,-0.22", "0.32,-0.21")

    def then_edited(experiment):
        found = looked(experiment)
        _ = found.inputs
        (tmp_path / "path.csv").write_text(texts.pop())
        return found

    monkeypatch.setattr(plan, "plan_for", then_edited)
    texts, fixture = [CSV, edited], pytest_plugin.resonance_run.__wrapped__()
    of_edited = fixture(drawn)
    (tmp_path / "path.csv").write_text(CSV)
    assert not fixture(drawn).data.equals(of_edited.data)


def test_the_run_of_a_law_of_ones_own_is_always_made_anew(experiment, resonance_run, tmp_path):
    """What its file reads or imports is not known."""
    law = tmp_path / "mine.py"
    law.write_text(
        "import gain\n"
        "def learn(u, y, q, stiffness, offset, center, parameters):\n"
        "    return u - gain.BETA * y, stiffness, offset, center\n"
    )
    mine = experiment.replace({"law.kind": str(law), "motion.0.duration": 4.0})
    runs = []
    for beta in ("1.0", "2.0"):
        (tmp_path / "gain.py").write_text(f"BETA = {beta}\n")
        runs.append(resonance_run(mine))
    assert not runs[0].data.equals(runs[1].data)
