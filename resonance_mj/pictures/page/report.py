"""A run becomes a report: one HTML file that opens from disk, without a network."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import OutputError, PictureError, RobotError
from ...files import could_be_written, replacing, writable
from ...results.run import Run, versions
from ...text import told_apart
from . import film as films
from .comparing import differences
from .content import content
from .film import Film, Plan

if TYPE_CHECKING:
    from .page import Page

Progress = Callable[[int, int], None]
Given = Run | str | os.PathLike[str]
"""A run, or the folder that it was saved to."""


def report(
    run: Given | Sequence[Given],
    path: str | os.PathLike[str] | None = None,
    *,
    video: bool = True,
    title: str | None = None,
    labels: Sequence[str] | None = None,
    progress: Progress | None = None,
    note: Callable[[str], None] | None = None,
) -> Path:
    """Write a report of a run, or of two or more beside each other, as one HTML file.

    The file holds the film, the figures, the numbers beside the optimum's, the verdicts on what
    the experiment expects, the experiment itself, and how to run it again. It asks for nothing
    over a network.

    Args:
        run: the run or runs, or the folders that they were saved to.
        path: the file; report.html in the folder of the run, comparison.html in that of the first
            of several.
        video: whether to film the runs; it takes most of the time.
        title: of the page; the names of the runs if not given.
        labels: what the page calls each run; the experiments' names, and the keys that differ
            where these are alike.
        progress: is called with the number of pictures done and that of all.
        note: is called with each line that the user should know.

    Returns:
        The path of the report.

    Raises:
        OutputError: a folder does not hold a run, or the report cannot be written; then there is
            none.
    """
    given = [run] if isinstance(run, Run | str | os.PathLike) else list(run)
    if not given:
        raise OutputError("no run is given to report")
    folders = [None if isinstance(one, Run) else Path(one) for one in given]
    runs = [one if isinstance(one, Run) else Run.load(one) for one in given]
    path = _destination(path, folders)
    if labels is not None and len(labels) != len(runs):
        raise OutputError(f"{len(labels)} labels for {len(runs)} runs: give one each")
    names = labels or told_apart(
        [one.experiment.name for one in runs], [one.experiment.model_dump() for one in runs]
    )
    page = _page(runs, folders, names, title, video, progress, note or (lambda line: None))
    writable(path.parent)
    with replacing(path) as beside:
        beside.write_text(page.html(), encoding="utf-8")
    return path


def _destination(path: str | os.PathLike[str] | None, folders: list[Path | None]) -> Path:
    """Where the report goes; that it can be written is seen before the long work."""
    if path is None:
        if not folders or folders[0] is None:
            raise OutputError("a run that was not read from a folder: give the report a path")
        path = folders[0] / ("report.html" if len(folders) == 1 else "comparison.html")
    path = Path(path)
    could_be_written(path.parent)
    if path.is_dir():
        raise OutputError(f"{path}: is a folder; give the name of a file, as in {path}/report.html")
    return path


def _page(
    runs: list[Run],
    folders: list[Path | None],
    names: Sequence[str],
    title: str | None,
    video: bool,
    progress: Progress | None,
    note: Callable[[str], None],
) -> Page:
    from ..figures import catalogue
    from . import page

    alone = len(runs) == 1
    anchors = ["run"] if alone else [f"run{number}" for number in range(1, len(runs) + 1)]
    of_each = [catalogue.fitting([run]) for run in runs]
    of_all = [] if alone else [entry for entry in catalogue.fitting(runs) if entry.several]
    planned, film_note = _plan(runs, names) if video else (None, "")
    frames = len(planned.times) if planned else 0
    total = frames + len(of_all) + sum(map(len, of_each))
    done = 0

    def step() -> None:
        nonlocal done
        done += 1
        if progress:
            progress(done, total)

    film: Film | None = None
    if planned:
        try:
            film = films.shoot(planned, lambda *_: step())
        except (PictureError, RobotError) as error:
            film_note = f"No video: {error}"
            done = frames
    if film_note:
        note(film_note)
    parts = zip(of_each, runs, anchors, strict=True)
    return page.Page(
        title=title or " beside ".join(names),
        contents=tuple(content(*each) for each in zip(runs, names, anchors, folders, strict=True)),
        shared=page.figures(of_all, runs, "all", step),
        figures=tuple(page.figures(entries, [run], anchor, step) for entries, run, anchor in parts),
        differences=() if alone else tuple(differences(runs)),
        film=film,
        film_note=film_note,
        version=versions()["resonance-mj"],
    )


def _plan(runs: list[Run], names: Sequence[str]) -> tuple[Plan | None, str]:
    """What will be filmed, and what is to be said about it."""
    try:
        planned = films.plan(runs, names)
    except PictureError as error:
        return None, f"No video: {error}"
    left_out = names[len(planned.runs) :]
    said = f"The video shows the first {len(planned.runs)} runs, not {', '.join(left_out)}."
    return planned, said if left_out else ""
