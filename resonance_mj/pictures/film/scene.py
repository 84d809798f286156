"""One run's part of the picture: the arm with its overlays, the line above and the strip below."""

from __future__ import annotations

import mujoco
import numpy as np

from .captions import HeadUp, Legend
from .look import Look
from .overlays import Scale
from .setting import Setting
from .shot import Shot
from .strip import Strip


class Scene:
    """Draws the frames of a shot. It needs OpenGL: MUJOCO_GL is set when this is imported.

    Args:
        shot: what is filmed.
        model: its arm, from `setting.prepare`.
        tool: name of the tool's site in it.
        look: how.
        scales: what full thickness, colour and length of the overlays stand for.
        strip: the plots below, if there are any.
        width: of this part of the picture [pixels].

    Raises:
        PictureError: the model has no such camera.
    """

    def __init__(
        self,
        shot: Shot,
        model: mujoco.MjModel,
        tool: str,
        look: Look,
        scales: Scale,
        strip: Strip | None,
        width: int,
    ) -> None:
        self._shot, self._look, self._strip = shot, look, strip
        height = look.size[1] - look.strip_height
        self._setting = Setting(shot, look, model, tool)
        self._camera = self._setting.camera(width / height)
        self._overlays = self._setting.overlays(scales, self._setting.eye(self._camera))
        self._head_up = HeadUp(shot, look, width) if look.head_up else None
        self._legend = Legend(look, width)
        self._renderer = mujoco.Renderer(self._setting.model, height, width)
        self._pixels = np.empty((height, width, 3), np.uint8)

    def draw(self, picture: np.ndarray, frame: int) -> None:
        """Draw a frame into `picture` (height, width, 3), or 4 with alpha."""
        setting, height = self._setting, len(self._pixels)
        sample = int(self._shot.sample[frame])
        setting.pose(self._shot.q[sample])
        if self._look.follow:
            self._camera.lookat[:] = setting.data.site_xpos[setting.site]
        self._overlays.update(setting.data, sample, setting.eye(self._camera))
        self._renderer.update_scene(setting.data, self._camera)
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
        if self._strip:
            self._strip.draw(below, float(self._shot.time[sample]))

    def close(self) -> None:
        """Give the graphics memory back."""
        self._renderer.close()

    def _opaque(self) -> np.ndarray:
        """255 where the scene just drawn shows something, else 0 (height, width)."""
        self._renderer.enable_segmentation_rendering()
        shown = self._renderer.render()[..., 0] >= 0
        self._renderer.disable_segmentation_rendering()
        return np.where(shown, 255, 0).astype(np.uint8)
