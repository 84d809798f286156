"""Experiments from files, from built-in names, and for an arm with nothing else given."""

import os
from pathlib import Path
from typing import Any

from .. import library
from ..errors import ExperimentError
from ..files import is_file, is_folder, read_text
from ..text import listed, nearest, shown
from . import toml
from .experiment import Experiment
from .law_section import KINDS
from .sections import as_file
from .validation import NESTED, validated

ARMS = (".xml", ".urdf", ".mjz", ".zip", ".mjb")
"""Endings of the files of arms."""


def load(name: Any) -> Experiment:
    """Read an experiment, or make one for an arm with everything else found.

    Args:
        name: name of a built-in experiment, path of a TOML file; or of an arm, as for `for_robot`.

    Raises:
        ExperimentError: there is no such experiment, the file is not TOML, or a value in it is
            not valid.
    """
    arm = not isinstance(name, str | os.PathLike)
    if arm or str(name).startswith("menagerie:") or Path(name).suffix.lower() in ARMS:
        return for_robot(name)
    path = find(name)
    needed = f"give a TOML file or one of {listed(library.experiments())}"
    try:
        values = toml.parsed(read_text(path, needed=needed))
    except ValueError as error:
        raise ExperimentError(f"{path}: not valid TOML: {error}") from None
    except RecursionError:
        raise ExperimentError(f"{path}: {NESTED}") from None
    tables = [(values.get("robot"), "mjcf"), (values.get("law"), "kind")]
    motions = values.get("motion")
    tables += [(motion, "file") for motion in (motions if isinstance(motions, list) else ())]
    for table, key in tables:
        # A file that is named in an experiment is looked for beside it first.
        if isinstance(table, dict) and isinstance(given := table.get(key), str) and given:
            beside = path.parent / given
            named = key == "kind" and given in KINDS
            if not named and (is_file(beside) or (key == "mjcf" and is_folder(beside))):
                table[key] = str(beside.resolve())
    values.setdefault("name", path.stem)
    return validated(Experiment, values, str(path))


def for_robot(mjcf: Any) -> Experiment:
    """An experiment for an arm, with everything else found.

    Args:
        mjcf: path, name in mjcf/, menagerie:NAME, MjSpec or MjModel; the experiment takes its name
            from it.

    Raises:
        ExperimentError: it is none of these.
    """
    mjcf = as_file(mjcf)
    if not isinstance(mjcf, str | os.PathLike):
        raise ExperimentError(f"{shown(mjcf)} is no arm: give a path, an MjSpec or an MjModel")
    mjcf = os.fspath(mjcf)
    path = Path(mjcf)
    stem = path.parent.name if path.stem in ("robot", "scene", "model") else path.stem
    name = "".join(
        letter if (letter.isascii() and letter.isalnum()) or letter in "._-" else "-"
        for letter in stem
    )
    # A file that is here is meant before a robot of that name which comes with the program.
    meant = str(path.absolute()) if is_file(mjcf) else mjcf
    return validated(
        Experiment, {"name": name.strip("._-") or "arm", "robot": {"mjcf": meant}}, mjcf
    )


def find(name: str | os.PathLike[str]) -> Path:
    """The file of a built-in experiment's name, or of a path.

    Raises:
        ExperimentError: there is no such experiment.
    """
    built_in = library.experiments()
    named = built_in | library.validation()
    if isinstance(name, str) and name in named:
        return named[name]
    path = Path(name)
    if path.suffix == ".toml" or len(path.parts) != 1 or is_file(path):
        return path
    raise ExperimentError(
        f"no experiment is called {shown(str(name))}{nearest(str(name), built_in)}; "
        f"there are {listed(built_in)}, or give the path of a TOML file"
    )
