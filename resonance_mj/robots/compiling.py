"""A file is parsed and compiled, with MuJoCo's own message and the file in the error."""

import warnings
from pathlib import Path

import mujoco

from ..errors import RobotError
from ..turns import compiling
from . import names, urdf, warned
from .decompiling import spec_of

COMPILED = ".mjb"
"""Ending of a file that holds a compiled model."""


def parse(
    path: Path,
    packages: tuple[str, ...] = (),
    notes: list[str] | None = None,
    *,
    visuals: bool = True,
) -> mujoco.MjSpec:
    """A file as an editable model, in which every joint, body and site has a name.

    Args:
        path: of the file.
        packages: folders in which the packages of a URDF are looked for.
        notes: get lines of what is left out of a URDF.
        visuals: whether what is only seen is kept; it is where MuJoCo needs it for inertias.

    Raises:
        RobotError: MuJoCo rejects the file.
    """
    try:
        # From a relative path it does not find meshes that lie beside a file that is included.
        if urdf.is_urdf(path):
            spec = urdf.read(path, packages, [] if notes is None else notes)
        elif path.suffix == COMPILED:
            spec = spec_of(mujoco.MjModel.from_binary_path(str(path)), str(path))
        else:
            spec = mujoco.MjSpec.from_file(str(path.absolute()))
    except (ValueError, mujoco.FatalError) as error:
        raise RobotError(rejected(path, error)) from None
    # Bodies that are fused would lose their names, and the others their numbers; a payload's body
    # must not be made one with the tool's.
    spec.compiler.fusestatic = False
    needed = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    spec.compiler.discardvisual = not (visuals or needed)
    names.name_all(spec.joints, "joint")
    names.name_all(spec.bodies, "body")
    names.name_all(spec.sites, "site")
    return spec


def compile_spec(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    """Compile, with MuJoCo's own message and the file in the error; its warnings are heard.

    Raises:
        RobotError: MuJoCo rejects the model.
    """
    # What Python warns of is recorded for the whole process: one thread at a time.
    with compiling, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            model = spec.compile()
        except (ValueError, mujoco.FatalError) as error:
            raise RobotError(rejected(path, error)) from None
    for one in said:
        warned.hear(str(one.message))
    return model


def rejected(path: Path, error: Exception) -> str:
    """What to say of a file that MuJoCo rejects."""
    return f"{path}: MuJoCo rejects it: {' '.join(str(error).split())}"
