"""Where the motion is looked at from: a camera of the model, or a free one that frames it."""

import mujoco
import numpy as np

from ...errors import PictureError
from .options import RenderOptions

MARGIN = 1.12
"""How much larger than the motion the picture is."""
ABOVE = 1.1
"""The same in height alone, where there is a line of text above."""


def find(
    model: mujoco.MjModel,
    options: RenderOptions,
    points: np.ndarray,
    motion: np.ndarray,
    axes: np.ndarray,
    aspect: float,
) -> mujoco.MjvCamera:
    """The camera that the options ask for.

    Args:
        model: the model.
        options: the camera's name, or where a free one stands.
        points: what must be in the picture (P, 3) [m].
        motion: where the tool is in some poses (T, 3) [m].
        axes: directions of the joints' axes (n, 3).
        aspect: width of the picture by its height.

    Raises:
        PictureError: the model has no camera of that name.
    """
    camera = mujoco.MjvCamera()
    view = options.view
    if options.camera is not None and view is None:
        names = [model.camera(i).name for i in range(model.ncam)]
        if options.camera not in names:
            known = ", ".join(name for name in names if name) or "none"
            raise PictureError(
                f"the model has no camera {options.camera!r}; its cameras are: {known}; or give "
                "azimuth,elevation,distance, as in --camera=120,-20,1.5 [degrees, degrees, m]"
            )
        camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        camera.fixedcamid = names.index(options.camera)
        return camera
    camera.azimuth, camera.elevation = view[:2] if view else _direction(points, motion, axes)
    right, up, forward = directions(camera.azimuth, camera.elevation)
    seen = points @ np.stack([right, up, forward], axis=1)
    low, high = seen.min(axis=0), seen.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    slope = np.tan(np.radians(model.vis.global_.fovy) / 2)
    above = ABOVE if options.head_up else 1.0
    near = MARGIN * max(half[1] * above / slope, half[0] / (slope * aspect))
    camera.distance = view[2] if view else max(near + half[2], 1e-3)
    middle[1] += (above - 1) * half[1]
    camera.lookat[:] = middle[0] * right + middle[1] * up + middle[2] * forward
    if options.follow and view is None:
        camera.distance *= 0.6
    return camera


def directions(azimuth: float, elevation: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right, up and forward of a camera that looks along azimuth and elevation [degrees]."""
    a, e = np.radians(azimuth), np.radians(elevation)
    forward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([np.sin(a), -np.cos(a), 0.0])
    return right, np.cross(right, forward), forward


def _direction(points: np.ndarray, motion: np.ndarray, axes: np.ndarray) -> tuple[float, float]:
    """Azimuth and elevation [degrees]: along a planar arm's axes, else where most is seen."""
    planar = bool((np.abs(axes @ axes[0]) > 0.999).all())
    if planar and abs(axes[0][2]) < 0.5:
        along = axes[0] if axes[0][1] > 0 else -axes[0]
        return float(np.degrees(np.arctan2(along[1], along[0]))) + 12.0, -10.0
    elevation = -24.0

    def seen(azimuth: float) -> float:
        """How large the arm's spread and the tool's motion look."""
        across = np.stack(directions(azimuth, elevation)[:2], axis=1)
        arm, tool = (_spread(some @ across) for some in (points, motion))
        return float(np.prod(arm) * np.sqrt(tool.sum()))

    # From behind the same is seen: the side with the x axis to the right is taken.
    return float(max(np.arange(15.0, 180.0, 15.0), key=seen)), elevation


def _spread(points: np.ndarray) -> np.ndarray:
    """How far points of the picture (P, 2) are spread in their two principal directions."""
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
