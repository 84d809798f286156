"""The model as it is filmed: a copy with light, a floor, room for the picture and for overlays."""

import itertools
from collections.abc import Callable, Iterator

import mujoco
import numpy as np
from PIL import ImageColor

from ...robots import mjcf
from ...robots.compiling import compile_spec
from ...robots.couplings import Followers
from . import tubes
from .frame_data import FrameData
from .options import RenderOptions

FLAT = {"white": (1.0, 1.0, 1.0), "transparent": (1.0, 1.0, 1.0), "dark": (0.086, 0.094, 0.11)}
"""Backgrounds of one colour; they have no floor."""
HORIZON, ZENITH = (0.93, 0.95, 0.97), (0.75, 0.80, 0.86)
PREFIX = "resonance_mj_"
"""Begins the name of everything that is added."""
RINGS = {"path": 97, "trail": 49, "spring": 120, "equilibrium": 4, "motor": 40}
"""Rings of the tube of each kind of overlay."""
SHOWN = np.flatnonzero(mujoco.MjvOption().geomgroup)
"""The groups of geoms that MuJoCo shows unless it is told otherwise."""
NOTHING = np.array([0.5, 0.5, 0.5, 1.0], np.float32)
"""MuJoCo's colour of a geom that has none, which lets its material's through."""


def prepare(
    shown: FrameData, options: RenderOptions, size: tuple[int, int], note: Callable[[str], None]
) -> tuple[mujoco.MjModel, str]:
    """Compile a copy of the arm that is shown for pictures; the file is not changed.

    Args:
        shown: which arm, in which poses.
        options: background, and which overlays there are: they become skins.
        size: width and height that are rendered [pixels].
        note: is called with a line if the arm had to be made visible.

    Returns:
        The model, and the name of the tool's site.

    Raises:
        RobotError: the file is missing or MuJoCo rejects it.
    """
    path = mjcf.find(shown.robot.mjcf)
    arm = mjcf.read(shown.robot)
    spec = arm.spec
    model = compile_spec(spec, path)
    if _show_arm(spec, model, shown.joints, arm.site, note):
        model = compile_spec(spec, path)
    if model.nlight == 0:
        _add_light(spec, model.stat)
    floors = [geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE]
    if options.background in FLAT:
        for geom in floors:
            geom.material, geom.rgba = "", [0, 0, 0, 0]
    for geom in floors:
        _make_endless(spec, geom)
    if options.background not in FLAT and not floors:
        poses = shown.q[shown.sample[:: max(1, len(shown.sample) // 20)]]
        every = np.arange(model.ngeom)
        posed = in_poses(model, shown.joints, poses)
        lowest = min(corners(model, data, every)[:, 2].min(initial=0.0) for data in posed)
        _add_floor(spec, float(lowest))
    _set_sky(spec, options.background)
    spec.visual.rgba.haze = [*HORIZON, 1.0]
    # Overlays glow a little: their colours mean something, in the shadow as well.
    spec.add_material(name=f"{PREFIX}overlay", emission=0.15, specular=0.1)
    names = ["path"] * options.path + ["trail"] * options.trail
    for j in range(len(shown.joints)):
        names += [f"spring {j}", f"equilibrium {j}"] * options.springs
        names += [f"motor {j}"] * options.motors
    for name in names:
        _add_tube(spec, name)
    # Each process that draws has the buffer in memory, several times: it is no larger than needed.
    spec.visual.global_.offwidth, spec.visual.global_.offheight = size
    return compile_spec(spec, path), arm.site


def in_poses(
    model: mujoco.MjModel, joints: tuple[str, ...], poses: np.ndarray
) -> Iterator[mujoco.MjData]:
    """A model with its joints at angles (P, n) [rad], in one mjData."""
    data = mujoco.MjData(model)
    ids = [model.joint(name).id for name in joints]
    address, followers = model.jnt_qposadr[ids], Followers(model, ids)
    for q in poses:
        data.qpos[address] = q
        followers.place(data.qpos)
        mujoco.mj_kinematics(model, data)
        yield data


def size(anchors: np.ndarray) -> float:
    """Size of springs and arcs [m], from where the joints and the tool are (n + 1, 3) [m]."""
    reach = np.linalg.norm(np.diff(anchors, axis=0), axis=1).sum()
    return float(0.2 * reach / np.sqrt(len(anchors) - 1))


def corners(model: mujoco.MjModel, data: mujoco.MjData, geoms: np.ndarray) -> np.ndarray:
    """Corners of the boxes around some geoms, by their ids (g,), in the world (8 g, 3) [m]."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    within = model.geom_aabb[geoms, None, :3] + signs * model.geom_aabb[geoms, None, 3:]
    rotation = data.geom_xmat[geoms].reshape(-1, 3, 3)
    found = data.geom_xpos[geoms, None] + np.einsum("gij,gcj->gci", rotation, within)
    return np.asarray(found.reshape(-1, 3))


def colour(text: str) -> np.ndarray:
    """A colour such as "#0072B2" as MuJoCo has it (4,)."""
    return np.array(ImageColor.getcolor(text, "RGBA"), np.float32) / np.float32(255)


def _show_arm(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    site: str,
    note: Callable[[str], None],
) -> bool:
    """See to it that something of the arm is seen; returns whether a spec had to be changed."""
    moving = np.flatnonzero(model.body_weldid[model.geom_bodyid] > 0)
    solid = [i for i in moving if geom_colour(model, int(i))[3] > 0]
    if any(model.geom_group[i] in SHOWN for i in solid):
        return False
    if solid:
        groups = sorted(set(model.geom_group[solid].tolist()))
        note(f"all of the arm is in geom groups that are hidden: {groups} are shown")
        for i in solid:
            spec.geoms[i].group = 0
    else:
        note("the arm has no geom that could be seen: it is drawn as lines between its joints")
        _add_lines(spec, model, joints, site)
    return True


def geom_colour(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """Colour of a geom (4,), its own or its material's."""
    material = model.geom_matid[geom]
    own = material < 0 or (model.geom_rgba[geom] != NOTHING).any()
    return np.asarray(model.geom_rgba[geom] if own else model.mat_rgba[material])


def _add_lines(
    spec: mujoco.MjSpec, model: mujoco.MjModel, joints: tuple[str, ...], site: str
) -> None:
    """A capsule from each joint to the next, and from the last to the tool."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    ids = [model.joint(name).id for name in joints]
    points = np.array([*data.xanchor[ids], data.site_xpos[model.site(site).id]])
    for joint, (start, end) in zip(ids, itertools.pairwise(points), strict=True):
        body = int(model.jnt_bodyid[joint])
        ends = (np.stack([start, end]) - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
        apart = np.linalg.norm(end - start) > 1e-6
        spec.body(model.body(body).name).add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE if apart else mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[0.2 * size(points), 0, 0],
            **({"fromto": ends.ravel()} if apart else {"pos": ends[0]}),
            mass=0,
            contype=0,
            conaffinity=0,
        )


def _add_light(spec: mujoco.MjSpec, about: mujoco.MjStatistic) -> None:
    """A lamp from above and the front, and enough light in its shadow."""
    towards = np.array([0.35, 0.6, -0.9])
    spec.worldbody.add_light(
        name=f"{PREFIX}light",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        # As near as the arm is wide, and shadows as far as they fall: else the floor is speckled.
        pos=about.center - 2 * about.extent * towards,
        dir=towards,
        diffuse=[0.7, 0.7, 0.7],
        castshadow=True,
    )
    spec.visual.map.shadowclip = max(spec.visual.map.shadowclip, 2.0)
    headlight = spec.visual.headlight
    headlight.active = 1
    headlight.ambient, headlight.diffuse = [0.35, 0.35, 0.35], [0.35, 0.35, 0.35]
    headlight.specular = [0, 0, 0]


def _add_floor(spec: mujoco.MjSpec, height: float) -> None:
    spec.add_texture(
        name=f"{PREFIX}floor",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.80, 0.82, 0.84],
        rgb2=[0.74, 0.76, 0.79],
        width=256,
        height=256,
    )
    material = spec.add_material(name=f"{PREFIX}floor", texrepeat=[4, 4], texuniform=True)
    textures = list(material.textures)
    textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = f"{PREFIX}floor"
    material.textures = textures
    spec.worldbody.add_geom(
        name=f"{PREFIX}floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[0, 0, height],
        size=[0, 0, 0.05],
        material=f"{PREFIX}floor",
        contype=0,
        conaffinity=0,
    )


def _make_endless(spec: mujoco.MjSpec, floor: mujoco.MjsGeom) -> None:
    """Let a floor have no edge, as it has none to what touches it; its pattern keeps its size."""
    material, half = spec.material(floor.material), np.array(floor.size[:2])
    if material is not None and not material.texuniform and half.all():
        material.texrepeat, material.texuniform = np.array(material.texrepeat) / (2 * half), True
    floor.size = [0, 0, floor.size[2]]


def _set_sky(spec: mujoco.MjSpec, background: str) -> None:
    """Make the sky of one colour, or add one to a model that has none."""
    kind = mujoco.mjtTexture.mjTEXTURE_SKYBOX
    skies = [texture for texture in spec.textures if texture.type == kind]
    if background not in FLAT and skies:
        return
    for texture in skies:
        spec.delete(texture)
    sky = spec.add_texture(name=f"{PREFIX}sky", type=kind)
    sky.builtin = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2 = (FLAT[background],) * 2 if background in FLAT else (HORIZON, ZENITH)
    sky.width = sky.height = 64


def _add_tube(spec: mujoco.MjSpec, name: str) -> None:
    """A skin of the world: its vertices can be rewritten for each frame."""
    rings = RINGS[name.split()[0]]
    corners = rings * tubes.SIDES
    spec.add_skin(
        name=PREFIX + name,
        material=f"{PREFIX}overlay",
        # The compiler rejects vertices that coincide.
        vert=np.linspace(0.0, 1e-3, 3 * corners).tolist(),
        face=tubes.faces(rings).ravel().tolist(),
        bodyname=["world"],
        bindpos=[0, 0, 0],
        bindquat=[1, 0, 0, 0],
        vertid=[list(range(corners))],
        vertweight=[[1.0] * corners],
    )
