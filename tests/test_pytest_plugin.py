"""The pytest plugin in real processes, the assertions, and the cache of runs behind the fixture."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

import resonance_mj as rmj
from resonance_mj import testing
from resonance_mj.evaluation.checks import run_cache
from resonance_mj.evaluation.checks.run_cache import RunCache, fingerprint
from resonance_mj.experiments.loading import for_robot

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
    # Two runs were made for four tests in two workers, and none is left half-written.
    kept = list((project / ".pytest_cache" / "d" / "resonance-mj").iterdir())
    assert len(kept) == 2
    assert not [path for path in kept if path.suffix == ".tmp"]


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


# The cache of runs


@pytest.fixture
def counted(monkeypatch):
    """How often an experiment is really simulated."""
    made = []

    def simulate(experiment):
        made.append(experiment)
        return rmj.simulate(experiment)

    monkeypatch.setattr(run_cache, "simulate", simulate)
    return made


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
    (tmp_path / "cache").mkdir()
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
    drawn, counted, tmp_path, name, old, new
):
    """In another process, and in the same one."""
    cache = RunCache(tmp_path / "cache")
    before = cache.run(drawn)
    assert RunCache(tmp_path / "cache").run(drawn).data.identical(before.data)
    assert len(counted) == 1
    path = tmp_path / name
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    fresh = rmj.simulate(drawn)
    assert not fresh.data.identical(before.data)
    for each in (cache, RunCache(tmp_path / "cache")):
        assert each.run(drawn).data.equals(fresh.data)
    # What it was before is found again.
    path.write_text(text)
    RunCache(tmp_path / "cache").run(drawn)
    assert len(counted) == 2


def test_a_run_has_the_name_and_expectations_that_it_is_asked_for_with(
    experiment, counted, tmp_path
):
    first = RunCache(tmp_path).run(experiment)
    expect = {"stiffness": "optimal"}
    again = RunCache(tmp_path).run(experiment.replace({"name": "other", "expect": expect}))
    assert len(counted) == 1
    assert again.experiment.name == "other"
    assert again.experiment.expect.stiffness.value == "optimal"
    assert again.data.drop_attrs().identical(first.data.drop_attrs())
    assert again.plan.experiment == again.experiment


def test_one_test_cannot_change_the_run_of_another(experiment):
    cache = RunCache(None)
    cache.run(experiment).data["torque_squared"].values[:] = 0.0
    assert cache.run(experiment).data["torque_squared"].values.all()


def test_versions_environment_and_sources_make_another_run(experiment, tmp_path, monkeypatch):
    found = [fingerprint(experiment)]
    assert fingerprint(experiment) == found[0]
    sources = tmp_path / "resonance_mj"
    (sources / "laws").mkdir(parents=True)
    (sources / "laws" / "learning.py").write_text("gain = 1\n")
    for change in (
        lambda: monkeypatch.setattr(run_cache, "versions", lambda: {"mujoco": "9"}),
        lambda: monkeypatch.setenv("NUMBA_DISABLE_JIT", "1"),
        lambda: monkeypatch.setattr(run_cache, "PACKAGE", sources),
        lambda: (sources / "laws" / "learning.py").write_text("gain = 2\n"),
    ):
        change()
        found.append(fingerprint(experiment))
    assert len(set(found)) == 5


def test_all_sources_of_the_package_are_among_what_a_run_depends_on():
    from resonance_mj.laws import learning

    assert Path(rmj.__file__).parent == run_cache.PACKAGE
    assert Path(learning.__file__) in run_cache.PACKAGE.rglob("*.py")


def test_a_file_that_changes_while_a_run_is_made_leaves_nothing_behind(
    drawn, tmp_path, monkeypatch
):
    def simulate(experiment):
        (tmp_path / "path.csv").write_text(CSV.replace("0.32,-0.22", "0.32,-0.21"))
        return rmj.simulate(experiment)

    monkeypatch.setattr(run_cache, "simulate", simulate)
    RunCache(tmp_path / "cache").run(drawn)
    assert list((tmp_path / "cache").iterdir()) == []


def test_the_run_of_a_law_of_ones_own_is_always_made_anew(experiment, counted, tmp_path):
    """What its file reads or imports is not known."""
    law = tmp_path / "mine.py"
    law.write_text(
        "import gain\n"
        "def learn(u, y, q, stiffness, offset, center, parameters):\n"
        "    return u - gain.BETA * y, stiffness, offset, center\n"
    )
    (tmp_path / "gain.py").write_text("BETA = 1.0\n")
    mine = experiment.replace({"law.kind": str(law), "motion.0.duration": 2.0})
    cache = RunCache(tmp_path)
    cache.run(mine)
    cache.run(mine)
    assert len(counted) == 2


def test_what_stands_broken_or_foreign_in_the_cache_is_simulated_anew_and_mended(
    experiment, counted, tmp_path
):
    """Half a file, a file of another run, a whole other run, one that was not made here."""
    cache, other = tmp_path / "cache", tmp_path / "other"
    for folder in (cache, other):
        folder.mkdir()
    expected = RunCache(cache).run(experiment)
    RunCache(other).run(experiment.replace({"law.eta": 0.1}))
    (kept,), (foreign,) = cache.iterdir(), other.iterdir()

    def unsealed():
        shutil.rmtree(kept)
        rmj.simulate(experiment.replace({"law.eta": 0.1})).save(kept)

    for damage in (
        lambda: (kept / "run.nc").write_bytes((kept / "run.nc").read_bytes()[:-1000]),
        lambda: shutil.copy(foreign / "run.nc", kept),
        lambda: shutil.copytree(foreign, kept, dirs_exist_ok=True),
        unsealed,
    ):
        damage()
        before = len(counted)
        assert RunCache(cache).run(experiment).data.equals(expected.data)
        assert RunCache(cache).run(experiment).data.equals(expected.data)
        assert len(counted) == before + 1


def test_a_cache_that_cannot_be_written_costs_nothing_but_time(experiment, counted, tmp_path):
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", None):
        cache = RunCache(folder)
        assert cache.run(experiment).status is rmj.Status.OK
        assert cache.run(experiment).status is rmj.Status.OK
    assert len(counted) == 2


def test_the_last_used_runs_stay(experiment, tmp_path, monkeypatch):
    monkeypatch.setattr(run_cache, "KEPT", 2)
    one, two, three = (experiment.replace({"law.eta": eta}) for eta in (0.3, 0.4, 0.5))
    for index, each in enumerate((one, two)):
        RunCache(tmp_path).run(each)
        os.utime(tmp_path / fingerprint(each), (index, index))
    RunCache(tmp_path).run(one)  # used again
    RunCache(tmp_path).run(three)
    assert {path.name for path in tmp_path.iterdir()} == {fingerprint(one), fingerprint(three)}
