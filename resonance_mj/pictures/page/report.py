"""A run becomes a report: one HTML file that opens from disk, without a network."""

import os
from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path

from ...errors import OutputError, PictureError, RobotError
from ...files import could_be_replaced, replacing, writable
from ...progress import Asked, Progress, progressing
from ...results.run import Run
from ...sweeps.dataset import WHOLE, opened
from ...text import told_apart
from ..figures import catalogue
from ..figures.catalogue import Entry
from . import film as films
from . import sweep_page
from .content import Content, Figures, differences
from .page import html, inline
from .scene import Shown, scene

Given = Run | str | os.PathLike[str]
"""A run, or the folder that it was saved to."""


def report(
    run: Given | Sequence[Given],
    path: str | os.PathLike[str] | None = None,
    *,
    video: bool = True,
    title: str | None = None,
    labels: Sequence[str] | None = None,
    progress: Asked = None,
    note: Callable[[str], None] | None = None,
) -> Path:
    """Write a report of a run, or of two or more beside each other, as one HTML file.

    The file holds the motion of a run as a scene to turn and scrub, the film, the figures, the
    numbers beside the optimum's, the verdicts on what the experiment expects, the experiment
    itself, and how to run it again. It asks for nothing over a network, and names no folder of this
    machine.

    Args:
        run: the run or runs, or the folders that they were saved to; or that of a sweep.
        path: the file; report.html in the folder of the run, comparison.html in that of the first
            of several.
        video: whether to film the runs; it takes most of the time.
        title: of the page; the names of the runs if not given.
        labels: what the page calls each run; the experiments' names, and the keys that differ
            where these are alike.
        progress: is called with the number of pictures done and that of all; a bar in a terminal or
            a notebook if not given, nothing for False.
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
    alone = len(given) == 1
    sweep = next((one for one in folders if one and (one / WHOLE).is_file()), None)
    if sweep and not alone:
        raise OutputError(f"{sweep}: is a sweep; a sweep has a report of its own")
    if path is None:
        if folders[0] is None:
            raise OutputError("a run that was not read from a folder: give the report a path")
        path = folders[0] / ("report.html" if alone else "comparison.html")
    path = could_be_replaced(Path(path))  # seen before the long work
    if sweep:
        with progressing(progress, path.name, "pictures") as show:
            return _written(sweep_page.page(sweep, opened(sweep / WHOLE), title, show), path)
    runs = [one if isinstance(one, Run) else Run.load(one) for one in given]
    if labels is not None and len(labels) != len(runs):
        raise OutputError(f"{len(labels)} labels for {len(runs)} runs: give one each")
    names = labels or told_apart(
        [one.experiment.name for one in runs], [one.experiment.model_dump() for one in runs]
    )
    note = note or (lambda line: None)
    with progressing(progress, path.name, "pictures") as show:
        page = _page(runs, folders, names, title, video, show, note)
    return _written(page, path)


def _written(page: str, path: Path) -> Path:
    writable(path.parent)
    with replacing(path) as beside:
        beside.write_text(page, encoding="utf-8")
    return path


def _page(
    runs: Sequence[Run],
    folders: Sequence[Path | None],
    names: Sequence[str],
    title: str | None,
    video: bool,
    progress: Progress,
    note: Callable[[str], None],
) -> str:
    """The page as text; arguments as of `report`, all given."""
    alone = len(runs) == 1
    of_each = [catalogue.fitting([one]) for one in runs]
    of_all = [] if alone else [entry for entry in catalogue.fitting(runs) if entry.several]
    figures, frames = len(of_all) + sum(map(len, of_each)), 0
    film, said = None, ""
    if video:
        film, said, frames = _filmed(runs, names, lambda done, of: progress(done, of + figures))
    turned, lacks = _scene(runs, names, note) if alone else (None, "")
    done = count(frames + 1)

    def drawn(entries: Sequence[Entry], some: Sequence[Run], anchor: str) -> Figures:
        found = []
        for entry in entries:
            found.append((entry, inline(entry, some, anchor)))
            progress(next(done), frames + figures)
        return found

    anchors = ["run"] if alone else [f"run{number}" for number in range(1, len(runs) + 1)]
    contents = [
        Content(one, name, anchor, folder, drawn(entries, [one], anchor))
        for one, name, anchor, folder, entries in zip(
            runs, names, anchors, folders, of_each, strict=True
        )
    ]
    page = html(
        title=title or " beside ".join(names),
        contents=contents,
        shared=drawn(of_all, runs, "all"),
        differences={} if alone else differences(runs),
        film=film,
        film_note=said,
        scene=turned,
    )
    if said := said or lacks:  # what hinders the one hinders the other
        note(said)
    return page


def _scene(
    runs: Sequence[Run], names: Sequence[str], note: Callable[[str], None]
) -> tuple[Shown | None, str]:
    """A run as a scene to turn, or None; and why there is none."""
    try:
        return scene(films.plan(runs, names), note), ""
    except (PictureError, RobotError) as error:
        return None, f"No scene: {error}"


def _filmed(
    runs: Sequence[Run], names: Sequence[str], progress: Progress
) -> tuple[films.Film | None, str, int]:
    """The film of runs, or None; what is said of it; and the frames that were planned."""
    frames = 0
    try:
        film = films.plan(runs, names)
        frames = len(film.times)
        film = films.shoot(film, progress)
    except (PictureError, RobotError) as error:
        return None, f"No video: {error}", frames
    left_out = ", ".join(names[len(film.runs) :])
    said = f"The video shows the first {len(film.runs)} runs, not {left_out}."
    return film, said * bool(left_out), frames
