"""One run's part of the picture: the arm with its overlays, the line above and the plots below."""

import mujoco
import numpy as np

from .captions import HeadUp, Legend
from .frame_data import FrameData
from .options import RenderOptions
from .overlays import Scale
from .plot_picture import PlotPicture
from .render_model import RenderModel


class FrameRenderer:
    """Draws the frames of a run. It needs OpenGL: MUJOCO_GL is set when this is imported.

    Args:
        shown: what is filmed.
        model: its arm, from `render_model.prepare`.
        tool: name of the tool's site in it.
        options: how.
        scales: what full thickness, colour and length of the overlays stand for.
        plots: the plots below, if there are any.
        width: of this part of the picture [pixels].

    Raises:
        PictureError: the model has no such camera.
    """

    def __init__(
        self,
        shown: FrameData,
        model: mujoco.MjModel,
        tool: str,
        options: RenderOptions,
        scales: Scale,
        plots: PlotPicture | None,
        width: int,
    ) -> None:
        self._shown, self._options, self._plots = shown, options, plots
        height = options.size[1] - options.plots_height
        self._render_model = RenderModel(shown, options, model, tool)
        self._camera = self._render_model.camera(width / height)
        self._overlays = self._render_model.overlays(scales, self._render_model.eye(self._camera))
        self._head_up = HeadUp(shown, options, width) if options.head_up else None
        self._legend = Legend(options, width)
        self._renderer = mujoco.Renderer(self._render_model.model, height, width)
        self._pixels = np.empty((height, width, 3), np.uint8)

    def draw(self, picture: np.ndarray, frame: int) -> None:
        """Draw a frame into `picture` (height, width, 3), or 4 with alpha."""
        render_model, height = self._render_model, len(self._pixels)
        sample = int(self._shown.sample[frame])
        render_model.pose(self._shown.q[sample])
        if self._options.follow:
            self._camera.lookat[:] = render_model.data.site_xpos[render_model.site]
        self._overlays.update(render_model.data, sample, render_model.eye(self._camera))
        self._renderer.update_scene(render_model.data, self._camera)
        drawn = self._renderer.scene
        for geom in drawn.geoms[: drawn.ngeom]:
            if geom.type == mujoco.mjtGeom.mjGEOM_SKIN:
                # Decoration casts no shadow.
                geom.category = int(mujoco.mjtCatBit.mjCAT_DECOR)
        self._renderer.render(out=self._pixels)
        scene, below = picture[:height], picture[height:]
        scene[..., :3] = self._pixels
        if picture.shape[2] == 4:
            below[..., 3], scene[..., 3] = 255, self._opaque()
        self._legend.draw(scene)
        if self._head_up:
            self._head_up.draw(scene, sample)
        if self._plots:
            self._plots.draw(below, float(self._shown.time[sample]))

    def close(self) -> None:
        """Give the graphics memory back."""
        self._renderer.close()

    def _opaque(self) -> np.ndarray:
        """255 where the scene just drawn shows something, else 0 (height, width)."""
        self._renderer.enable_segmentation_rendering()
        shown = self._renderer.render()[..., 0] >= 0
        self._renderer.disable_segmentation_rendering()
        return np.where(shown, 255, 0).astype(np.uint8)
