"""A user's files: read with a limit, and refused in one line that says why."""

import os

import pytest

import resonance_mj as rmj
from resonance_mj import files
from resonance_mj.errors import OutputError
from resonance_mj.files import LARGEST, read_text


def test_a_text_is_read_with_or_without_a_byte_order_mark(tmp_path):
    (tmp_path / "plain").write_bytes("τ = 1\r\n".encode())
    (tmp_path / "marked").write_bytes(b"\xef\xbb\xbf" + "τ = 1\r\n".encode())
    assert read_text(tmp_path / "plain") == read_text(tmp_path / "marked") == "τ = 1\r\n"


def pipe(path):
    os.mkfifo(path)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: None, "does not exist"),
        (lambda path: path.mkdir(), "is a folder"),
        (pipe, "is a device or a pipe"),
        (lambda path: path.symlink_to("/dev/zero"), "is a device or a pipe"),
        (lambda path: path.symlink_to(path), "symbolic links"),
        (lambda path: path.write_bytes(b"x" * (LARGEST + 1)), "is longer than 4 MB"),
        (lambda path: path.write_text("x", "utf-16"), "byte 1 is not UTF-8"),
    ],
)
def test_what_is_no_small_regular_text_is_refused_in_one_line(make, words, tmp_path):
    path = tmp_path / "file"
    make(path)
    with pytest.raises(rmj.ResonanceError, match=words) as caught:
        read_text(path, needed="give a TOML file")
    assert str(caught.value).startswith(f"{path}: ")
    assert str(caught.value).endswith("; give a TOML file")


@pytest.mark.parametrize("name", ["a" * 5000, "a" * 300, "nul\0byte", "\ud800", "", "a\nb"])
def test_a_name_that_no_file_can_have_is_refused_in_one_short_line(name):
    with pytest.raises(rmj.ResonanceError) as caught:
        read_text(name)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


def test_a_pipe_or_a_device_is_never_replaced_by_a_file(tmp_path):
    path = tmp_path / "pipe.html"
    pipe(path)
    with pytest.raises(OutputError, match="is no regular file"):
        files.could_be_replaced(path)
    with pytest.raises(OutputError, match="is no regular file"), files.replacing(path):
        pytest.fail("nothing is to be written")
    assert path.is_fifo()
    assert list(tmp_path.iterdir()) == [path]
