"""The line above the scene: run, time, cycle, reduction and tracking error."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from .look import Look
from .shot import Shot


class HeadUp:
    """Writes the line of a shot.

    Args:
        shot: what is filmed.
        look: its colours and height.
        width: of the picture [pixels].
    """

    def __init__(self, shot: Shot, look: Look, width: int) -> None:
        self._shot, self._ink, self._paper = shot, look.ink, look.paper
        size = max(11, round(look.size[1] / 38))
        widest = self._fields(int(np.argmax(np.char.str_len(shot.cycle.astype(str)))))
        while size > 8 and sum(_width(size, text) for text in widest) + size * 9 > width:
            size -= 1
        self._size, self._width = size, width
        self.height = round(1.9 * size)
        # Fields stand still while their numbers change.
        starts = np.cumsum([0.0] + [_width(size, text) + 1.6 * size for text in widest])
        self._starts = starts[:-1] + 0.6 * size

    def draw(self, picture: np.ndarray, frame: int) -> None:
        """Write a frame's line into the first rows of `picture` (·, width, 3)."""
        band = Image.new("RGB", (self._width, self.height), self._paper)
        pen = ImageDraw.Draw(band)
        fields = self._fields(int(self._shot.sample[frame]))
        for index, (x, text) in enumerate(zip(self._starts, fields, strict=True)):
            font = _font(self._size, bold=index == 0)
            pen.text((x, self.height / 2), text, fill=self._ink, font=font, anchor="lm")
        picture[: self.height] = np.asarray(band)

    def _fields(self, sample: int) -> list[str]:
        shot = self._shot
        reduction, best = shot.reduction[sample], shot.best[sample]
        found = "     –  " if np.isnan(reduction) else f"{-100 * reduction:+6.1f} %"
        return [
            shot.label,
            f"{shot.time[sample]:6.2f} s",
            f"cycle {shot.cycle[sample]:>3d}",
            f"motor torque² {found} (best {-100 * best:+.1f} %)",
            f"tracking error {1e3 * shot.error[sample]:6.2f} mm",
        ]


@cache
def _font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path(), "fonts", "ttf", name)), size)


def _width(size: int, text: str) -> float:
    return _font(size, bold=True).getlength(text.replace("-", "+"))
