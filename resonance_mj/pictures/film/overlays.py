"""What is drawn into the scene: desired path, trail, and each joint's spring and motor torque.

Each is a tube, which is a skin of the model: its vertices and colour are rewritten every frame.
"""

from itertools import pairwise
from typing import NamedTuple

import mujoco
import numpy as np

from ..palette import MEASURED, MOTOR, SPRING_NEGATIVE, SPRING_POSITIVE, SPRING_ZERO
from . import tubes
from .frame_data import FrameData, Scale
from .options import RenderOptions
from .surroundings import PREFIX, colour

PATH_RINGS, TRAIL_RINGS, SPRING_RINGS, TICK_RINGS, MOTOR_RINGS = 97, 49, 120, 4, 40
WINDINGS = 2.0
"""Turns of a spring whose joint is at its equilibrium."""
TRAIL = 0.5
"""How much of a cycle the trail shows."""
SWEEP = 1.5 * np.pi
"""Angle of the arc of a motor's greatest torque [rad]."""
WEAK = 0.02
"""Share of a spring's greatest stiffness, or a motor's torque, below which nothing is drawn."""


def rings(shown: FrameData, options: RenderOptions) -> dict[str, int]:
    """Rings of each overlay's tube, by the name of its skin."""
    found: dict[str, int] = {}
    if options.path:
        found["path"] = PATH_RINGS
    if options.trail:
        found["trail"] = TRAIL_RINGS
    for j in range(len(shown.joints)):
        if options.springs:
            found[f"spring {j}"] = SPRING_RINGS
            found[f"equilibrium {j}"] = TICK_RINGS
        if options.motors:
            found[f"motor {j}"] = MOTOR_RINGS
    return found


def size(anchors: np.ndarray) -> float:
    """Size of springs and arcs [m], from where the joints and the tool are (n + 1, 3) [m]."""
    reach = sum(float(np.linalg.norm(b - a)) for a, b in pairwise(anchors))
    return 0.2 * reach / np.sqrt(len(anchors) - 1)


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


class Overlays:
    """The overlays of one arm.

    Args:
        model: as from `surroundings.add`.
        data: in the pose of the first frame.
        shown: what is filmed.
        options: which overlays there are.
        scales: what full thickness, colour and length stand for.
        site: id of the tool's site.
        eye: where the camera is at the first frame (3,) [m].
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        shown: FrameData,
        options: RenderOptions,
        scales: Scale,
        site: int,
        eye: np.ndarray,
    ) -> None:
        self._model, self._shown, self._options, self._scale = model, shown, options, scales
        self._site = site
        self._pose = mujoco.MjData(model)
        self._pose.qpos[:] = data.qpos
        ids = [model.joint(name).id for name in shown.joints]
        self._address = model.jnt_qposadr[ids]
        self._tool: dict[int, np.ndarray] = {}
        anchors = [data.xanchor[i] for i in ids] + [data.site_xpos[site]]
        self.size = size(np.array(anchors))
        self._joints = [
            _place(model, data, i, anchors[k + 1], self.size, eye) for k, i in enumerate(ids)
        ]
        self._path, self._path_cycle = np.empty(0), -1
        self._dt = float(np.diff(shown.time).min())
        self._skins = {model.skin(s).name: s for s in range(model.nskin)}

    def go_on(self, shown: FrameData, scales: Scale) -> None:
        """Show another part of the same arm's run, or more of it, from the next update on."""
        self._shown, self._scale = shown, scales
        self._tool.clear()

    def update(self, data: mujoco.MjData, sample: int, eye: np.ndarray) -> None:
        """Bring the overlays to a sample; `data` is in its pose, and the camera at `eye` (3,)."""
        if self._options.path:
            self._update_path(sample, eye)
        if self._options.trail:
            self._update_trail(sample, eye)
        self._equilibrium = self._shown.equilibrium(sample)
        self._spring = self._shown.spring(sample)
        for j, joint in enumerate(self._joints):
            axis, anchor = data.xaxis[joint.id], data.xanchor[joint.id]
            link = data.xmat[joint.body].reshape(3, 3) @ joint.link
            if self._options.springs:
                self._update_spring(j, joint, sample, anchor, axis, link)
            if self._options.motors:
                self._update_motor(j, joint, sample, anchor, axis, link)

    def tool(self, sample: int) -> np.ndarray:
        """Position of the tool (3,) [m] at a sample."""
        if sample not in self._tool:
            self._pose.qpos[self._address] = self._shown.q[sample]
            mujoco.mj_kinematics(self._model, self._pose)
            if len(self._tool) > 4 * TRAIL_RINGS:
                self._tool.pop(next(iter(self._tool)))
            self._tool[sample] = self._pose.site_xpos[self._site].copy()
        return self._tool[sample]

    def desired(self, sample: int) -> np.ndarray:
        """Desired path of a sample's cycle (PATH_RINGS, 3) [m]; free coordinates as the tool's."""
        shown = self._shown
        first, period = int(shown.first[sample]), int(shown.period[sample])
        last = min(first + period, len(shown.time)) - 1
        index = np.linspace(first, last, PATH_RINGS).round().astype(int)
        free = len(shown.axes) < 3
        points = np.array([self.tool(i) for i in index]) if free else np.empty((PATH_RINGS, 3))
        points[:, shown.axes] = shown.x_desired[index]
        if last - first == period - 1:
            points[-1] = points[0]
        return points

    def _before_all(self, points: np.ndarray, eye: np.ndarray) -> np.ndarray:
        """The same points of the picture, but nearer to the camera than the arm that hides them."""
        sight = eye - points
        distance = np.linalg.norm(sight, axis=1, keepdims=True)
        return points + np.minimum(1.5 * self.size / distance, 0.5) * sight

    def _update_path(self, sample: int, eye: np.ndarray) -> None:
        if self._shown.cycle[sample] != self._path_cycle:
            self._path_cycle = int(self._shown.cycle[sample])
            self._path = self.desired(sample)
        points = self._before_all(self._path, eye)
        radius = tubes.dashed(0.035 * self.size, PATH_RINGS, dash=3)
        self._set("path", tubes.tube(points, radius, _normal(points)), colour(self._options.ink))

    def _update_trail(self, sample: int, eye: np.ndarray) -> None:
        long = int(TRAIL * self._shown.period[sample])
        step = max(1, long // TRAIL_RINGS)
        # On a grid, so that the next frame's trail is made of the same poses.
        index = (sample // step + np.arange(1 - TRAIL_RINGS, 1)) * step
        index[-1] = sample
        # Cycles that were not kept leave a gap in time that no trail leads over.
        time = self._shown.time
        gaps = np.flatnonzero(np.diff(time[max(0, sample - long) : sample + 1]) > 2 * self._dt)
        since = max(0, sample - long) + (gaps[-1] + 1 if len(gaps) else 0)
        points = np.array([self.tool(i) for i in np.maximum(index, since)])
        points = self._before_all(points, eye)
        radius = np.linspace(0.0, 0.075 * self.size, TRAIL_RINGS)
        self._set("trail", tubes.tube(points, radius, _normal(points)), colour(MEASURED))

    def _update_spring(
        self, j: int, joint: Joint, s: int, anchor: np.ndarray, axis: np.ndarray, link: np.ndarray
    ) -> None:
        k = float(self._shown.stiffness[s, j])
        share = min(abs(k) / self._scale.stiffness[j], 1.0)
        to_equilibrium = float(self._equilibrium[j] - self._shown.q[s, j])
        if share < WEAK:
            self._hide(f"spring {j}")
            self._hide(f"equilibrium {j}")
            return
        thick = 0.09 * self.size * np.sqrt(share)
        profile = tubes.rounded if k > 0 else tubes.dashed
        radius = profile(float(thick), SPRING_RINGS)
        shade = _shade(self._spring[j] / self._scale.torque[j])
        part = np.linspace(0.0, 1.0, SPRING_RINGS)
        if self._shown.slides[j]:
            beside = anchor + joint.outer * link
            end = np.clip(to_equilibrium, -4 * self.size, 4 * self.size)
            around = tubes.turned(link, axis, 2 * np.pi * 6 * part)
            points = beside + 0.35 * self.size * around + (end * part)[:, None] * axis
            mark = (
                beside
                + end * axis
                + np.linspace(-0.6, 0.6, TICK_RINGS)[:, None] * (self.size * np.cross(axis, link))
            )
            near = abs(to_equilibrium) <= 4 * self.size
        else:
            centre = anchor + joint.lift * axis
            turn = np.clip(to_equilibrium, -2 * np.pi, 2 * np.pi)
            around = tubes.turned(link, axis, (turn - 2 * np.pi * WINDINGS) * part)
            points = centre + (joint.inner + (joint.outer - joint.inner) * part)[:, None] * around
            points += (0.15 * self.size * part)[:, None] * axis * np.sign(joint.lift or 1)
            reach = np.linspace(joint.outer - 0.1 * self.size, joint.outer + 0.4 * self.size, 4)
            mark = centre + reach[:, None] * tubes.turned(link, axis, np.array(turn))
            near = abs(to_equilibrium) <= 2 * np.pi
        self._set(f"spring {j}", tubes.tube(points, radius, axis), shade)
        if near:
            tick = tubes.rounded(0.07 * self.size, TICK_RINGS)
            vertices = tubes.tube(mark, tick, axis)
            self._set(f"equilibrium {j}", vertices, colour(self._options.ink))
        else:
            self._hide(f"equilibrium {j}")

    def _update_motor(
        self, j: int, joint: Joint, s: int, anchor: np.ndarray, axis: np.ndarray, link: np.ndarray
    ) -> None:
        share = float(np.clip(self._shown.tau[s, j] / self._scale.torque[j], -1.0, 1.0))
        if abs(share) < WEAK:
            self._hide(f"motor {j}")
            return
        part = np.linspace(0.0, 1.0, MOTOR_RINGS)
        if self._shown.slides[j]:
            points = anchor - joint.outer * link + (3 * self.size * share * part)[:, None] * axis
            normal = link
        else:
            around = tubes.turned(link, axis, SWEEP * share * part)
            points = anchor + joint.lift * axis + (joint.outer + 0.45 * self.size) * around
            normal = axis
        length = SWEEP * abs(share) * (joint.outer + 0.45 * self.size)
        head = int(np.clip(MOTOR_RINGS * 0.35 * self.size / length, 3, MOTOR_RINGS // 2))
        radius = tubes.arrow(0.075 * self.size, MOTOR_RINGS, head)
        self._set(f"motor {j}", tubes.tube(points, radius, normal), colour(MOTOR))

    def _set(self, name: str, vertices: np.ndarray, rgba: np.ndarray) -> None:
        model, skin = self._model, self._skins[PREFIX + name]
        first = model.skin_vertadr[skin]
        model.skin_vert[first : first + len(vertices)] = vertices
        model.skin_rgba[skin] = rgba

    def _hide(self, name: str) -> None:
        self._model.skin_rgba[self._skins[PREFIX + name], 3] = 0.0


def _place(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    i: int,
    after: np.ndarray,
    size: float,
    eye: np.ndarray,
) -> Joint:
    """Put a spring before its joint where the joint's end is seen, else around the joint."""
    axis, anchor = data.xaxis[i], data.xanchor[i]
    body = int(model.jnt_bodyid[i])
    link = after - anchor - ((after - anchor) @ axis) * axis
    length = float(np.linalg.norm(link))
    link = link / length if length > 0.2 * size else tubes.perpendicular(axis)
    side = 1.0 if axis @ (eye - anchor) >= 0 else -1.0
    far = 2.0 * size
    high = far - _ray(model, data, anchor + side * far * axis, -side * axis, 2 * far)
    lift = side * (max(high, 0.0) + 0.15 * size) if high < 0.8 * far else 0.0
    around = tubes.turned(tubes.perpendicular(axis), axis, np.linspace(0, 2 * np.pi, 12))
    start = anchor + lift * axis
    radii = [far - _ray(model, data, start + far * u, -u, far) for u in around]
    inner = float(np.clip(np.median(radii) + 0.12 * size, 0.22 * size, 1.3 * size))
    return Joint(i, body, data.xmat[body].reshape(3, 3).T @ link, lift, inner, inner + 0.75 * size)


def _ray(
    model: mujoco.MjModel, data: mujoco.MjData, start: np.ndarray, along: np.ndarray, most: float
) -> float:
    """Distance to the first geom along a direction [m], at most `most`."""
    geom = np.zeros(1, np.int32)
    found = mujoco.mj_ray(model, data, start, along, None, 1, -1, geom)
    return most if found < 0 else min(float(found), most)


def _normal(points: np.ndarray) -> np.ndarray:
    """The direction (3,) in which a curve is flattest."""
    return np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][-1]


def _shade(share: float) -> np.ndarray:
    """Colour (4,) of a spring that carries a share of its greatest torque, -1 to 1."""
    end = colour(SPRING_POSITIVE if share > 0 else SPRING_NEGATIVE)
    part = np.float32(min(abs(share), 1.0))
    return (1 - part) * colour(SPRING_ZERO) + part * end
