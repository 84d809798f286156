"""A URDF with its visuals, and with its packages found where ROS would find them."""

import os
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from ..errors import RobotError
from ..files import is_folder
from ..text import listed, shown

READABLE = (".stl", ".obj", ".msh")
"""Endings of meshes that MuJoCo reads."""

IN_PACKAGE = re.compile(r"(?:package|model):/+([^/]+)/(.+)")

_SIX = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

ROS_PATH = "ROS_PACKAGE_PATH"
"""The environment variable that lists folders of packages."""


def is_urdf(path: Path) -> bool:
    """Whether a file is a URDF by its name."""
    return path.suffix.lower() == ".urdf"


def read(path: Path, packages: tuple[str, ...], notes: list[str]) -> mujoco.MjSpec:
    """A URDF as an editable model with its visuals, which have no mass and touch nothing.

    Visuals whose mesh is missing, and all whose mesh is of a kind that MuJoCo lacks, are left out.

    Args:
        path: of the URDF.
        packages: folders in which its packages are looked for, before its own and ROS's.
        notes: get a line of meshes that are left out though bodies could touch them.

    Raises:
        RobotError: a given folder, or the package of a mesh that bodies can touch, is not there.
    """
    for folder in packages:
        if not is_folder(folder):
            raise RobotError(f"robot.packages = {shown(folder)}: no such folder")
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError:  # MuJoCo takes what other readers do not, as unbound prefixes
        return mujoco.MjSpec.from_file(str(path.absolute()))
    compiler = _child(_child(root, "mujoco"), "compiler")
    compiler.set("discardvisual", "false")
    beside = path.absolute().parent / compiler.get("meshdir", "")
    folders: dict[str, list[Path]] = {}
    untouched = []
    for link in root.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            for mesh in shape.iter("mesh"):
                given = mesh.get("filename", "")
                file = _found(given, path, packages, folders)
                if file is not None:
                    mesh.set("filename", str(file))
                elif shape.tag == "collision" and IN_PACKAGE.match(given):
                    raise RobotError(
                        f"{path}: mesh {shown(given)}: no such package is found: give the folder "
                        f"that holds it as robot.packages, or in {ROS_PATH}"
                    )
                file = beside / mesh.get("filename", "")
                readable = file.suffix.lower() in READABLE
                if shape.tag == "collision" and not readable:
                    untouched.append(file.name)
                if not readable or (shape.tag == "visual" and not file.is_file()):
                    link.remove(shape)
    moved = {
        str(child.get("link"))
        for joint in root.iter("joint")
        if joint.get("type") != "fixed"
        for child in joint.findall("child")
    }
    made = [str(link.get("name")) for link in root.iter("link") if _made_possible(link, moved)]
    if made:
        notes.append(
            f"no body has such inertias, the nearest possible are taken: {listed(made, most=8)}"
        )
    if untouched:
        notes.append(
            "bodies do not touch where MuJoCo cannot read the mesh: "
            f"{listed(sorted({*untouched}), most=8)}"
        )
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    spec.modelfiledir = f"{path.absolute().parent}{os.sep}"
    return spec


def _made_possible(link: ElementTree.Element, moved: set[str]) -> bool:
    """Whether a link had an inertia that no body can have, and has the nearest possible now.

    None at all is possible for what is fixed to another link.
    """
    inertia, mass = link.find("inertial/inertia"), link.find("inertial/mass")
    try:
        kilograms = float("nan" if mass is None else mass.get("value", "nan"))
        six = [float("nan" if inertia is None else inertia.get(key, "0")) for key in _SIX]
    except ValueError:  # which MuJoCo says better
        return False
    if inertia is None or not kilograms > 0 or not np.isfinite(six).all():
        return False
    if not any(six) and link.get("name") not in moved:
        return False
    xx, xy, xz, yy, yz, zz = six
    moments, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    least = 1e-6 * max(moments[2], kilograms * 1e-3)
    possible = np.maximum(moments, least)
    possible[:2] += max(0.0, possible[2] - possible[0] - possible[1]) * 0.5000001
    if (possible <= moments).all():
        return False
    whole = axes @ np.diag(possible) @ axes.T
    for key, value in zip(_SIX, whole[np.triu_indices(3)], strict=True):
        inertia.set(key, repr(float(value)))
    return True


def _child(parent: ElementTree.Element, tag: str) -> ElementTree.Element:
    """The first child of a tag, made where there is none."""
    found = parent.find(tag)
    return ElementTree.SubElement(parent, tag) if found is None else found


def _found(
    given: str, path: Path, packages: tuple[str, ...], folders: dict[str, list[Path]]
) -> Path | None:
    """Where a file is that is named by its package or as an address; None for another name."""
    if given.startswith("file://"):
        return Path(given.removeprefix("file://"))
    named = IN_PACKAGE.match(given)
    if named is None:
        return None
    package, rest = named.groups()
    if package not in folders:
        folders[package] = list(_folders(package, path, packages))
    return next((it / rest for it in folders[package] if (it / rest).is_file()), None)


def _folders(package: str, path: Path, packages: tuple[str, ...]) -> Iterator[Path]:
    """Folders that may be a package, the likeliest first."""
    own = path.absolute().parents
    ros = [Path(one) for one in os.environ.get(ROS_PATH, "").split(os.pathsep) if one]
    for folder in (*map(Path, packages), *own, *ros):
        if folder.name == package or _name(folder) == package:
            yield folder
        yield folder / package
    for folder in (*map(Path, packages), *ros):
        yield from folder.glob(f"*/{package}")
    yield from own  # a package in a folder of another name


def _name(folder: Path) -> str | None:
    """The name that a package in a folder gives itself."""
    try:
        return ElementTree.parse(folder / "package.xml").getroot().findtext("name")
    except (OSError, ElementTree.ParseError):
        return None
