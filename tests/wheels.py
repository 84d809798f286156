"""Robots' files from public wheels: downloaded by pip, taken apart, never imported."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import platformdirs

WHEELS = {
    "dm-control": ("1.0.50", "dm_control"),
    "example-robot-data": ("6.0.0", "cmeel.prefix/share/example-robot-data/robots"),
    "gym-aloha": ("0.1.5", "gym_aloha/assets"),
    "gymnasium-robotics": ("1.4.2", "gymnasium_robotics/envs"),
    "metaworld": ("3.1.1", "metaworld/assets"),
    "mjlab": ("1.6.0", "mjlab"),
    "robohive": ("0.7.0", "robohive/envs"),
    "robosuite": ("1.5.2", "robosuite/models/assets"),
}
"""Version of each wheel, and its folder of robots."""


@cache
def folder(name: str) -> Path:
    """Folder of a wheel's robots, in the user's cache; downloaded once, 1.2 GB in all."""
    version, robots = WHEELS[name]
    wheel = f"{name}=={version}"
    found = platformdirs.user_cache_path("resonance-mj") / "wheels" / wheel
    if found.is_dir():
        return found / robots
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
    return found / robots
