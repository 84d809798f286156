"""The motion of a run as a scene that one turns and scrubs in a browser: its geometry and frames.

What draws it is `scene/scene.js`, bundled with three.js into `scene/bundle.js`.
"""

import base64
import json
from collections.abc import Callable
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


def scene(planned: film.Film, note: Callable[[str], None]) -> Shown:
    """The scene of the first run of a film, at the film's frames.

    Raises:
        RobotError: the arm's file is missing.
    """
    run, options = planned.runs[0], RenderOptions(size=planned.size)
    shown = frame_data.of_run(run, planned.times, planned.labels[0])
    model, tool = prepare(shown, options, options.size, note)
    arm = RenderModel(shown, options, model, tool)
    camera = arm.camera(options.size[0] / options.size[1])
    placed, scale = Overlays(arm, camera).joints, frame_data.scale([shown])
    middle = camera.lookat.copy()
    bodies, meshes = _geometry(model)
    at, moved = shown.sample, sorted(bodies)
    poses, tips = np.empty((len(at), len(moved), 7)), np.empty((len(at), 3))
    for frame, sample in enumerate(at):
        arm.pose(shown.q[sample])
        poses[frame, :, :3] = arm.data.xpos[moved]
        poses[frame, :, 3:] = arm.data.xquat[moved]
        tips[frame] = arm.data.site_xpos[arm.site]
    away = np.array([shown.equilibrium(sample) - shown.q[sample] for sample in at])
    paths, path = _paths(run, shown, tips)
    dt = run.experiment.simulation.timestep
    first = [int(np.flatnonzero(path == number)[-1]) for number in range(len(paths))]
    of_path = dt * shown.period[at[first]]
    spans = [(one.start, one.stop, round(one.at * film.FPS)) for one in planned.scenes]
    joints = [
        {
            "name": name,
            "slides": bool(slides),
            "body": moved.index(joint.body) if joint.body in bodies else -1,
            "anchor": model.jnt_pos[joint.id],
            "axis": model.jnt_axis[joint.id],
            "link": joint.link,
            "inner": joint.inner,
            "outer": joint.outer,
            "lift": joint.lift,
        }
        for name, slides, joint in zip(shown.joints, shown.slides, placed, strict=True)
    ]
    found = {
        "bodies": [bodies[body] for body in moved],
        "meshes": meshes,
        "joints": joints,
        "paths": [path.round(5) for path in paths],
        "size": size(arm.anchors(arm.data)),
        "camera": {"eye": arm.eye(camera), "target": middle, "fov": _fov(model)},
        "spans": spans,
        "fps": film.FPS,
        "trail": [float(one) for one in TRAIL * of_path * film.FPS / planned.speed],
        "times": _packed(planned.times),
        "poses": _packed(poses),
        "tool": _packed(tips),
        "stiffness": _packed(shown.stiffness[at] / scale.stiffness),
        "away": _packed(np.clip(np.nan_to_num(away), -1e3, 1e3)),
        "spring": _packed(shown.spring()[at] / scale.torque),
        "motor": _packed(shown.tau[at] / scale.torque),
        "path": path.tolist(),
        "error": _packed(np.array([shown.error(sample) for sample in at])),
        "cycle": shown.cycle[at].tolist(),
    }
    text = json.dumps(found, default=_plain, separators=(",", ":"))
    # Names are a user's: none of them ends the element that holds them.
    return Shown(text.replace("<", "\\u003c"), spans)


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


def _fov(model: mujoco.MjModel) -> float:
    return float(model.vis.global_.fovy)


def _packed(values: np.ndarray, kind: type = np.float32) -> str:
    """Numbers as the script unpacks them."""
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()


def _plain(value: Any) -> Any:
    return np.asarray(value, float).round(6).tolist()
