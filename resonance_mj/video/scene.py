"""One run's part of the picture: the arm with its overlays, the line above and the strip below."""

from __future__ import annotations

import mujoco
import numpy as np

from . import camera, overlays, stage
from .captions import HeadUp, Legend
from .look import Look
from .overlays import Overlays, Scale
from .shot import Shot
from .strip import Strip

POSES = 24
"""Poses of a shot that are in the picture for certain."""


class Scene:
    """Draws the frames of a shot. It needs OpenGL: MUJOCO_GL is set when this is imported.

    Args:
        shot: what is filmed.
        look: how.
        scales: what full thickness, colour and length of the overlays stand for.
        strip: the plots below, if there are any.
        width: of this part of the picture [pixels].

    Raises:
        PictureError: the model has no such camera.
        RobotError: the arm's file is missing or MuJoCo rejects it.
    """

    def __init__(
        self, shot: Shot, look: Look, scales: Scale, strip: Strip | None, width: int
    ) -> None:
        self._shot, self._look, self._strip = shot, look, strip
        height = look.size[1] - look.strip_height
        rings = overlays.rings(shot, look)
        self.model, tool = stage.prepare(shot, look, rings, (width, height))
        self._site = int(self.model.site(tool).id)
        self._data = mujoco.MjData(self.model)
        ids = [self.model.joint(name).id for name in shot.joints]
        self._address = self.model.jnt_qposadr[ids]
        points, motion = self._points(ids)
        self._pose(int(shot.sample[0]))
        self._camera = camera.find(
            self.model, look, points, motion, self._data.xaxis[ids].copy(), width / height
        )
        self._overlays = Overlays(
            self.model, self._data, shot, look, scales, self._site, self._eye()
        )
        self._head_up = HeadUp(shot, look, width) if look.head_up else None
        self._legend = Legend(look, width)
        self._renderer = mujoco.Renderer(self.model, height, width)
        self._pixels = np.empty((height, width, 3), np.uint8)

    def draw(self, picture: np.ndarray, frame: int) -> None:
        """Draw a frame into `picture` (height, width, 3), or 4 with alpha."""
        data, height = self._data, len(self._pixels)
        sample = int(self._shot.sample[frame])
        self._pose(sample)
        if self._look.follow:
            self._camera.lookat[:] = data.site_xpos[self._site]
        self._overlays.update(data, frame, self._eye())
        self._renderer.update_scene(data, self._camera)
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
            self._head_up.draw(scene, frame)
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

    def _eye(self) -> np.ndarray:
        """Where the camera is (3,) [m]."""
        if self._camera.type == mujoco.mjtCamera.mjCAMERA_FIXED:
            return self._data.cam_xpos[self._camera.fixedcamid]
        forward = camera.directions(self._camera.azimuth, self._camera.elevation)[2]
        return self._camera.lookat - self._camera.distance * forward

    def _pose(self, sample: int) -> None:
        self._data.qpos[self._address] = self._shot.q[sample]
        mujoco.mj_kinematics(self.model, self._data)
        mujoco.mj_comPos(self.model, self._data)
        mujoco.mj_camlight(self.model, self._data)

    def _points(self, ids: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """What must be in the picture (P, 3), and where the tool is in some poses (T, 3) [m]."""
        joints, tool, bodies = [], [], []
        moves = self.model.body_weldid[self.model.geom_bodyid] > 0
        shown = np.flatnonzero(moves & (self.model.geom_rgba[:, 3] > 0))
        # The samples reach beyond the frames by a cycle: the whole path is in the picture.
        for q in self._shot.q[:: max(1, len(self._shot.q) // POSES)]:
            self._data.qpos[self._address] = q
            mujoco.mj_kinematics(self.model, self._data)
            joints.append(self._data.xanchor[ids])
            tool.append(self._data.site_xpos[self._site].copy())
            bodies.append(stage.corners(self.model, self._data, shown))
        wide = 1.5 * overlays.size(np.vstack([joints[0], tool[0]]))
        sides = wide * np.vstack([np.eye(3), -np.eye(3)])
        around = (np.concatenate(joints)[:, None] + sides).reshape(-1, 3)
        return np.concatenate([around, tool, *bodies]), np.array(tool)
