"""Work that a copy of this process does meanwhile."""

import os

import pytest

from resonance_mj import forking


def test_a_copy_writes_while_this_process_goes_on(tmp_path):
    path = tmp_path / "process"
    with forking.meanwhile(lambda: path.write_text(str(os.getpid()))) as done:
        here = os.getpid()
    assert done()
    assert path.read_text() != str(here)


def test_work_that_fails_or_cannot_be_copied_is_told_to_be_done_here(monkeypatch):
    with forking.meanwhile(lambda: 1 / 0) as done:
        pass
    assert not done()
    monkeypatch.setattr(forking.sys, "platform", "darwin")
    with forking.meanwhile(lambda: pytest.fail("no copy was asked for")) as done:
        pass
    assert not done()
