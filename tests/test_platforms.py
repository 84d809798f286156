"""Other systems than this one: their branches are taken here, in processes that take it for one."""

import json
import multiprocessing
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack

import numpy as np
import pytest
import test_callback

import resonance_mj as rmj
from resonance_mj.callback import callback

PRETEND = """
import ctypes, json, os, signal, sys
import h5netcdf, h5py, imageio_ffmpeg, matplotlib.pyplot, mujoco, numba, scipy.optimize
import scipy.interpolate, scipy.linalg, scipy.stats, xarray, rich.progress, pydantic, tomlkit
import platformdirs, concurrent.futures.process, shutil, subprocess, tempfile
import dask.array  # xarray looks for it
SYSTEM = sys.argv[1]
for name in ("fork", "posix_spawn", "killpg"):
    vars(os).pop(name, None)
if SYSTEM == "win32":
    class NoPosix:
        def find_spec(self, name, path=None, target=None):
            if name in ("fcntl", "pwd", "grp", "resource", "termios", "pty"):
                raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    sys.meta_path.insert(0, NoPosix())
    for name in ("fcntl", "pwd", "grp", "resource"):
        sys.modules.pop(name, None)
    missing = {"geteuid", "getuid", "chown", "O_NONBLOCK", "O_NOFOLLOW", "mkfifo", "fchmod"}
    if sys.version_info >= (3, 14):
        missing -= {"O_NONBLOCK"}  # its own library for this system asks for it
    for name in missing:
        vars(os).pop(name, None)
    shutil._use_fd_functions = False
    for name in ("SIGHUP", "SIGKILL"):
        vars(signal).pop(name, None)
    whole = ctypes.CDLL.__init__
    def load(self, name, *more, **options):
        if name is None:
            raise TypeError("bad argument type for built-in operation")
        whole(self, name, *more, **options)
    ctypes.CDLL.__init__ = load
sys.platform = SYSTEM
"""


@pytest.mark.parametrize("system", ["win32", "darwin"])
@pytest.mark.slow
def test_a_run_is_made_kept_and_read_with_the_same_bits_without_what_is_this_system_s_own(
    system, tmp_path
):
    code = f"""{PRETEND}
import resonance_mj as rmj
from resonance_mj.cli import main
status = main(["run", "paper", "--motion.0.duration", "2", "--motion.1.duration", "2",
               "--checkpoint", "1", "--out", sys.argv[2], "--quiet"])
again = main(["plot", sys.argv[2], "--figure", "overview", "--format", "png"])
run = rmj.Run.load(sys.argv[2])
print(json.dumps([status, again, run.data.tau.values.tolist()]))
"""
    folder = tmp_path / "run"
    done = subprocess.run(
        [sys.executable, "-c", code, system, str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Traceback" not in done.stderr
    status, again, torque = json.loads(done.stdout.splitlines()[-1])
    changes = {"motion.0.duration": 2.0, "motion.1.duration": 2.0}
    here = rmj.simulate(rmj.load("paper").replace(changes))
    assert again == 0
    assert status == (0 if here.status is rmj.Status.OK else 1)
    np.testing.assert_array_equal(np.array(torque), here.data.tau.values)
    assert not [path.name for path in folder.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize(
    ("system", "library"), [("darwin", "libmujoco.4.0.0.dylib"), ("win32", "mujoco.dll")]
)
def test_mujoco_s_library_is_found_by_the_name_that_it_has_there(
    system, library, tmp_path, monkeypatch
):
    (tmp_path / library).touch()
    monkeypatch.setattr(callback.mujoco, "__file__", str(tmp_path / "__init__.py"))
    assert callback._libmujoco.__wrapped__() == tmp_path / library


@pytest.mark.parametrize("system", ["win32", "darwin"])
@pytest.mark.slow
def test_elsewhere_mujoco_chooses_what_draws_and_the_viewer_is_not_asked_of_x(system, tmp_path):
    code = f"""{PRETEND}
os.environ.pop("MUJOCO_GL", None)
os.environ.pop("DISPLAY", None)
from resonance_mj.pictures.film import gl
from resonance_mj.pictures.viewer import display
display.check()
print(gl.backends({{}}))
"""
    done = subprocess.run(
        [sys.executable, "-c", code, system], capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    assert done.stdout == "(None,)\n"


def simulated():
    """A short run's torque."""
    return rmj.simulate(test_callback.short()).data.tau.values


@pytest.mark.slow
def test_processes_that_begin_at_once_with_an_empty_cache_all_come_to_the_same_end(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with ExitStack() as stack:
        began = []
        for method in ("spawn", "forkserver"):
            context = multiprocessing.get_context(method)
            pool = stack.enter_context(ProcessPoolExecutor(1, mp_context=context))
            began.append(pool.submit(simulated))
        found = [one.result(timeout=300) for one in began]
    for torque in found:
        np.testing.assert_array_equal(torque, simulated())
    assert len(list(tmp_path.rglob("control-*.o"))) == 1
