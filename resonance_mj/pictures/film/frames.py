"""One run's part of the picture: the arm with its overlays, the line above and the plots below."""

from dataclasses import dataclass

import mujoco
import numpy as np

from .captions import HeadUp, Legend
from .frame_data import FrameData, Scale
from .options import RenderOptions
from .overlays import Overlays
from .render_model import RenderModel
from .surroundings import HORIZON

FADES = 1.7, 7.0
"""Where the floor begins to fade and where it has, as multiples of the arm's distance."""


@dataclass(frozen=True)
class PlotPicture:
    """Two pictures (height, width, 3) of the same plots, and where time is in them.

    A frame takes what lies before a cursor from one and what lies behind it from the other.

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
            picture[top:bottom, max(x - 1, 0) : x + 1] = self.ink


@dataclass(frozen=True)
class Part:
    """A run's part of the picture.

    Attributes:
        shown: what is filmed.
        model: its arm, from `surroundings.prepare`.
        tool: name of the tool's site in it.
        scale: what full thickness, colour and length of the overlays stand for.
        plots: the plots below, if there are any.
        left: the first of its columns of the picture.
        right: the last, exclusive.
    """

    shown: FrameData
    model: mujoco.MjModel
    tool: str
    scale: Scale
    plots: PlotPicture | None
    left: int
    right: int


class FrameRenderer:
    """Draws the frames of a run. It needs OpenGL: MUJOCO_GL is set when this is imported.

    Raises:
        PictureError: the model has no such camera.
    """

    def __init__(self, part: Part, options: RenderOptions) -> None:
        self._part, width = part, part.right - part.left
        height = options.size[1] - options.plots_height
        arm = RenderModel(part.shown, options, part.model, part.tool)
        self._data, self._camera = arm.data, arm.camera(width / height)
        self._overlays = Overlays(arm, self._camera)
        self._head_up = HeadUp(part.shown, options, width) if options.head_up else None
        self._legend = Legend(options, width)
        fades = options.background == "sky"
        if fades:  # as the renderer's context has it from its beginning
            away = float(np.linalg.norm(arm.eye(self._camera) - self._camera.lookat))
            _fade(arm.model, away)
        self._renderer = mujoco.Renderer(arm.model, height, width)
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = fades
        self._pixels = np.empty((height, width, 3), np.uint8)

    def draw(self, whole: np.ndarray, frame: int) -> None:
        """Draw a frame into its columns of the picture (height, width, 3), or 4 with alpha."""
        part, height = self._part, len(self._pixels)
        picture, shown = whole[:, part.left : part.right], part.shown
        sample = int(shown.sample[frame])
        self._overlays.show(shown, sample, part.scale, self._camera)
        for _ in range(2):  # an endless floor is laid beneath where the scene's camera was before
            self._renderer.update_scene(self._data, self._camera)
        drawn = self._renderer.scene
        for geom in drawn.geoms[: drawn.ngeom]:
            if geom.type == mujoco.mjtGeom.mjGEOM_SKIN:
                # Decoration casts no shadow.
                geom.category = int(mujoco.mjtCatBit.mjCAT_DECOR)
        self._renderer.render(out=self._pixels)
        scene, below = picture[:height], picture[height:]
        scene[..., :3] = self._pixels
        if picture.shape[2] == 4:
            self._renderer.enable_segmentation_rendering()
            below[..., 3] = 255
            scene[..., 3] = np.where(self._renderer.render()[..., 0] >= 0, 255, 0)
            self._renderer.disable_segmentation_rendering()
        self._legend.draw(scene)
        if self._head_up:
            self._head_up.draw(scene, sample)
        if part.plots:
            part.plots.draw(below, float(shown.time[sample]))


def _fade(model: mujoco.MjModel, distance: float) -> None:
    """Let what is far behind the arm, which is at a distance [m], fade into the horizon."""
    fog = model.vis.map
    fog.fogstart, fog.fogend = (far * distance / model.stat.extent for far in FADES)
    model.vis.rgba.fog[:] = [*HORIZON, 1.0]
