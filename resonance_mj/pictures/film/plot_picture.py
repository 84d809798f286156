"""The plots below the scene: drawn once, faint and in full, with a cursor that moves.

A frame takes what lies before the cursor from one drawing and what lies behind it from the other.
"""

from dataclasses import dataclass

import numpy as np

CURSOR = 2
"""Width of the cursor [pixels]."""


@dataclass(frozen=True)
class PlotPicture:
    """Two pictures (height, width, 3) of the same plots, and where time is in them.

    Attributes:
        before: what has been when the cursor is at the right end.
        after: the same, faint.
        panels: of each plot: top, bottom, left and right [pixels].
        span: times at the left and right ends of each plot [s].
        ink: colour of the cursor (3,).
    """

    before: np.ndarray
    after: np.ndarray
    panels: tuple[tuple[int, int, int, int], ...]
    span: tuple[float, float]
    ink: np.ndarray

    def draw(self, picture: np.ndarray, time: float) -> None:
        """Draw the plots at a time [s] into `picture` (height, width, 3 or 4)."""
        picture = picture[..., :3]
        picture[:] = self.after
        low, high = self.span
        for top, bottom, left, right in self.panels:
            x = left + round((right - left) * min(max((time - low) / (high - low), 0.0), 1.0))
            picture[top:bottom, left:x] = self.before[top:bottom, left:x]
            picture[top:bottom, max(x - CURSOR // 2, 0) : x + CURSOR // 2] = self.ink
