"""One run's part of the picture: the arm with its overlays, the line above and the strip below."""

from __future__ import annotations

import mujoco
import numpy as np

from . import camera, overlays, stage
from .head_up import HeadUp
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
        points = self._points(ids)
        self._pose(int(shot.sample[0]))
        self._camera = camera.find(
            self.model, look, points, self._data.xaxis[ids].copy(), width / height
        )
        eye = -camera.directions(self._camera.azimuth, self._camera.elevation)[2]
        if self._camera.type == mujoco.mjtCamera.mjCAMERA_FIXED:
            eye = self._data.cam_xmat[self._camera.fixedcamid].reshape(3, 3)[:, 2].copy()
        self._overlays = Overlays(self.model, self._data, shot, look, scales, self._site, eye)
        self._head_up = HeadUp(shot, look, width) if look.head_up else None
        self._renderer = mujoco.Renderer(self.model, height, width)
        self._pixels = np.empty((height, width, 3), np.uint8)

    def draw(self, picture: np.ndarray, frame: int) -> None:
        """Draw a frame into `picture` (height, width, 3)."""
        data, height = self._data, len(self._pixels)
        sample = int(self._shot.sample[frame])
        self._pose(sample)
        self._overlays.update(data, frame)
        if self._look.follow:
            self._camera.lookat[:] = data.site_xpos[self._site]
        self._renderer.update_scene(data, self._camera)
        self._renderer.render(out=self._pixels)
        picture[:height] = self._pixels
        if self._head_up:
            self._head_up.draw(picture, frame)
        if self._strip:
            self._strip.draw(picture[height:], float(self._shot.time[sample]))

    def close(self) -> None:
        """Give the graphics memory back."""
        self._renderer.close()

    def _pose(self, sample: int) -> None:
        self._data.qpos[self._address] = self._shot.q[sample]
        mujoco.mj_kinematics(self.model, self._data)
        mujoco.mj_comPos(self.model, self._data)
        mujoco.mj_camlight(self.model, self._data)

    def _points(self, ids: list[int]) -> np.ndarray:
        """What must be in the picture (P, 3) [m]: joints and tool in some poses."""
        found = []
        for sample in self._shot.sample[:: max(1, len(self._shot.sample) // POSES)]:
            self._pose(int(sample))
            found += [self._data.xanchor[ids], self._data.site_xpos[[self._site]]]
        points = np.concatenate(found)
        # Links and springs are wider than the line through the joints.
        wide = 0.08 * np.ptp(points, axis=0).max() * np.vstack([np.eye(3), -np.eye(3)])
        return (points[:, None] + wide).reshape(-1, 3)
