"""What is drawn into the scene: desired path, trail, and each joint's spring and motor torque.

Each is a tube, which is a skin of the model: its vertices and colour are rewritten every frame.
"""

from functools import lru_cache
from typing import NamedTuple

import mujoco
import numpy as np

from ..palette import MEASURED, MOTOR, SPRING_NEGATIVE, SPRING_POSITIVE, SPRING_ZERO
from . import tubes
from .frame_data import FrameData, Scale
from .render_model import RenderModel
from .surroundings import PREFIX, RINGS, colour, size

WINDINGS = 2.0
"""Turns of a spring whose joint is at its equilibrium."""
TRAIL = 0.5
"""How much of a cycle the trail shows."""
SWEEP = 1.5 * np.pi
"""Angle of the arc of a motor's greatest torque [rad]."""
WEAK = 0.02
"""Share of a spring's greatest stiffness, or a motor's torque, below which nothing is drawn."""


class Joint(NamedTuple):
    """Where a joint's spring is drawn."""

    id: int
    body: int
    link: np.ndarray
    """Direction of the link in the body's frame (3,)."""
    lift: float
    """Distance along the axis from the joint's anchor [m]."""
    inner: float
    """Radius of the spring's inner end [m]."""
    outer: float
    """Radius of its outer end [m]."""


Place = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Where a joint is in a frame: its anchor [m], its axis and the direction of its link (3,)."""


class Overlays:
    """The overlays of one arm.

    Args:
        arm: in the pose of the first frame.
        camera: as it is at the first frame.

    Attributes:
        joints: where each joint's spring is drawn.
    """

    def __init__(self, arm: RenderModel, camera: mujoco.MjvCamera) -> None:
        self._arm, self._shown, self._options = arm, arm.shown, arm.options
        model, anchors = arm.model, arm.anchors(arm.data)
        self._other_pose = mujoco.MjData(model)
        self._tool = lru_cache(4 * RINGS["trail"])(self._tool_at)
        self._size, eye, self._azimuth = size(anchors), arm.eye(camera), camera.azimuth
        self._begin = float(arm.shown.time[arm.shown.sample[0]])
        self.joints = [self._placed(i, anchors[k + 1], eye) for k, i in enumerate(arm.ids)]
        self._path, self._path_cycle = np.empty(0), -1
        self._dt = float(np.diff(arm.shown.time).min())
        names = ((s, model.skin(s).name) for s in range(model.nskin))
        self.skins = {name: s for s, name in names if name.startswith(PREFIX)}

    def show(self, shown: FrameData, sample: int, scales: Scale, camera: mujoco.MjvCamera) -> None:
        """Bring the arm and its overlays to a sample, and the camera if it follows.

        Args:
            shown: what is filmed, or another part of the same arm's run.
            sample: its number in it.
            scales: what full thickness, colour and length stand for.
            camera: that is drawn with.
        """
        arm, options = self._arm, self._options
        if shown is not self._shown:
            self._shown = shown
            self._tool.cache_clear()
        arm.pose(shown.q[sample])
        if options.follow and camera.type == mujoco.mjtCamera.mjCAMERA_FREE:
            camera.lookat[:] = arm.data.site_xpos[arm.site]
        if options.orbit:
            since = float(shown.time[sample]) - self._begin
            camera.azimuth = self._azimuth + options.orbit * since
        eye = arm.eye(camera)
        arm.model.skin_rgba[list(self.skins.values()), 3] = 0.0
        if options.path:
            self._draw_path(sample, eye)
        if options.trail:
            self._draw_trail(sample, eye)
        to_equilibrium = shown.equilibrium(sample) - shown.q[sample]
        shares = shown.spring(sample) / scales.torque
        for j, joint in enumerate(self.joints):
            link = arm.data.xmat[joint.body].reshape(3, 3) @ joint.link
            place = arm.data.xanchor[joint.id], arm.data.xaxis[joint.id], link
            if options.springs:
                stiffness = float(shown.stiffness[sample, j] / scales.stiffness[j])
                self._draw_spring(j, place, stiffness, float(to_equilibrium[j]), float(shares[j]))
            if options.motors:
                self._draw_motor(j, place, float(shown.tau[sample, j] / scales.torque[j]))

    def _tool_at(self, sample: int) -> np.ndarray:
        """Position of the tool (3,) [m]."""
        self._other_pose.qpos[self._arm.address] = self._shown.q[sample]
        self._arm.followers.place(self._other_pose.qpos)
        mujoco.mj_kinematics(self._arm.model, self._other_pose)
        return self._other_pose.site_xpos[self._arm.site].copy()

    def _desired(self, sample: int) -> np.ndarray:
        """Desired path of a sample's cycle (·, 3) [m]; free coordinates as the tool's."""
        shown = self._shown
        first, period = int(np.searchsorted(shown.cycle, shown.cycle[sample])), shown.period[sample]
        last = min(first + int(period), len(shown.time)) - 1
        index = np.linspace(first, last, RINGS["path"]).round().astype(int)
        points = np.empty((len(index), 3))
        if len(shown.axes) < 3:
            points[:] = [self._tool(i) for i in index]
        points[:, shown.axes] = shown.x_desired[index]
        if last - first == period - 1:
            points[-1] = points[0]
        return points

    def _draw_path(self, sample: int, eye: np.ndarray) -> None:
        if self._shown.cycle[sample] != self._path_cycle:
            self._path_cycle = int(self._shown.cycle[sample])
            self._path = self._desired(sample)
        radius = tubes.dashed(0.035 * self._size, RINGS["path"], dash=3)
        tube = tubes.tube(self._before_all(self._path, eye), radius)
        self._draw("path", tube, colour(self._options.ink))

    def _draw_trail(self, sample: int, eye: np.ndarray) -> None:
        rings, long = RINGS["trail"], int(TRAIL * self._shown.period[sample])
        step = max(1, long // rings)
        # On a grid, so that the next frame's trail is made of the same poses.
        index = (sample // step + np.arange(1 - rings, 1)) * step
        index[-1] = sample
        # Cycles that were not kept leave a gap in time that no trail leads over.
        since = max(0, sample - long)
        gaps = np.flatnonzero(np.diff(self._shown.time[since : sample + 1]) > 2 * self._dt)
        since += gaps[-1] + 1 if len(gaps) else 0
        points = np.array([self._tool(i) for i in np.maximum(index, since)])
        radius = np.linspace(0.0, 0.075 * self._size, rings)
        self._draw("trail", tubes.tube(self._before_all(points, eye), radius), colour(MEASURED))

    def _draw_spring(
        self, j: int, place: Place, stiffness: float, to_equilibrium: float, torque: float
    ) -> None:
        """Draw a spring; stiffness and torque are shares of their scales."""
        (anchor, axis, link), joint, size = place, self.joints[j], self._size
        share = min(abs(stiffness), 1.0)
        if share < WEAK:
            return
        profile = tubes.rounded if stiffness > 0 else tubes.dashed
        part = np.linspace(0.0, 1.0, RINGS["spring"])
        most = 4 * size if self._shown.slides[j] else 2 * np.pi
        end = float(np.clip(to_equilibrium, -most, most))
        across = np.linspace(-0.6, 0.6, RINGS["equilibrium"])[:, None]
        if self._shown.slides[j]:
            beside = anchor + joint.outer * link
            around = tubes.turned(link, axis, 2 * np.pi * 6 * part)
            points = beside + 0.35 * size * around + (end * part)[:, None] * axis
            mark = beside + end * axis + across * (size * np.cross(axis, link))
        else:
            centre = anchor + joint.lift * axis
            around = tubes.turned(link, axis, (end - 2 * np.pi * WINDINGS) * part)
            points = centre + (joint.inner + (joint.outer - joint.inner) * part)[:, None] * around
            points += (0.15 * size * part)[:, None] * axis * np.sign(joint.lift or 1)
            reach = np.linspace(joint.outer - 0.1 * size, joint.outer + 0.4 * size, len(across))
            mark = centre + reach[:, None] * tubes.turned(link, axis, np.array(end))
        radius = profile(float(0.09 * size * np.sqrt(share)), len(part))
        self._draw(f"spring {j}", tubes.tube(points, radius, axis), _shade(torque))
        if abs(to_equilibrium) <= most:
            tube = tubes.tube(mark, tubes.rounded(0.07 * size, len(across)), axis)
            self._draw(f"equilibrium {j}", tube, colour(self._options.ink))

    def _draw_motor(self, j: int, place: Place, torque: float) -> None:
        """Draw a motor's torque, a share of its scale."""
        (anchor, axis, link), joint, size = place, self.joints[j], self._size
        share = float(np.clip(torque, -1.0, 1.0))
        if abs(share) < WEAK:
            return
        rings = RINGS["motor"]
        part = np.linspace(0.0, 1.0, rings)
        if self._shown.slides[j]:
            points = anchor - joint.outer * link + (3 * size * share * part)[:, None] * axis
            normal = link
        else:
            around = tubes.turned(link, axis, SWEEP * share * part)
            points = anchor + joint.lift * axis + (joint.outer + 0.45 * size) * around
            normal = axis
        length = SWEEP * abs(share) * (joint.outer + 0.45 * size)
        head = int(np.clip(rings * 0.35 * size / length, 3, rings // 2))
        tube = tubes.tube(points, tubes.arrow(0.075 * size, rings, head), normal)
        self._draw(f"motor {j}", tube, colour(MOTOR))

    def _before_all(self, points: np.ndarray, eye: np.ndarray) -> np.ndarray:
        """The same points of the picture, but nearer to the camera than the arm that hides them."""
        sight = eye - points
        distance = np.linalg.norm(sight, axis=1, keepdims=True)
        return points + np.minimum(1.5 * self._size / distance, 0.5) * sight

    def _draw(self, name: str, vertices: np.ndarray, rgba: np.ndarray) -> None:
        model, skin = self._arm.model, self.skins[PREFIX + name]
        first = model.skin_vertadr[skin]
        model.skin_vert[first : first + len(vertices)] = vertices
        model.skin_rgba[skin] = rgba

    def _placed(self, i: int, after: np.ndarray, eye: np.ndarray) -> Joint:
        """Put a spring before its joint where the joint's end is seen, else around the joint."""
        data, size, body = self._arm.data, self._size, int(self._arm.model.jnt_bodyid[i])
        axis, anchor = data.xaxis[i], data.xanchor[i]
        link = after - anchor - ((after - anchor) @ axis) * axis
        length = float(np.linalg.norm(link))
        link = link / length if length > 0.2 * size else tubes.perpendicular(axis)
        side = 1.0 if axis @ (eye - anchor) >= 0 else -1.0
        far = 2.0 * size
        high = far - self._ray(anchor + side * far * axis, -side * axis, 2 * far)
        lift = side * (max(high, 0.0) + 0.15 * size) if high < 0.8 * far else 0.0
        around = tubes.turned(tubes.perpendicular(axis), axis, np.linspace(0, 2 * np.pi, 12))
        start = anchor + lift * axis
        radii = [far - self._ray(start + far * u, -u, far) for u in around]
        inner = float(np.clip(np.median(radii) + 0.12 * size, 0.22 * size, 1.3 * size))
        link_in_body = data.xmat[body].reshape(3, 3).T @ link
        return Joint(i, body, link_in_body, lift, inner, inner + 0.75 * size)

    def _ray(self, start: np.ndarray, along: np.ndarray, most: float) -> float:
        """Distance to the first geom along a direction [m], at most `most`."""
        geom = np.zeros(1, np.int32)
        model, data = self._arm.model, self._arm.data
        found = mujoco.mj_ray(model, data, start, along, None, 1, -1, geom)
        return most if found < 0 else min(float(found), most)


def _shade(share: float) -> np.ndarray:
    """Colour (4,) of a spring that carries a share of its greatest torque, -1 to 1."""
    end = colour(SPRING_POSITIVE if share > 0 else SPRING_NEGATIVE)
    part = np.float32(min(abs(share), 1.0))
    return (1 - part) * colour(SPRING_ZERO) + part * end
