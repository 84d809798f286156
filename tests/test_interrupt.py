"""A run that is asked to stop ends after its cycle, with what there is."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import resonance_mj as rmj

LONG = rmj.load("two-link-transfer").replace({"motion.0.duration": 20.0})


def test_a_run_that_is_stopped_has_the_cycles_until_then_and_says_so(tmp_path):
    done = []
    run = rmj.simulate(LONG, progress=lambda *one: done.append(one), stop=lambda: len(done) == 7)
    assert run.status is rmj.Status.INTERRUPTED
    assert "after cycle 7 of 60" in run.message
    assert run.data.sizes["cycle"] == 7
    whole = rmj.simulate(LONG)
    for name in ("torque_squared", "tracking_rms", "stiffness_per_cycle"):
        np.testing.assert_array_equal(run.data[name].values, whole.data[name].values[:7])
    loaded = rmj.Run.load(run.save(tmp_path))
    assert loaded.status is rmj.Status.INTERRUPTED
    assert loaded.data.identical(run.data)


def test_a_stop_at_the_end_of_a_run_interrupts_nothing():
    short = LONG.replace({"motion.0.duration": 2.0, "motion.1.duration": 2.0})
    cycles = []
    run = rmj.simulate(
        short, progress=lambda *one: cycles.append(one), stop=lambda: len(cycles) > 3
    )
    assert run.status is not rmj.Status.INTERRUPTED
    assert run.data.sizes["cycle"] == 4


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_a_signal_ends_the_command_with_what_there_is(tmp_path, number):
    keys = "--motion.0.duration 50000 --simulation.samples 20000 --law.eta 0.5 --out out"
    command = [sys.executable, "-m", "resonance_mj.cli", "run", "two-link-transfer"]
    process = subprocess.Popen(
        [*command, *keys.split()],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    # Said before the first step: law.eta has no effect beside law.beta.
    assert "law.eta" in process.stdout.readline()
    time.sleep(2.0)
    process.send_signal(number)
    out, said = process.communicate(timeout=120)
    assert process.returncode == 128 + number, (out, said)
    assert f"{number.name}: ends after this cycle" in said
    assert "interrupted: asked to stop, after cycle" in said
    run = rmj.Run.load(tmp_path / "out")
    assert run.status is rmj.Status.INTERRUPTED
    assert 0 < run.data.sizes["cycle"] < 50040
    assert {path.name for path in tmp_path.iterdir()} == {"out"}
    assert not [path for path in (tmp_path / "out").iterdir() if path.name.startswith(".")]
