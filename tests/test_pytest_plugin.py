"""The pytest plugin in real processes, the assertions, and the cache of runs behind the fixture."""

import os
import subprocess
import sys

import pytest

import resonance_mj as rmj
from resonance_mj import library, testing
from resonance_mj.evaluation.checks import run_cache
from resonance_mj.evaluation.checks.run_cache import RunCache, fingerprint

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
    process = run_pytest(project, "-n", "2", "-rA")
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


def test_a_run_is_simulated_once_and_again_only_if_something_changes_that_it_depends_on(
    experiment, counted, tmp_path, monkeypatch
):
    text = (library.robots()["two_link.xml"]).read_text()
    arm = tmp_path / "arm.xml"
    arm.write_text(text)
    experiment = experiment.replace({"robot.mjcf": str(arm)})
    folder = tmp_path / "cache"
    folder.mkdir()

    def run(**changes):
        return RunCache(folder).run(experiment.replace(changes))

    first = run()
    again = run(name="other", expect={"stiffness": "optimal"})
    assert len(counted) == 1
    assert again.experiment.name == "other"
    assert again.experiment.expect.stiffness.value == "optimal"
    assert again.data.drop_attrs().identical(first.data.drop_attrs())

    run(**{"law.eta": 0.4})
    assert len(counted) == 2
    arm.write_text(text.replace('mass="3.0"', 'mass="3.1"'))
    run()
    assert len(counted) == 3
    arm.write_text(text + "<!-- the same arm -->")
    run()
    assert len(counted) == 3
    monkeypatch.setattr(run_cache, "versions", lambda: {"mujoco": "9"})
    run()
    assert len(counted) == 4


def test_what_stands_broken_in_the_cache_is_simulated_anew_and_mended(
    experiment, counted, tmp_path
):
    RunCache(tmp_path).run(experiment)
    (kept,) = tmp_path.iterdir()
    for damage in (
        lambda: (kept / "run.nc").write_bytes(b"half"),
        lambda: (kept / "run.nc").unlink(),
    ):
        damage()
        before = len(counted)
        RunCache(tmp_path).run(experiment)
        RunCache(tmp_path).run(experiment)
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


# The cache of compiled laws
