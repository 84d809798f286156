"""Machine code kept on disk."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import resonance_mj as rmj
from resonance_mj.callback import callback, machine_code

PACKAGE = Path(rmj.__file__).parent
TEXT = "define i32 @answer() {\n  ret i32 42\n}\ndeclare void @never_called_and_nowhere()\n"


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(machine_code, "user_cache_path", lambda name: tmp_path / name)
    return tmp_path / "resonance-mj"


def answer(key, translate):
    return ctypes.CFUNCTYPE(ctypes.c_int)(machine_code.load(key, translate))()


def translated():
    return TEXT, "answer"


def not_needed():
    pytest.fail("the machine code is on disk")


def test_a_function_is_compiled_once_for_all_that_it_depends_on(cache):
    assert answer(b"one", translated) == 42
    assert answer(b"one", not_needed) == 42
    other = TEXT.replace("42", "43")
    assert answer(b"two", lambda: (other, "answer")) == 43
    assert len(list(cache.iterdir())) == 2


@pytest.mark.parametrize("kept", [0, 10, 0.5, -1])
def test_a_file_that_is_not_whole_is_written_again(cache, kept):
    assert answer(b"one", translated) == 42
    (file,) = cache.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole[: int(kept * len(whole)) if isinstance(kept, float) else kept])
    assert answer(b"one", translated) == 42
    assert file.read_bytes() == whole


@pytest.mark.parametrize("change", ["file", "folder", "link"])
def test_code_that_somebody_else_could_have_written_is_not_loaded(cache, change):
    assert answer(b"one", translated) == 42
    (file,) = cache.iterdir()
    if change == "link":
        file.rename(file.with_name("elsewhere"))
        file.symlink_to("elsewhere")
    else:
        (file if change == "file" else cache).chmod(0o666 if change == "file" else 0o777)
    other = TEXT.replace("42", "43")
    assert answer(b"one", lambda: (other, "answer")) == 43


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="gives a file away")
def test_code_of_another_user_is_not_loaded(cache):
    assert answer(b"one", translated) == 42
    (file,) = cache.iterdir()
    os.chown(file, 65534, 65534)
    other = TEXT.replace("42", "43")
    assert answer(b"one", lambda: (other, "answer")) == 43


def test_code_that_has_no_key_is_not_kept(cache):
    assert answer(None, translated) == 42
    assert not cache.exists()


def test_the_cache_keeps_the_newest(cache):
    for number in range(machine_code.KEPT + 3):
        answer(f"{number}".encode(), translated)
    assert len(list(cache.iterdir())) == machine_code.KEPT
    assert answer(f"{number}".encode(), not_needed) == 42


def test_without_a_folder_to_write_each_process_compiles(cache):
    cache.write_text("a file where the folder would be")
    assert answer(b"one", translated) == 42


@pytest.mark.slow
def test_that_the_law_cannot_be_kept_is_said_once_by_the_run_that_compiled_it(tmp_path):
    taken = tmp_path / "cache"
    taken.write_text("a file where the folder would be")
    code = (
        "import resonance_mj as rmj\n"
        "paper = rmj.load('paper')\n"
        "short = [paper.motion[0].model_dump() | {'duration': 1.0}]\n"
        "rmj.simulate(paper.replace({'motion': short, 'expect': {}}), note=print)"
    )
    said = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"XDG_CACHE_HOME": str(taken)},
    )
    (line,) = [line for line in said.stdout.splitlines() if "not kept" in line]
    assert "compiles it anew" in line
    assert str(taken) in line


def test_without_a_home_nothing_is_put_into_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(machine_code, "user_cache_path", lambda name: Path("~", ".cache", name))
    assert answer(b"one", translated) == 42
    assert not list(tmp_path.iterdir())


def test_a_run_with_its_law_on_disk_imports_no_compiler():
    code = (
        "import sys, resonance_mj as rmj\n"
        "paper = rmj.load('paper')\n"
        "short = [paper.motion[0].model_dump() | {'duration': 1.0}]\n"
        "rmj.simulate(paper.replace({'motion': short, 'expect': {}}))\n"
        "print('numba' in sys.modules)"
    )
    said = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert said[1].stdout.strip() == "False"


def test_the_law_allocates_nothing_so_that_it_runs_from_disk_without_numba(monkeypatch):
    """What allocates calls Numba's runtime, which a process that loads machine code has not."""
    needed = []
    define = machine_code._define_missing
    monkeypatch.setattr(
        machine_code, "_define_missing", lambda names: (needed.extend(names), define(names))
    )
    monkeypatch.setattr(callback, "_ready", {})
    monkeypatch.setattr(callback, "_compiled", callback._compiled.__wrapped__)
    paper = rmj.load("paper")
    short = [paper.motion[0].model_dump(exclude_none=True) | {"duration": 1.0}]
    rmj.simulate(paper.replace({"motion": short, "expect": {}}))
    assert "mj_jacSite" in needed
    assert [name for name in needed if name.startswith("NRT_MemInfo") and "new" in name] == []


EDITED = """
import sys
from pathlib import Path
from resonance_mj.callback import callback
from resonance_mj.laws import equations, memory
from resonance_mj.laws.controller import standard

for module in (equations, memory):
    file = Path(module.__file__)
    file.write_text(file.read_text() + "# edited\\n")
    text = callback._sources(standard)
    assert b"# edited" not in text
    assert b"def " in text
"""


def test_a_file_that_is_edited_after_it_was_imported_is_not_what_is_compiled(tmp_path):
    """Else a process that runs old code would put it on disk as the machine code of the new."""
    shutil.copytree(PACKAGE, tmp_path / "resonance_mj", ignore=shutil.ignore_patterns("runs"))
    done = subprocess.run(
        [sys.executable, "-c", EDITED], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
