"""Robots' files from public wheels: downloaded by pip, taken apart, never imported."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import platformdirs

VERSIONS = {
    "dm-control": "1.0.50",
    "example-robot-data": "6.0.0",
    "gym-aloha": "0.1.5",
    "gymnasium-robotics": "1.4.2",
    "metaworld": "3.1.1",
    "mjlab": "1.6.0",
    "robohive": "0.7.0",
    "robosuite": "1.5.2",
}


@cache
def folder(name: str) -> Path:
    """Folder of what a wheel holds but for its Python, in the user's cache; downloaded once."""
    wheel = f"{name}=={VERSIONS[name]}"
    found = platformdirs.user_cache_path("resonance-mj") / "wheels" / wheel
    if found.is_dir():
        return found
    found.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=found.parent) as scratch:
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
        pip += ["--only-binary", ":all:", "--disable-pip-version-check"]
        subprocess.run([*pip, "--dest", scratch, wheel], check=True)
        (archive,) = Path(scratch).glob("*.whl")
        apart = Path(scratch) / "apart"
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(apart, [one for one in packed.namelist() if one[-3:] != ".py"])
        if not found.is_dir():  # another process may have been faster
            apart.rename(found)
    return found
