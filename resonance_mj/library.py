"""The robots and experiments that come with the package."""

import re
from pathlib import Path

_PACKAGE = Path(__file__).parent


def folder(name: str) -> Path:
    """Folder of the files that come with the package: `mjcf` or `runs`.

    It is inside the package in a wheel, and beside it in a checkout.
    """
    inside = _PACKAGE / name
    return inside if inside.is_dir() else _PACKAGE.parent / name


def experiments() -> dict[str, Path]:
    """Built-in experiments: name -> TOML file, in alphabetical order."""
    files = folder("runs").glob("*.toml")
    return {path.stem: path for path in sorted(files, key=lambda path: path.stem)}


def validation() -> dict[str, Path]:
    """Arms and springs that others have published: name -> TOML file, in alphabetical order."""
    return {path.stem: path for path in sorted(folder("runs").glob("validation/*.toml"))}


def sweeps() -> dict[str, Path]:
    """Built-in sweeps: name -> TOML file, in alphabetical order."""
    return {path.stem: path for path in sorted(folder("runs").glob("sweeps/*.toml"))}


def robots() -> dict[str, Path]:
    """Built-in robots: file name -> MJCF file, in alphabetical order."""
    return {path.name: path for path in sorted(folder("mjcf").glob("*.xml"))}


def line(path: Path) -> str:
    """What a built-in robot or experiment is: the first sentence of its file's first comment."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".xml":
        comment = text[text.index("<!--") + 4 : text.index("-->")]
    else:
        lines = text.splitlines()
        comment = " ".join(part.removeprefix("#") for part in lines if part.startswith("#"))
    sentence = " ".join(comment.split())
    return re.split(r"(?<!Sec)[.](?: |$)", sentence)[0] + "."
