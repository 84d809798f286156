"""Words in the picture: the line above the scene, and what the overlays mean at its foot."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

from ...springs.cost import KINDS
from ..palette import MEASURED, MOTOR, MUTED, SPRING_NEGATIVE, SPRING_POSITIVE, SPRING_ZERO
from .frame_data import FrameData
from .options import RenderOptions

# Matplotlib brings the fonts of the plots; it need not be imported for them.
_FONTS = Path(str(find_spec("matplotlib").origin)).parent / "mpl-data" / "fonts" / "ttf"  # type: ignore[union-attr]


class HeadUp:
    """Writes the line of a sample.

    Args:
        shown: what is filmed.
        options: its colours and height.
        width: of the picture [pixels].
    """

    def __init__(self, shown: FrameData, options: RenderOptions, width: int) -> None:
        self._shown, self._ink, self._paper = shown, options.ink, options.paper
        size = max(11, round(options.size[1] / 38))
        digits = len(str(shown.cycle[-1]))
        widest = fields(shown, int(np.searchsorted(shown.cycle, 10 ** (digits - 1))))
        while size > 8 and sum(_width(size, text) for text in widest) + size * 9 > width:
            size -= 1
        self._size, self._width = size, width
        self.height = round(1.9 * size)
        # Fields stand still while their numbers change.
        starts = np.cumsum([0.0] + [_width(size, text) + 1.6 * size for text in widest])
        self._starts = starts[:-1] + 0.6 * size

    def draw(self, picture: np.ndarray, sample: int) -> None:
        """Write a sample's line into the first rows of `picture` (·, width, 3 or 4)."""
        band = Image.new("RGB", (self._width, self.height), self._paper)
        pen = ImageDraw.Draw(band)
        words = fields(self._shown, sample)
        for index, (x, text) in enumerate(zip(self._starts, words, strict=True)):
            font = _font(self._size, bold=index == 0)
            pen.text((x, self.height / 2), text, fill=self._ink, font=font, anchor="lm")
        picture[: self.height, :, :3] = np.asarray(band)
        picture[: self.height, :, 3:] = 255


def fields(shown: FrameData, sample: int) -> list[str]:
    """What is said of a sample, in parts: run, time, cycle, torque, tracking."""
    reduction, best = shown.reduction[sample], shown.best[sample]
    what = f"motor {shown.cost}" if shown.cost == KINDS["torque-squared"].name else shown.cost
    found = "     –  " if np.isnan(reduction) else f"{-100 * reduction:+6.1f} %"
    return [
        shown.label,
        f"{shown.time[sample]:6.2f} s",
        f"cycle {shown.cycle[sample]:>3d}",
        # A minus as wide as a plus, so that lines stand still.
        f"{what} {found} (best {-100 * best:+.1f} %)".replace("-", "−"),
        f"tracking error {1e3 * shown.error(sample):6.2f} mm",
    ]


class Legend:
    """What the overlays mean, as a line at the foot of the scene.

    Args:
        options: which overlays there are.
        width: of the picture [pixels].
    """

    def __init__(self, options: RenderOptions, width: int) -> None:
        ink, ramp = options.ink, (SPRING_NEGATIVE, SPRING_ZERO, SPRING_POSITIVE)
        spring = "spring torque −, 0, +; thick: the stiffest, dashed: k < 0"
        there = (
            (options.path, (ink, "", ink), "desired path"),
            (options.trail, (MEASURED,), "tool"),
            (options.springs, ramp, spring),
            (options.springs, (ink,), "equilibrium"),
            (options.motors, (MOTOR,), "motor torque; 3/4 turn: the most without springs"),
        )
        items = [(colours, text) for wanted, colours, text in there if wanted and options.legend]

        def long(size: int) -> float:
            texts = ((len(colours), _font(size).getlength(text)) for colours, text in items)
            return sum(size * (0.7 * swatches + 1.8) + text for swatches, text in texts)

        size = max(8, round(options.size[1] / 52))
        while size > 8 and long(size) > width:
            size -= 1
        self.height = round(1.7 * size) if items else 0
        line = Image.new("RGBA", (width, self.height), (0, 0, 0, 0))
        pen, x, y = ImageDraw.Draw(line), 0.8 * size, self.height / 2
        paper = (*ImageColor.getrgb(options.paper), 175)
        pen.rectangle((0, 0, min(long(size), width), self.height), fill=paper)
        for colours, text in items:
            for shade in colours:
                if shade:
                    # The outline shows a swatch that is as bright as the paper.
                    edge = MUTED if shade == SPRING_ZERO else shade
                    box = (x, y - 0.2 * size, x + 0.7 * size, y + 0.2 * size)
                    pen.rectangle(box, fill=shade, outline=edge)
                x += 0.7 * size
            pen.text((x + 0.4 * size, y), text, ink, font=_font(size), anchor="lm")
            x += _font(size).getlength(text) + 1.8 * size
        drawn = np.asarray(line).astype(np.uint16)
        self._alpha = drawn[..., 3:]
        self._colour = drawn[..., :3] * self._alpha

    def draw(self, picture: np.ndarray) -> None:
        """Draw the line into the last rows of `picture` (·, width, 3 or 4)."""
        foot = picture[len(picture) - len(self._alpha) :]
        behind = foot[..., :3] * (255 - self._alpha)
        foot[..., :3] = (behind + self._colour) // 255
        np.maximum(foot[..., 3:], self._alpha.astype(np.uint8), out=foot[..., 3:])


@cache
def _font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(_FONTS / name), size)


def _width(size: int, text: str) -> float:
    return _font(size, bold=True).getlength(text)
