"""The files that a robot consists of: its MJCF, what it includes, and its meshes and textures."""

from __future__ import annotations

import hashlib
from pathlib import Path

import mujoco

ARCHIVES = (".zip", ".mjz", ".mjb")
"""Endings of files that hold a whole robot."""


def files(path: Path) -> list[Path]:
    """All files of a robot, absolute, the one that was named first.

    Args:
        path: of an MJCF, a URDF or an archive that MuJoCo reads.
    """
    path = path.absolute()
    if path.suffix.lower() in ARCHIVES:
        return [path]
    try:
        found = {Path(name).absolute() for name in mujoco.mju_getXMLDependencies(str(path))}
    except mujoco.FatalError:  # it is no XML, which whoever loads it says better
        found = set()
    return [path, *sorted(file for file in found - {path} if file.is_file())]


def digest(path: Path) -> str:
    """SHA-256 of all files of a robot, keyframes, includes and meshes among them."""
    found = hashlib.sha256()
    for file in files(path):
        content = file.read_bytes()
        found.update(f"{file.name}\0{len(content)}\0".encode() + content)
    return found.hexdigest()
