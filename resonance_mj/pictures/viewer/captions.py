"""The lines of a video as images for the window: the one above, and what the overlays mean."""

from __future__ import annotations

import time
from dataclasses import replace

import mujoco
import numpy as np

from ..film.captions import HeadUp, Legend
from ..film.look import Look, rgb
from ..film.shot import Shot

READABLE = 0.1
"""Time between changes of the line above [s]: numbers that change faster cannot be read."""

Image = tuple[mujoco.MjrRect, np.ndarray]
"""Where an image is in the window, and its pixels (height, width, 3)."""


class Captions:
    """Writes the lines when there is something new to read.

    Args:
        look: which of them there are, and their colours.
    """

    def __init__(self, look: Look) -> None:
        self._look = look
        self._shot: Shot | None = None
        self._place: tuple[object, ...] = ()
        self._sample, self._since = -1, 0.0

    def images(
        self, shot: Shot, label: str, sample: int, port: mujoco.MjrRect
    ) -> list[Image] | None:
        """The lines of a sample.

        Args:
            shot: what is shown.
            label: what the line above calls it.
            sample: the number of the sample.
            port: the part of the window that they are for.

        Returns:
            The lines; None while those from before can stay.
        """
        place = (label, port.left, port.bottom, port.width, port.height)
        now = time.perf_counter()
        if place == self._place and (sample == self._sample or now < self._since + READABLE):
            return None
        if place != self._place or shot is not self._shot:
            width, height = (min(max(edge, 160), 8192) for edge in (port.width, port.height))
            look = replace(self._look, size=(width, height))
            self._legend = Legend(look, port.width)
            self._head_up = HeadUp(replace(shot, label=label), look, port.width)
        self._shot, self._place, self._sample, self._since = shot, place, sample, now
        found = []
        if self._legend.height:
            foot = self._paper(self._legend.height, port.width)
            self._legend.draw(foot)
            found.append((mujoco.MjrRect(port.left, port.bottom, port.width, len(foot)), foot))
        if self._look.head_up:
            top = self._paper(self._head_up.height, port.width)
            self._head_up.draw(top, sample)
            bottom = port.bottom + port.height - len(top)
            found.append((mujoco.MjrRect(port.left, bottom, port.width, len(top)), top))
        return found

    def _paper(self, height: int, width: int) -> np.ndarray:
        colour = np.round(255 * np.array(rgb(self._look.paper))).astype(np.uint8)
        return np.tile(colour, (height, width, 1))
