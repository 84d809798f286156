"""The film of a report: where something happens, at a length that is watched to its end."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from markupsafe import Markup

from ...errors import PictureError
from ...results.run import Run
from ..film import encoding, video
from ..film import shot as shots
from ..film.look import Look

CYCLES = 2
"""Cycles that are shown at the start, on either side of a change of motion, and at the end."""
LEAST, MOST = 4.0, 12.0
"""How long a film lasts [s]: shorter ones run slower than the robot, longer ones faster."""
FPS = 20.0
SIZES = {1: (1280, 720), 2: (1440, 600), 3: (1800, 600)}
"""Width and height of the picture by the number of runs side by side [pixels]; no more fit."""


@dataclass(frozen=True)
class Scene:
    """A span of the runs in a film."""

    start: float
    """[s of the run]"""
    stop: float
    """[s of the run]"""
    at: float
    """Where it begins in the film [s]."""


@dataclass(frozen=True)
class Plan:
    """What a film will show.

    Attributes:
        runs: the runs side by side.
        labels: what the picture calls them.
        times: of the frames (F,) [s of the run].
        speed: seconds of the run per second of the film.
        scenes: the spans in a row.
    """

    runs: tuple[Run, ...]
    labels: tuple[str, ...]
    times: np.ndarray
    speed: float
    scenes: tuple[Scene, ...]


@dataclass(frozen=True)
class Film:
    """A film that a page carries in itself.

    Attributes:
        plan: what it shows.
        mp4: its file (H.264), in base64.
        poster: the picture that stands for it (JPEG), in base64.
        size: width and height [pixels].
    """

    plan: Plan
    mp4: Markup
    poster: Markup
    size: tuple[int, int]


def plan(runs: Sequence[Run], labels: Sequence[str]) -> Plan:
    """Choose what is filmed of runs: the first three where there are more.

    Raises:
        PictureError: they have no samples at a time that they share.
    """
    shown = tuple(runs)[: max(SIZES)]
    _, end = shots.common_span(shown, None, None)
    spans = _spans(shown[0], end)
    total = sum(stop - start for start, stop in spans)
    speed = total / min(max(total, LEAST), MOST)
    parts: list[np.ndarray] = []
    scenes: list[Scene] = []
    for start, stop in spans:
        try:
            part = shots.times(shown, start, stop, speed / FPS, given=False)
        except PictureError:  # None of its cycles were kept in all runs.
            continue
        scenes.append(Scene(start, stop, sum(len(one) for one in parts) / FPS))
        parts.append(part)
    if not parts:
        raise PictureError("the runs have no kept cycle in common")
    return Plan(shown, tuple(labels)[: len(shown)], np.concatenate(parts), speed, tuple(scenes))


def shoot(planned: Plan, progress: video.Progress | None = None) -> Film:
    """Film what was planned.

    Raises:
        PictureError: there is no OpenGL to draw with.
        RobotError: the arm's MJCF is missing.
    """
    size = SIZES[len(planned.runs)]
    with tempfile.TemporaryDirectory() as folder:
        path = video.film(
            planned.runs,
            Path(folder) / "film.mp4",
            planned.times,
            FPS,
            look=Look(size=size),
            labels=planned.labels,
            progress=progress,
        )
        # Near the end: the springs have been found, and the strip below is drawn.
        poster = encoding.still(path, 0.9 * (len(planned.times) - 1) / FPS)
        return Film(planned, _base64(path.read_bytes()), _base64(poster), size)


def _spans(run: Run, end: float) -> list[tuple[float, float]]:
    """The start, either side of each change of motion, and the last cycles before `end` [s]."""
    wanted, begin = [], 0.0
    for motion in run.experiment.motion:
        stop = min(begin + motion.duration, end)
        length = CYCLES * motion.period
        wanted += [(begin, min(begin + length, stop)), (max(begin, stop - length), stop)]
        begin += motion.duration
        if begin >= end:
            break
    spans = wanted[:1]
    for start, stop in wanted[1:]:
        if start <= spans[-1][1] + 1e-9:
            spans[-1] = (spans[-1][0], max(stop, spans[-1][1]))
        else:
            spans.append((start, stop))
    return spans


def _base64(data: bytes) -> Markup:
    return Markup(base64.b64encode(data).decode("ascii"))
