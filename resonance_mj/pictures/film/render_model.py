"""The arm as pictures show it: its model in its surroundings, its pose, the camera."""

from collections.abc import Callable

import mujoco
import numpy as np

from . import camera, overlays, surroundings
from .frame_data import FrameData
from .options import RenderOptions
from .overlays import Overlays, Scale

POSES = 24
"""Poses that are in the picture for certain."""


def prepare(
    shown: FrameData, options: RenderOptions, size: tuple[int, int], note: Callable[[str], None]
) -> tuple[mujoco.MjModel, str]:
    """The model of a `RenderModel`, and the name of the tool's site in it.

    Args:
        shown: what is shown.
        options: how.
        size: width and height that are rendered [pixels].
        note: is called with each line that the user should know.

    Raises:
        RobotError: the arm's file is missing or MuJoCo rejects it.
    """
    return surroundings.add(shown, options, overlays.rings(shown, options), size, note)


class RenderModel:
    """A copy of the arm's model with light, floor and overlays, and the arm's pose in it.

    Args:
        shown: what is shown.
        options: how.
        model: the arm with light, floor and overlays, from `prepare`.
        tool: name of the tool's site in it.

    Attributes:
        model: as given.
        data: the arm's pose; at first that of the first frame.
        site: id of the tool's site.
    """

    def __init__(
        self, shown: FrameData, options: RenderOptions, model: mujoco.MjModel, tool: str
    ) -> None:
        self._shown, self._options, self.model = shown, options, model
        self.site = int(self.model.site(tool).id)
        self.data = mujoco.MjData(self.model)
        self._ids = [self.model.joint(name).id for name in shown.joints]
        self._address = self.model.jnt_qposadr[self._ids]
        self._points, self._motion = self._in_the_picture()
        self.pose(shown.q[shown.sample[0]])

    def pose(self, q: np.ndarray) -> None:
        """Bring the arm to joint angles (n,) [rad]."""
        self.data.qpos[self._address] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def camera(self, aspect: float) -> mujoco.MjvCamera:
        """The camera that the options ask for, in a picture so many times as wide as it is high.

        Raises:
            PictureError: the model has no such camera.
        """
        axes = self.data.xaxis[self._ids].copy()
        return camera.find(self.model, self._options, self._points, self._motion, axes, aspect)

    def eye(self, seen: mujoco.MjvCamera) -> np.ndarray:
        """Where a camera is (3,) [m]."""
        if seen.type == mujoco.mjtCamera.mjCAMERA_FIXED:
            return self.data.cam_xpos[seen.fixedcamid]
        forward = camera.directions(seen.azimuth, seen.elevation)[2]
        return seen.lookat - seen.distance * forward

    def overlays(self, scales: Scale, eye: np.ndarray) -> Overlays:
        """The overlays, for a camera that is at `eye` (3,) [m]."""
        return Overlays(self.model, self.data, self._shown, self._options, scales, self.site, eye)

    def _in_the_picture(self) -> tuple[np.ndarray, np.ndarray]:
        """What must be in the picture (P, 3), and where the tool is in some poses (T, 3) [m]."""
        joints, tool, bodies = [], [], []
        moves = self.model.body_weldid[self.model.geom_bodyid] > 0
        seen = np.flatnonzero(moves & (self.model.geom_rgba[:, 3] > 0))
        # The samples reach beyond the frames by a cycle: the whole path is in the picture.
        for q in self._shown.q[:: max(1, len(self._shown.q) // POSES)]:
            self.data.qpos[self._address] = q
            mujoco.mj_kinematics(self.model, self.data)
            joints.append(self.data.xanchor[self._ids])
            tool.append(self.data.site_xpos[self.site].copy())
            bodies.append(surroundings.corners(self.model, self.data, seen))
        wide = 1.5 * overlays.size(np.vstack([joints[0], tool[0]]))
        sides = wide * np.vstack([np.eye(3), -np.eye(3)])
        around = (np.concatenate(joints)[:, None] + sides).reshape(-1, 3)
        return np.concatenate([around, tool, *bodies]), np.array(tool)
