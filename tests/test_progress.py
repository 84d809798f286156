"""Long work shows how far it is where there is someone to see it, and nowhere else."""

import io
import sys
from concurrent.futures import ThreadPoolExecutor

import test_callback

import resonance_mj as rmj


class Terminal(io.StringIO):
    """A standard error that is a terminal."""

    def isatty(self):
        return True


def a_terminal(monkeypatch):
    """Puts it in the place of this process's, within a test: pytest has its own around one."""
    shown = Terminal()
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setenv("TERM", "xterm")
    return shown


def test_a_simulation_in_a_terminal_shows_its_cycles_unless_told_not_to(monkeypatch):
    terminal = a_terminal(monkeypatch)
    experiment = test_callback.short()
    cycles = sum(motion.cycles for motion in experiment.motion)
    rmj.simulate(experiment)
    assert f"{cycles}/{cycles}" in terminal.getvalue()
    terminal.truncate(0)
    rmj.simulate(experiment, progress=False)
    counted = []
    rmj.simulate(experiment, progress=lambda *given: counted.append(given))
    assert terminal.getvalue() == ""
    assert counted == [(done + 1, cycles) for done in range(cycles)]


def test_nothing_is_shown_where_the_standard_error_is_a_file(capsys):
    rmj.simulate_many([test_callback.short()])
    assert capsys.readouterr() == ("", "")


def test_simulations_in_threads_share_a_terminal(monkeypatch):
    terminal = a_terminal(monkeypatch)
    with ThreadPoolExecutor(2) as pool:
        one, other = pool.map(rmj.simulate, [test_callback.short()] * 2)
    assert one.data.equals(other.data)
    assert "cycles" in terminal.getvalue()


def test_a_sweep_counts_what_is_not_ok(monkeypatch):
    terminal = a_terminal(monkeypatch)
    keys = {"motion.0.offset": [[-0.3, 0.0], [-9.0, 0.0]]}
    found = rmj.sweep(test_callback.short(), keys)
    assert (found["status"] != "ok").sum() == 1
    assert "1 not ok" in terminal.getvalue()
