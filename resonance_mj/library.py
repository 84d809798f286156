"""The robots and experiments that come with the package."""

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
    return {path.stem: path for path in sorted(folder("runs").glob("*.toml"))}


def robots() -> dict[str, Path]:
    """Built-in robots: file name -> MJCF file, in alphabetical order."""
    return {path.name: path for path in sorted(folder("mjcf").glob("*.xml"))}
