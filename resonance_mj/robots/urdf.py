"""The visuals of a URDF, which MuJoCo leaves out where the file does not ask for them."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

import mujoco

READABLE = (".stl", ".obj", ".msh")
"""Endings of meshes that MuJoCo reads."""


def is_urdf(path: Path) -> bool:
    """Whether a file is a URDF by its name."""
    return path.suffix.lower() == ".urdf"


def with_visuals(path: Path, without: mujoco.MjSpec) -> mujoco.MjSpec:
    """A URDF with its visuals, but for those whose mesh is missing or of a kind MuJoCo lacks.

    They have no mass and touch nothing.

    Args:
        path: of the URDF.
        without: what MuJoCo makes of it, returned where MuJoCo alone can read its XML.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError:
        return without
    settings = root.find("mujoco")
    if settings is None:
        settings = ElementTree.SubElement(root, "mujoco")
    compiler = settings.find("compiler")
    if compiler is None:
        compiler = ElementTree.SubElement(settings, "compiler")
    compiler.set("discardvisual", "false")
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    spec.modelfiledir = f"{path.absolute().parent}{os.sep}"
    folder = path.absolute().parent / spec.compiler.meshdir
    unseen = {
        mesh.name
        for mesh in spec.meshes
        if Path(mesh.file).suffix.lower() not in READABLE or not (folder / mesh.file).is_file()
    }
    for geom in spec.geoms:
        if geom.meshname in unseen and not geom.contype:
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in spec.meshes:
        if mesh.name in unseen - used:
            spec.delete(mesh)
    return spec
