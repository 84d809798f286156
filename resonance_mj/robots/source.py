"""The files that a robot consists of: its MJCF, what it includes, and its meshes and textures."""

import os
import zipfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import mujoco

from ..errors import RobotError
from ..files import regular
from ..text import cut
from .compiling import COMPILED, compile_spec, parse
from .urdf import is_urdf
from .warned import heard

ARCHIVES = (".mjz", ".zip")
"""Endings of archives that MuJoCo reads a whole robot from, in memory."""

XML = (".xml", ".urdf")

LARGEST = 512_000_000
"""Bytes that the files of an archive may have together."""


def files(path: Path, packages: tuple[str, ...] = ()) -> list[Path]:
    """All files of a robot, absolute, the one that was named first.

    Args:
        path: of an MJCF, a URDF or an archive that MuJoCo reads.
        packages: folders in which the packages of a URDF are looked for.

    Raises:
        RobotError: MuJoCo rejects it.
    """
    path = Path(os.path.normpath(path.absolute()))
    named = _named(path)
    if is_urdf(path) or not all(file.is_file() for file in named):
        # MuJoCo names no mesh of a URDF, and a wrong place where paths are stripped or meshes lie
        # beside a file that is included: where they were read, the model knows.
        with heard():
            read = compile_spec(parse(path, packages), path).paths.decode(
                "utf-8", "surrogateescape"
            )
        named |= {Path(os.path.normpath(name)) for name in read.split("\0") if name}
    return [path, *sorted(file for file in named - {path} if file.is_file())]


def robots_in(folder: Path) -> list[Path]:
    """The robots of a folder: the one that is called as it is, else all that no other includes.

    A scene around a robot is none.
    """
    endings = (*XML, *ARCHIVES, COMPILED)
    found = sorted(file for file in folder.iterdir() if file.suffix.lower() in endings)
    named = [file for file in found if file.stem in (folder.resolve().name, "robot", "model")]
    alone = [file for file in found if not file.stem.startswith("scene")] or found
    parts = {part for file in alone for part in _named(file.absolute()) - {file.absolute()}}
    return named[:1] or [file for file in alone if file.absolute() not in parts]


def texts(path: Path) -> Iterator[tuple[str, bytes]]:
    """Of each XML file of a robot, how a message names it and its content.

    Raises:
        RobotError: an archive is damaged, or its files are too large.
    """
    if path.suffix in ARCHIVES:
        yield from _archived_texts(path)
        return
    if path.suffix == COMPILED:
        return
    for file in sorted(_named(path)):
        if file.suffix in XML or file == path:
            # Of what cannot be opened MuJoCo says it.
            with suppress(OSError), regular(file) as opened:
                yield str(file), opened.read()


def _archived_texts(path: Path) -> Iterator[tuple[str, bytes]]:
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            if size > LARGEST:
                raise RobotError(
                    f"{path}: holds {size / 1e6:.0f} MB; {LARGEST / 1e6:.0f} are valid"
                )
            for name in archive.namelist():
                if name.endswith(XML):
                    yield f"{path}/{name}", archive.read(name)
    except RobotError:
        raise
    except Exception as error:  # zipfile and what unpacks for it raise any for a damaged archive
        raise RobotError(f"{path}: is no archive that can be read: {cut(str(error))}") from None


def _named(path: Path) -> set[Path]:
    """A file and those that it, or one of them, refers to by name."""
    if path.suffix in (*ARCHIVES, COMPILED):
        return {path}
    try:
        return {Path(os.path.normpath(name)) for name in mujoco.mju_getXMLDependencies(str(path))}
    except mujoco.FatalError:  # it is no XML, which MuJoCo says better when it reads it
        return {path}
