"""The lines of a video as images for the window: the one above, and what the overlays mean."""

import time
from dataclasses import replace

import mujoco
import numpy as np

from ..film.captions import HeadUp, Legend
from ..film.frame_data import FrameData
from ..film.options import RenderOptions, rgb

READABLE = 0.1
"""Time between changes of the line above [s]: numbers that change faster cannot be read."""

Image = tuple[mujoco.MjrRect, np.ndarray]
"""Where an image is in the window, and its pixels (height, width, 3)."""


class Captions:
    """Writes the lines when there is something new to read.

    Args:
        options: which of them there are, and their colours.
    """

    def __init__(self, options: RenderOptions) -> None:
        self._options = options
        self._shown: FrameData | None = None
        self._place: tuple[object, ...] = ()
        self._sample, self._since = -1, 0.0

    def images(
        self, shown: FrameData, label: str, sample: int, port: mujoco.MjrRect
    ) -> list[Image] | None:
        """The lines of a sample.

        Args:
            shown: what is shown.
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
        if place != self._place or shown is not self._shown:
            width, height = (min(max(edge, 160), 8192) for edge in (port.width, port.height))
            options = replace(self._options, size=(width, height))
            self._legend = Legend(options, port.width)
            self._head_up = HeadUp(replace(shown, label=label), options, port.width)
        self._shown, self._place, self._sample, self._since = shown, place, sample, now
        found = []
        if self._legend.height:
            foot = self._paper(self._legend.height, port.width)
            self._legend.draw(foot)
            found.append((mujoco.MjrRect(port.left, port.bottom, port.width, len(foot)), foot))
        if self._options.head_up:
            top = self._paper(self._head_up.height, port.width)
            self._head_up.draw(top, sample)
            bottom = port.bottom + port.height - len(top)
            found.append((mujoco.MjrRect(port.left, bottom, port.width, len(top)), top))
        return found

    def _paper(self, height: int, width: int) -> np.ndarray:
        colour = np.round(255 * np.array(rgb(self._options.paper))).astype(np.uint8)
        return np.tile(colour, (height, width, 1))
