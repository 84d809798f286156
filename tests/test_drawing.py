"""The process that draws the figure of a run."""

import contextlib
import tempfile

import pytest

import resonance_mj as rmj
from resonance_mj.pictures.figures import drawing


@pytest.fixture(scope="module")
def run():
    paper = rmj.load("paper")
    motions = [one.model_dump() | {"duration": 2.0} for one in paper.motion]
    return rmj.simulate(paper.replace({"motion": motions, "expect": {}}))


def drawn(run, folder):
    folder.mkdir()
    with drawing.ready() as draw:
        finished = draw(run)
        paths = finished(folder)
    assert sorted(path.name for path in paths) == ["figure.png", "figure.svg"]
    return (folder / "figure.png").read_bytes()


def test_the_figure_is_the_same_from_a_process_from_here_and_where_the_process_fails(
    run, tmp_path, monkeypatch
):
    beside = drawn(run, tmp_path / "process")
    monkeypatch.setattr(drawing.sys, "executable", "/bin/false")
    assert drawn(run, tmp_path / "failed") == beside
    monkeypatch.setattr(drawing, "cores", lambda: 1)
    monkeypatch.setattr(drawing.subprocess, "Popen", lambda *a, **k: pytest.fail("one core only"))
    assert drawn(run, tmp_path / "here") == beside


def test_what_is_begun_and_not_wanted_leaves_no_process_and_no_file(run, tmp_path, monkeypatch):
    started = []
    popen = drawing.subprocess.Popen
    monkeypatch.setattr(
        drawing.subprocess, "Popen", lambda *a, **k: started.append(popen(*a, **k)) or started[-1]
    )
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with contextlib.suppress(KeyboardInterrupt), drawing.ready() as draw:
        draw(run)
        raise KeyboardInterrupt
    assert started[0].poll() is not None
    assert not list(tmp_path.iterdir())
