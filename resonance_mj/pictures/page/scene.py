"""The motion of a run as a scene that one turns and scrubs in a browser: its geometry and frames.

What draws it is `scene/scene.js`, bundled with three.js into `scene/bundle.js`.
"""

import base64
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from ...results.run import Run
from ..film import frame_data
from ..film.options import RenderOptions
from ..film.overlays import TRAIL, Overlays
from ..film.render_model import RenderModel
from ..film.surroundings import SHOWN, geom_colour, prepare, size
from . import film

BUNDLE = Path(__file__).parent / "scene" / "bundle.js"
"""Script that draws a scene: esbuild's of scene.js and three.js, see scene/package.json."""

POINTS = 160
"""Points of a desired path."""

CORNERS = 60_000
"""Corners of all meshes together, above which each is drawn as its convex hull."""

SHAPES = {
    mujoco.mjtGeom.mjGEOM_PLANE: "plane",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}
"""Geoms that are drawn; height fields and signed distances are not."""


class Shown(NamedTuple):
    """A scene as the page's script reads it."""

    text: str
    spans: list[tuple[float, float, int]]
    """Start and stop of each span of the run that it shows [s], and its first frame."""


class Stage:
    """The arm as a browser draws it: what does not change, and its frames.

    Args:
        shown: which arm; its samples are in the picture for certain.
        options: camera and size.
        note: is called with each line that the user should know.

    Attributes:
        arm: that is posed.
        still: what does not change, for the script.

    Raises:
        PictureError: the model has no such camera.
        RobotError: the arm's file is missing.
    """

    def __init__(
        self, shown: frame_data.FrameData, options: RenderOptions, note: Callable[[str], None]
    ) -> None:
        model, tool = prepare(shown, options, options.size, note)
        arm = self.arm = RenderModel(shown, options, model, tool)
        camera = arm.camera(options.size[0] / options.size[1])
        bodies, meshes = _geometry(model)
        self._moved = sorted(bodies)
        joints = [
            {
                "name": name,
                "slides": bool(slides),
                "body": self._moved.index(joint.body) if joint.body in bodies else -1,
                "anchor": model.jnt_pos[joint.id],
                "axis": model.jnt_axis[joint.id],
                "link": joint.link,
                "inner": joint.inner,
                "outer": joint.outer,
                "lift": joint.lift,
            }
            for name, slides, joint in zip(
                shown.joints, shown.slides, Overlays(arm, camera).joints, strict=True
            )
        ]
        self.still: dict[str, Any] = {
            "bodies": [bodies[body] for body in self._moved],
            "meshes": meshes,
            "joints": joints,
            "size": size(arm.anchors(arm.data)),
            "camera": {
                "eye": arm.eye(camera),
                "target": camera.lookat.copy(),
                "fov": float(model.vis.global_.fovy),
            },
        }

    def frames(
        self, shown: frame_data.FrameData, at: Sequence[int], scale: frame_data.Scale
    ) -> dict[str, np.ndarray]:
        """Poses of the bodies, the tool, and what the overlays show, a row for each sample."""
        poses, tips = np.empty((len(at), len(self._moved), 7)), np.empty((len(at), 3))
        data = self.arm.data
        for frame, sample in enumerate(at):
            self.arm.pose(shown.q[sample])
            poses[frame, :, :3] = data.xpos[self._moved]
            poses[frame, :, 3:] = data.xquat[self._moved]
            tips[frame] = data.site_xpos[self.arm.site]
        away = np.array([shown.equilibrium(sample) - shown.q[sample] for sample in at])
        index = np.asarray(at)
        return {
            "times": shown.time[index],
            "poses": poses.reshape(len(at), -1),
            "tool": tips,
            "stiffness": shown.stiffness[index] / scale.stiffness,
            "away": np.clip(np.nan_to_num(away), -1e3, 1e3),
            "spring": np.array([shown.spring(sample) for sample in at]) / scale.torque,
            "motor": shown.tau[index] / scale.torque,
            "error": np.array([shown.error(sample) for sample in at]),
        }


def scene(planned: film.Film, note: Callable[[str], None]) -> Shown:
    """The scene of the first run of a film, at the film's frames.

    Raises:
        RobotError: the arm's file is missing.
    """
    run, options = planned.runs[0], RenderOptions(size=planned.size)
    shown = frame_data.of_run(run, planned.times, planned.labels[0])
    stage, at = Stage(shown, options, note), shown.sample
    frames = stage.frames(shown, at.tolist(), frame_data.scale([shown]))
    paths, path = _paths(run, shown, frames["tool"])
    dt = run.experiment.simulation.timestep
    first = [int(np.flatnonzero(path == number)[-1]) for number in range(len(paths))]
    of_path = dt * shown.period[at[first]]
    spans = [(one.start, one.stop, round(one.at * film.FPS)) for one in planned.scenes]
    found = stage.still | {
        "paths": [path.round(5) for path in paths],
        "spans": spans,
        "fps": film.FPS,
        "trail": [float(one) for one in TRAIL * of_path * film.FPS / planned.speed],
        "path": path.tolist(),
        "cycle": shown.cycle[at].tolist(),
        **{name: _packed(values) for name, values in frames.items()},
    }
    return Shown(in_html(found), spans)


def in_html(found: Any) -> str:
    """Data as text that ends no element, whatever names a user gave."""
    text = json.dumps(found, default=_plain, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _geometry(model: mujoco.MjModel) -> tuple[dict[int, list[dict[str, Any]]], list[Any]]:
    """What is seen of each body, by its id, and the meshes that it is made of."""
    bodies: dict[int, list[dict[str, Any]]] = {int(body): [] for body in model.jnt_bodyid}
    used: dict[int, int] = {}
    for geom in range(model.ngeom):
        kind = SHAPES.get(mujoco.mjtGeom(int(model.geom_type[geom])))
        rgba = geom_colour(model, geom)
        if kind is None or rgba[3] <= 0 or model.geom_group[geom] not in SHOWN:
            continue
        one: dict[str, Any] = {
            "kind": kind,
            "size": model.geom_size[geom],
            "at": model.geom_pos[geom],
            "turn": model.geom_quat[geom],
            "colour": np.round(rgba, 3),
        }
        if kind == "mesh":
            one["mesh"] = used.setdefault(int(model.geom_dataid[geom]), len(used))
        bodies.setdefault(int(model.geom_bodyid[geom]), []).append(one)
    hulls = sum(model.mesh_vertnum[list(used)]) > CORNERS if used else False
    return bodies, [_mesh(model, mesh, bool(hulls)) for mesh in used]


def _mesh(model: mujoco.MjModel, mesh: int, hull: bool) -> dict[str, Any]:
    """A mesh, its corners in 65 536 steps of the box around it; or its convex hull."""
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    corners = model.mesh_vert[first : first + count]
    begin, many = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    faces = model.mesh_face[begin : begin + many]
    if hull:
        from scipy.spatial import ConvexHull, QhullError

        try:
            found = ConvexHull(corners)
        except QhullError:  # a flat one
            pass
        else:
            used = np.unique(found.simplices)
            outward = np.cross(
                corners[found.simplices[:, 1]] - corners[found.simplices[:, 0]],
                corners[found.simplices[:, 2]] - corners[found.simplices[:, 0]],
            )
            inside = (outward * found.equations[:, :3]).sum(axis=1) < 0
            faces = found.simplices.copy()
            faces[inside] = faces[inside][:, ::-1]
            corners, faces = corners[used], np.searchsorted(used, faces)
    low, wide = corners.min(axis=0), np.ptp(corners, axis=0)
    steps = np.round((corners - low) / np.maximum(wide, 1e-12) * 65535)
    return {
        "low": low,
        "wide": wide,
        "corners": _packed(steps, np.uint16),
        "faces": _packed(faces, np.uint32),
    }


def _paths(
    run: Run, shown: frame_data.FrameData, tips: np.ndarray
) -> tuple[list[np.ndarray], np.ndarray]:
    """The desired path of each motion that is shown, and which of them each frame has."""
    at = np.searchsorted(run.data["time"].values, shown.time[shown.sample])
    of = run.data["segment_of_sample"].values[at]
    paths, which = [], np.zeros(len(of), int)
    for number, segment in enumerate(dict.fromkeys(of.tolist())):
        mine = np.flatnonzero(of == segment)
        which[mine] = number
        # The last cycle that is shown of it: a passage into it is another path.
        cycle = shown.cycle[shown.sample[mine[-1]]]
        inside = np.flatnonzero(shown.cycle == cycle)
        index = inside[np.linspace(0, len(inside) - 1, POINTS).round().astype(int)]
        points = np.empty((POINTS, 3))
        points[:] = tips[mine].mean(axis=0)
        points[:, shown.axes] = shown.x_desired[index]
        points[-1] = points[0] if len(inside) >= shown.period[inside[0]] else points[-1]
        paths.append(points)
    return paths, which


def _packed(values: np.ndarray, kind: type = np.float32) -> str:
    """Numbers as the script unpacks them."""
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()


def _plain(value: Any) -> Any:
    return np.asarray(value, float).round(6).tolist()
