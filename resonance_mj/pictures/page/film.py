"""The film of a report: where something happens, at a length that is watched to its end."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import PictureError
from ...progress import Progress
from ...results.run import Run
from ..film import encoding, frame_data, video
from ..film.options import RenderOptions
from ..spans import spans

LEAST, MOST = 4.0, 12.0
"""How long a film lasts [s]: shorter ones run slower than the robot, longer ones faster."""
FPS = 20.0
SIZES = {1: (1280, 720), 2: (1440, 600), 3: (1800, 600)}
"""Width and height of the picture by the number of runs side by side [pixels]; no more fit."""


class Scene(NamedTuple):
    """A span of the runs, and where it begins in the film; all in seconds."""

    start: float
    stop: float
    at: float


@dataclass(frozen=True)
class Film:
    """A film that a page carries in itself.

    Attributes:
        runs: the runs side by side.
        labels: what the picture calls them.
        times: of the frames (F,) [s of the run].
        speed: seconds of the run per second of the film.
        scenes: the spans in a row.
        size: width and height [pixels].
        mp4: its file (H.264); empty until it is shot.
        poster: the picture that stands for it (JPEG); likewise.
    """

    runs: tuple[Run, ...]
    labels: tuple[str, ...]
    times: np.ndarray
    speed: float
    scenes: Sequence[Scene]
    size: tuple[int, int]
    mp4: bytes = b""
    poster: bytes = b""


def plan(runs: Sequence[Run], labels: Sequence[str]) -> Film:
    """Choose what is filmed of runs: the first three where there are more.

    Raises:
        PictureError: they have no samples at a time that they share.
    """
    shown = tuple(runs)[: max(SIZES)]
    shown_spans = spans(shown[0], frame_data.common_span(shown, None, None)[1])
    total = sum(stop - start for start, stop in shown_spans)
    speed = total / min(max(total, LEAST), MOST)
    times = np.empty(0)
    scenes: list[Scene] = []
    for start, stop in shown_spans:
        try:
            part = frame_data.times(shown, start, stop, speed / FPS, given=False)
        except PictureError:  # None of its cycles were kept in all runs.
            continue
        scenes.append(Scene(start, stop, len(times) / FPS))
        times = np.append(times, part)
    if not scenes:
        raise PictureError("the runs have no kept cycle in common")
    return Film(shown, tuple(labels)[: len(shown)], times, speed, scenes, SIZES[len(shown)])


def shoot(planned: Film, progress: Progress) -> Film:
    """Film what was planned.

    Raises:
        PictureError: there is no OpenGL to draw with.
        RobotError: the arm's MJCF is missing.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = video.film(
            planned.runs,
            Path(folder) / "film.mp4",
            planned.times,
            FPS,
            options=RenderOptions(size=planned.size),
            labels=planned.labels,
            progress=progress,
        )
        # Near the end: the springs have been found, and the strip below is drawn.
        poster = encoding.still(path, round(0.9 * (len(planned.times) - 1)))
        return replace(planned, mp4=path.read_bytes(), poster=poster)
