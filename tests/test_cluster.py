"""Sweeps on a real Dask cluster: the same bits, whatever happens to a worker."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.errors import ClusterError
from resonance_mj.sweeps import cluster

SHORT = {"motion.0.duration": 3.0, "motion.1.duration": 3.0}
KEYS = {"law.beta": {"from": 2.0, "to": 9.0, "count": 48}}


def alike(one, other):
    return one.drop_attrs().identical(other.drop_attrs())


def sweep(experiment=None, keys=KEYS, **how):
    experiment = experiment or rmj.load("two-link-transfer").replace(SHORT)
    return rmj.sweep(experiment, keys, **{"progress": False} | how)


@pytest.fixture(scope="module")
def here():
    return sweep()


@pytest.fixture
def workers():
    """A scheduler of this process, and two workers, each a process with another folder."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0", silence_logs=50) as scheduler:
        began = [cluster.begin_worker(scheduler.scheduler_address) for _ in range(2)]
        yield scheduler.scheduler_address
        for one in began:
            cluster.end_worker(one)


def test_workers_make_the_same_bits_and_none_is_left(here, tmp_path):
    assert alike(sweep(dask="local:2", folder=tmp_path / "out"), here)
    ours = ["ps", "--ppid", str(os.getpid()), "-o", "args"]
    named = subprocess.run(ours, capture_output=True, text=True, check=False).stdout
    assert "distributed.cli.dask_worker" not in named


@pytest.mark.slow
def test_a_search_on_a_cluster_ends_as_here():
    pytest.importorskip("optuna")
    short = rmj.load("two-link-transfer").replace(SHORT)
    how = {"minimize": "torque_squared", "trials": 18, "progress": False}
    keys = {"law.beta": {"from": 2.0, "to": 9.0}}
    alone, spread = (rmj.tune(short, keys, **how, dask=dask) for dask in (None, "local:2"))
    assert alone.keys == spread.keys
    assert alike(alone.data, spread.data)


@pytest.mark.slow
def test_a_killed_worker_costs_no_result_and_makes_none_twice(here, workers, tmp_path):
    from distributed import Client

    seen = []

    def killing(done, total, bad):
        seen.append(done)
        if len(seen) == 1:
            with Client(workers, set_as_default=False) as client:
                client.wait_for_workers(2, timeout=60)
                victim = next(iter(client.run(os.getpid).values()))
            os.kill(victim, signal.SIGKILL)

    found = sweep(dask=workers, folder=tmp_path / "out", progress=killing)
    assert alike(found, here)
    assert seen == [16, 32, 48]


@pytest.mark.slow
def test_what_a_cluster_began_goes_on_without_it(here, workers, tmp_path):
    def stopping(done, total, bad):
        if done == 16:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(dask=workers, folder=tmp_path / "out", progress=stopping)
    assert len(list((tmp_path / "out" / "shards").iterdir())) == 1
    counts = []
    found = sweep(folder=tmp_path / "out", progress=lambda done, *_: counts.append(done))
    assert alike(found, here)
    assert counts == [16, 32, 48]


@pytest.mark.slow
def test_a_lost_scheduler_is_said_and_its_shards_are_kept(here, tmp_path, caplog):
    address = f"tcp://127.0.0.1:{8700 + os.getpid() % 1000}"
    began = [sys.executable, "-P", "-m", "distributed.cli.dask_scheduler", "--no-dashboard"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    host, port = address.removeprefix("tcp://").split(":")
    scheduler = subprocess.Popen([*began, "--host", host, "--port", port], **quiet)
    worker = cluster.begin_worker(address)

    def losing(done, total, bad):
        if done == 16:
            scheduler.kill()

    try:
        with pytest.raises(ClusterError, match="the scheduler was lost"):
            sweep(dask=address, folder=tmp_path / "out", progress=losing)
    finally:
        scheduler.kill()
        scheduler.wait()
        cluster.end_worker(worker)
    assert caplog.records == []  # Dask prints a traceback of its own
    assert alike(sweep(folder=tmp_path / "out"), here)


@pytest.mark.slow
def test_files_travel_with_the_experiments(workers, tmp_path):
    """The arm's file and waypoints are where no worker sees them, and one robot is none."""
    arm, path = tmp_path / "own" / "arm.xml", tmp_path / "own" / "path.csv"
    arm.parent.mkdir()
    shutil.copy(library.robots()["two_link.xml"], arm)
    base = rmj.load("two-link-transfer")
    x = [0.2, 0.25, 0.3, 0.25]
    z = [0.4, 0.45, 0.4, 0.35]
    path.write_text("x,z\n" + "\n".join(f"{a},{b}" for a, b in zip(x, z, strict=True)) + "\n")
    motion = {"shape": "csv", "file": str(path), "duration": 3.0}
    experiment = base.replace({"robot.mjcf": str(arm), "motion": [motion]})
    keys = {"law.beta": [5.0, 8.0], "robot.tool": ["tool", "nowhere"]}
    alone = sweep(experiment, keys)
    before = Path.cwd()
    assert alike(sweep(experiment, keys, dask=workers), alone)
    assert Path.cwd() == before
    said = alone["message"].sel({"robot.tool": "nowhere"}).values
    assert all("nowhere" in one for one in said)


@pytest.mark.slow
def test_workers_of_another_version_are_refused(tmp_path, monkeypatch):
    from distributed import LocalCluster

    (tmp_path / "sitecustomize.py").write_text(
        "import importlib.metadata as here\n"
        "version = here.version\n"
        "here.version = lambda name: '0.0.1' if name == 'resonance-mj' else version(name)\n"
    )
    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0", silence_logs=50) as scheduler:
        with monkeypatch.context() as changed:
            changed.setenv("PYTHONPATH", str(tmp_path))
            worker = cluster.begin_worker(scheduler.scheduler_address)
        with pytest.raises(ClusterError, match=r"resonance-mj 0\.0\.1 in place of"):
            sweep(dask=scheduler.scheduler_address)
        cluster.end_worker(worker)


@pytest.mark.parametrize(
    "address", ["local:0", "local:two", "local", "tcp://127.0.0.1:9", "nothing", ""]
)
def test_a_cluster_that_is_none_is_refused_in_one_line(address, monkeypatch):
    monkeypatch.setattr(cluster, "WAIT", 1)
    with pytest.raises(ClusterError) as refused:
        sweep(dask=address)
    assert address in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_command_says_what_is_missing_without_dask(tmp_path):
    blocked = tmp_path / "blocked" / "distributed"
    blocked.mkdir(parents=True)
    (blocked / "__init__.py").write_text("raise ImportError('none here')\n")
    (tmp_path / "sweep.toml").write_text('experiment = "paper"\n[keys]\n"law.beta" = [1.0]\n')
    command = [sys.executable, "-m", "resonance_mj", "sweep", "sweep.toml", "--dask", "local:1"]
    environment = os.environ | {"PYTHONPATH": str(blocked.parent)}
    process = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert process.returncode == 2
    assert "pip install 'resonance-mj[sweep]'" in process.stderr
    assert "Traceback" not in process.stderr
    shutil.rmtree(blocked)
