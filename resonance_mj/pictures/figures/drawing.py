"""The figure of a run drawn by a process of its own, which gets ready while the run is simulated.

`python -m resonance_mj.pictures.figures.drawing FOLDER` imports matplotlib, reads a pickled run
from its standard input and draws its figure into the folder.
"""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import TYPE_CHECKING

from ...files import replacing
from ...forking import cores
from .sizes import DRAFT

if TYPE_CHECKING:
    from ...results.run import Run

Draw = Callable[["Run"], Callable[[Path], list[Path]]]


@contextmanager
def ready() -> Iterator[Draw]:
    """A process that is ready to draw when a run ends.

    Yields:
        Begins to draw a run, and gives what ends it: that writes figure.svg and figure.png into a
        folder and returns their paths. Where the process could not, or where there is one core
        only, it draws here, which also says why.
    """
    if cores() < 2:
        yield lambda run: lambda folder: _draw_here(run, folder)
        return
    with TemporaryDirectory(prefix="resonance-mj-", ignore_cleanup_errors=True) as beside:
        process = subprocess.Popen(
            [sys.executable, "-m", __name__, beside],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            # Without threads of its own it can be forked, see `forking.meanwhile`.
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        )

        def draw(run: Run) -> Callable[[Path], list[Path]]:
            assert process.stdin is not None
            with suppress(BrokenPipeError):
                pickle.dump(run, process.stdin, protocol=pickle.HIGHEST_PROTOCOL)
                process.stdin.close()

            def finished(folder: Path) -> list[Path]:
                if process.wait() != 0:
                    return _draw_here(run, folder)
                return [_moved(drawn, folder) for drawn in sorted(Path(beside).iterdir())]

            return finished

        try:
            yield draw
        finally:
            process.kill()
            with suppress(BrokenPipeError):
                process.stdin.close()  # type: ignore[union-attr]
            process.wait()


def _draw_here(run: Run, folder: Path) -> list[Path]:
    overview, saving = _needed()
    return list(saving.save(overview.draw([run]), folder, "figure", dpi=DRAFT))


def _needed() -> tuple[ModuleType, ModuleType]:
    """What draws and what writes: imported when it is needed, as it takes matplotlib."""
    return import_module(".overview", __package__), import_module(".saving", __package__)


def _moved(drawn: Path, folder: Path) -> Path:
    path = folder / drawn.name
    with replacing(path) as beside:
        shutil.copyfile(drawn, beside)
    return path


if __name__ == "__main__":
    import_module("...results.run", __package__)
    _needed()
    _draw_here(pickle.load(sys.stdin.buffer), Path(sys.argv[1]))
    # Another process waits: it is not kept waiting until all modules are taken down.
    os._exit(0)
