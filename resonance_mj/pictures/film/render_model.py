"""The arm as pictures show it: its pose, and where it is looked at from."""

import mujoco
import numpy as np

from ...errors import PictureError
from ...robots.couplings import Followers
from .frame_data import FrameData
from .options import RenderOptions
from .surroundings import corners, in_poses, size

POSES = 24
"""Poses that are in the picture for certain."""
MARGIN = 1.12
"""How much larger than the motion the picture is."""
ABOVE = 1.1
"""The same in height alone, where there is a line of text above."""


class RenderModel:
    """A copy of the arm's model with light, floor and overlays, and the arm's pose in it.

    Args:
        shown: what is shown.
        options: how.
        model: the arm in its surroundings, from `surroundings.prepare`.
        tool: name of the tool's site in it.

    Attributes:
        shown, options, model: as given.
        data: the arm's pose; at first that of the first frame.
        ids: of the arm's joints (n).
        address: of each in qpos (n,).
        followers: the joints that are coupled to them.
        site: id of the tool's site.
    """

    def __init__(
        self, shown: FrameData, options: RenderOptions, model: mujoco.MjModel, tool: str
    ) -> None:
        self.shown, self.options = shown, options
        self.model, self.data = model, mujoco.MjData(model)
        self.site = int(model.site(tool).id)
        self.ids = [model.joint(name).id for name in shown.joints]
        self.address, self.followers = model.jnt_qposadr[self.ids], Followers(model, self.ids)
        anchors, bodies = [], []
        moves = model.body_weldid[model.geom_bodyid] > 0
        seen = np.flatnonzero(moves & (model.geom_rgba[:, 3] > 0))
        # The samples reach beyond the frames by a cycle: the whole path is in the picture.
        poses = shown.q[:: max(1, len(shown.q) // POSES)]
        for data in in_poses(model, shown.joints, poses):
            anchors.append(self.anchors(data))
            bodies.append(corners(model, data, seen))
        places, wide = np.array(anchors), 1.5 * size(anchors[0])
        around = places[:, :-1, None] + wide * np.vstack([np.eye(3), -np.eye(3)])
        self._motion = places[:, -1]
        self._in_the_picture = np.concatenate([around.reshape(-1, 3), self._motion, *bodies])
        self.pose(shown.q[shown.sample[0]])

    def anchors(self, data: mujoco.MjData) -> np.ndarray:
        """Where the joints and the tool are in a pose of the model (n + 1, 3) [m]."""
        return np.array([*data.xanchor[self.ids], data.site_xpos[self.site]])

    def pose(self, q: np.ndarray) -> None:
        """Bring the arm to joint angles (n,) [rad]."""
        self.data.qpos[self.address] = q
        self.followers.place(self.data.qpos)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def camera(self, aspect: float) -> mujoco.MjvCamera:
        """The camera that the options ask for: one of the model, or a free one.

        Args:
            aspect: width of the picture by its height.

        Raises:
            PictureError: the model has no camera of that name.
        """
        camera, options = mujoco.MjvCamera(), self.options
        view = options.view
        if options.camera is not None and view is None:
            names = [self.model.camera(i).name for i in range(self.model.ncam)]
            if options.camera not in names:
                known = ", ".join(name for name in names if name) or "none"
                raise PictureError(
                    f"the model has no camera {options.camera!r}; its cameras are: {known}; or "
                    "give azimuth,elevation,distance, as in --camera=120,-20,1.5 [degrees, "
                    "degrees, m]"
                )
            camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
            camera.fixedcamid = names.index(options.camera)
            return camera
        camera.azimuth, camera.elevation = view[:2] if view else self._direction()
        axes = _directions(camera.azimuth, camera.elevation)
        seen = self._in_the_picture @ np.stack(axes, axis=1)
        low, high = seen.min(axis=0), seen.max(axis=0)
        middle, half = (low + high) / 2, (high - low) / 2
        slope = np.tan(np.radians(self.model.vis.global_.fovy) / 2)
        above = ABOVE if options.head_up else 1.0
        near = MARGIN * max(half[1] * above / slope, half[0] / (slope * aspect))
        camera.distance = view[2] if view else max(near + half[2], 1e-3)
        middle[1] += (above - 1) * half[1]
        right, up, forward = axes
        camera.lookat[:] = middle[0] * right + middle[1] * up + middle[2] * forward
        if options.follow and view is None:
            camera.distance *= 0.6
        return camera

    def eye(self, camera: mujoco.MjvCamera) -> np.ndarray:
        """Where a camera is (3,) [m]."""
        if camera.type == mujoco.mjtCamera.mjCAMERA_FIXED:
            return self.data.cam_xpos[camera.fixedcamid]
        forward = _directions(camera.azimuth, camera.elevation)[2]
        return camera.lookat - camera.distance * forward

    def _direction(self) -> tuple[float, float]:
        """Azimuth and elevation [degrees]: along a planar arm's axes, else where most is seen."""
        axes = self.data.xaxis[self.ids]
        planar = bool((np.abs(axes @ axes[0]) > 0.999).all())
        if planar and abs(axes[0][2]) < 0.5:
            along = axes[0] if axes[0][1] > 0 else -axes[0]
            return float(np.degrees(np.arctan2(along[1], along[0]))) + 12.0, -10.0
        elevation = -24.0

        def seen(azimuth: float) -> float:
            """How large the arm's spread and the tool's motion look."""
            across = np.stack(_directions(azimuth, elevation)[:2], axis=1)
            arm, tool = (_spread(some @ across) for some in (self._in_the_picture, self._motion))
            return float(np.prod(arm) * np.sqrt(tool.sum()))

        # From behind the same is seen: the side with the x axis to the right is taken.
        return float(max(np.arange(15.0, 180.0, 15.0), key=seen)), elevation


def _directions(azimuth: float, elevation: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right, up and forward of a camera that looks along azimuth and elevation [degrees]."""
    a, e = np.radians(azimuth), np.radians(elevation)
    forward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([np.sin(a), -np.cos(a), 0.0])
    return right, np.cross(right, forward), forward


def _spread(points: np.ndarray) -> np.ndarray:
    """How far points of the picture (P, 2) are spread in their two principal directions."""
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
