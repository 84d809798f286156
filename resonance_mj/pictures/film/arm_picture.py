"""A picture of an arm: its chain with the best springs, its tool and the suggested motion."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import PictureError
from ...files import could_be_replaced, write
from ...plan.plan import Plan
from . import crew
from .frame_data import planned
from .options import RenderOptions

FORMATS = (".png", ".jpg", ".webp")


def draw_arm(
    plan: Plan,
    path: str | os.PathLike[str],
    options: RenderOptions | None = None,
    note: Callable[[str], None] = lambda line: None,
) -> Path:
    """Draw an arm a quarter into the first cycle of its motion, with the best springs.

    Args:
        plan: of an experiment with the arm.
        path: the picture: .png, .jpg or .webp.
        options: size, camera, background and what is drawn; without plots and head-up line.
        note: is called with each line that the user should know.

    Returns:
        The path of the picture.

    Raises:
        PictureError: the format is none of these, or there is no OpenGL to draw with.
        OutputError: the file cannot be written.
    """
    import imageio.v3 as iio

    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise PictureError(
            f"{path}: unknown format {path.suffix!r}; the name must end in {', '.join(FORMATS)}"
        )
    could_be_replaced(path)
    options = replace(options or RenderOptions(), plots=False, head_up=False)
    shown, best = planned(plan, plan.experiment.motion[0].cycles - 1), plan.optima[0]
    steps, n = shown.q.shape
    shown = replace(
        shown,
        sample=np.array([steps // 4]),
        tau=best.torque,
        stiffness=np.broadcast_to(best.stiffness, (steps, n)),
        offset=np.broadcast_to(best.offset, (steps, n)),
        center=np.broadcast_to(best.center, (steps, n)),
    )
    with crew.drawn((shown,), (None,), options, 1, note) as frames:
        pixels = np.frombuffer(next(frames), np.uint8).reshape(*options.size[::-1], -1)
        content = iio.imwrite("<bytes>", pixels, extension=path.suffix.lower())
    write(path.parent, {path.name: content})
    return path
