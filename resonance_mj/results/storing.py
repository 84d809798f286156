"""A run as files: run.nc is the run; the files beside it are for people and for repeating it."""

from __future__ import annotations

import hashlib
import json
import os
import threading
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import h5py
import numpy as np
import xarray as xr
from pydantic import BaseModel, Json

from ..errors import OutputError
from ..experiments.experiment import Experiment
from ..experiments.validation import validated
from ..files import regular, write
from ..plan.inputs import Input, folder_name
from ..status import Status
from ..text import listed
from . import schema

if TYPE_CHECKING:
    from .run import Run

SEAL = b"\nresonance-mj run, SHA-256 of all before this line: "
"""What stands before the digest at the end of run.nc. HDF5 reads no farther than its own end."""

ATTRIBUTES = ("units", "long_name")
"""Of each variable."""


_one_at_a_time = threading.Lock()
"""Held while HDF5 is written or read: what stands on it is not made for threads."""


class _About(BaseModel):
    """What run.nc says of a run besides its variables."""

    experiment: str
    status: Status
    message: str
    notes: Json[tuple[str, ...]]
    versions: Json[dict[str, str]]
    steps: int
    simulation_wall_s: float
    inputs: Json[tuple[Input, ...]]
    found: Json[dict[str, Any]] = {}  # runs of earlier versions do not say
    thinned: int


def load(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Read what a run's folder holds: the fields of `Run`; see `Run.load`."""
    path = Path(folder) / "run.nc"
    try:
        with regular(path) as file:
            size = _checked(file)
            with _one_at_a_time, h5py.File(file) as hdf5:
                about, data = _about(hdf5), _variables(hdf5, size)
        schema.check(data)
        experiment = validated(Experiment, tomllib.loads(about.experiment), "its experiment")
        schema.check_cost(data, experiment.springs.cost)
    except (FileNotFoundError, NotADirectoryError):
        raise OutputError(f"{folder}: holds no run: there is no {path.name} in it") from None
    except OutputError as error:
        raise OutputError(f"{path}: {error}") from None
    except Exception as error:  # HDF5 and what reads it raise any for a file that is not as it was
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"{path}: cannot be read: {reason}") from None
    inputs = tuple(one._replace(path=Path(folder).absolute() / one.path) for one in about.inputs)
    for one in inputs:
        if one.path.is_file() and not one.unchanged:
            raise OutputError(f"{one.path}: was changed since the run was saved; give it back")
    return about.model_dump(exclude={"thinned"}) | {
        "experiment": experiment.replace({one.key: str(one.path) for one in inputs if one.key}),
        "inputs": inputs,
        "data": data.assign_attrs(thinned=about.thinned),
    }


def _checked(file: BinaryIO) -> int:
    """Bytes of a file's HDF5 part, after which stands their digest; refused if it is another."""
    size = file.seek(0, os.SEEK_END) - len(_seal(b""))
    file.seek(max(size, 0))
    end = file.read()
    if not end.startswith(SEAL):
        raise OutputError(
            "is cut off, or no run, or one of an earlier version; simulate its experiment again"
        )
    file.seek(0)
    digest = hashlib.sha256()
    while size > file.tell():
        digest.update(file.read(min(size - file.tell(), 1 << 20)))
    if end != SEAL + digest.hexdigest().encode() + b"\n":
        raise OutputError(
            "is damaged, or was changed after it was saved; simulate its experiment again"
        )
    return size


def _variables(hdf5: h5py.File, size: int) -> xr.Dataset:
    """The variables of a file, whose data must be in its `size` bytes."""
    items = {name: hdf5[name] for name in hdf5}
    for name, item in items.items():
        inside = isinstance(hdf5.get(name, getlink=True), h5py.HardLink) and not (
            isinstance(item, h5py.Dataset) and (item.external or item.is_virtual)
        )
        if not (inside and isinstance(item, h5py.Dataset)):
            raise OutputError(f"{name} is no variable in this file")
    items = {name: item for name, item in items.items() if not _length_alone(item)}
    if sum(item.size * item.dtype.itemsize for item in items.values()) > size:
        raise OutputError("its variables are larger than the file is")
    data = xr.Dataset({name: _variable(name, item) for name, item in items.items()})
    return data.set_coords([name for name in schema.COORDINATES if name in data])


def _length_alone(item: h5py.Dataset) -> bool:
    """Whether an item is the length of a dimension without coordinates, which holds no numbers."""
    return bytes(item.attrs.get("NAME", b"")).startswith(b"This is a netCDF dimension but not")


def _variable(name: str, item: h5py.Dataset) -> tuple[list[str], np.ndarray, dict[str, Any]]:
    named = [next((scale.name for scale in axis.values()), "?") for axis in item.dims]
    dims = [name] if item.is_scale else [scale.strip("/") for scale in named]
    text = h5py.check_string_dtype(item.dtype)
    values = item.asstr()[...].astype(str) if text else item[...]
    return dims, values, {key: item.attrs[key] for key in ATTRIBUTES if key in item.attrs}


def _about(hdf5: h5py.File) -> _About:
    """What the attributes say."""
    given = {name: hdf5.attrs[name] for name in _About.model_fields if name in hdf5.attrs}
    said = {name: np.asarray(value).item() for name, value in given.items()}
    return validated(_About, said, "its attributes")


def save(run: Run, folder: str | os.PathLike[str]) -> Path:
    """Write a run; see `Run.save`."""
    # Copies are made of what was run: not of a file that has changed meanwhile.
    kept, changed = run.inputs, [str(one.path) for one in run.inputs if not one.unchanged]
    if changed:
        said = f"no copies of its files are kept: {listed(changed)} changed since it was simulated"
        kept, run = (), replace(run, notes=(*run.notes, said))
    within = folder_name(kept)
    inputs = [one._replace(path=Path(within, one.name)) for one in kept]
    paths = {one.key: one.path.as_posix() for one in inputs if one.key}
    text = run.experiment.replace(paths).to_toml()
    made, open_keys = run.planned, run.found
    if made is not None:
        from ..plan.filling import found  # imports MuJoCo, which reading a run does not need

        open_keys = found(made.experiment, made.robot, made.gains)
    content = _netcdf(
        run,
        experiment=text,
        inputs=json.dumps([(*one[:1], str(one[1]), *one[2:]) for one in inputs]),
        found=json.dumps(open_keys),
    )
    made_by = "".join(f"# {name} {number}\n" for name, number in run.versions.items())
    return write(
        folder,
        {f"{within}/{one.name}": one.path.read_bytes() for one in kept}
        | {
            "summary.json": (json.dumps(run.summary(), indent=2, allow_nan=False) + "\n").encode(),
            "experiment.toml": (
                "# The experiment as it was run, with every default and all that was found filled "
                f"in.\n{made_by}\n{run.experiment.replace({**paths, **open_keys}).to_toml()}"
            ).encode(),
            "run.nc": content + _seal(content),
        },
        replaces=("inputs-*", "figure.svg", "figure.png"),
    )


def _netcdf(run: Run, **texts: str) -> bytes:
    data = run.data.assign_attrs(
        title=f"resonance-mj run {run.experiment.name}",
        status=str(run.status),
        message=run.message,
        notes=json.dumps(run.notes),
        versions=json.dumps(run.versions),
        steps=run.steps,
        simulation_wall_s=run.simulation_wall_s,
        **texts,
    )
    # In memory: HDF5 takes the process with it where a file cannot be closed, on a full disk.
    with _one_at_a_time:
        return bytes(data.to_netcdf(engine="h5netcdf"))


def _seal(content: bytes) -> bytes:
    """What stands at the end of a file with this content."""
    return SEAL + hashlib.sha256(content).hexdigest().encode() + b"\n"
