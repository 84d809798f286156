"""A compiled model as one that can be edited: MuJoCo keeps no way back."""

from __future__ import annotations

from typing import Any

import mujoco

from ..errors import RobotError
from .names import UNNAMED

LACKING = ("nflex", "nhfield", "nplugin")
"""Counts of what is not taken over."""

ELSEWHERE = {
    "jnt_solref": "solref_limit",
    "jnt_solimp": "solimp_limit",
    "dof_solref": "solref_friction",
    "dof_solimp": "solimp_friction",
    "tendon_solref_lim": "solref_limit",
    "tendon_solimp_lim": "solimp_limit",
    "tendon_solref_fri": "solref_friction",
    "tendon_solimp_fri": "solimp_friction",
    "tendon_lengthspring": "springlength",
}
"""Arrays of a model that an element calls otherwise."""

_TRN, _WRAP = mujoco.mjtTrn, mujoco.mjtWrap


def spec_of(model: mujoco.MjModel, where: str) -> mujoco.MjSpec:
    """An editable model that moves as a compiled one does; materials become colours.

    Args:
        model: the compiled one.
        where: how an error calls it.

    Raises:
        RobotError: it has something that is not taken over.
    """
    lacking = [kind[1:] for kind in LACKING if getattr(model, kind)]
    if lacking:
        raise RobotError(
            f"{where}: is compiled and has {', '.join(lacking)}, which cannot be taken out of it: "
            "give the MJCF that it was compiled from"
        )
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.nuserdata = model.nuserdata
    for field in (name for name in dir(model.opt) if not name.startswith("_")):
        setattr(spec.option, field, getattr(model.opt, field))
    for i in range(model.nmesh):
        vertices = slice(model.mesh_vertadr[i], model.mesh_vertadr[i] + model.mesh_vertnum[i])
        faces = slice(model.mesh_faceadr[i], model.mesh_faceadr[i] + model.mesh_facenum[i])
        spec.add_mesh(
            name=_name(model, "mesh", i),
            uservert=model.mesh_vert[vertices].ravel(),
            userface=model.mesh_face[faces].ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
    bodies = [spec.worldbody]
    for i in range(1, model.nbody):
        body = bodies[model.body_parentid[i]].add_body(name=_name(model, "body", i))
        bodies.append(body)
        _copy(model, body, i, "body_")
        body.explicitinertial = bool(model.body_mass[i] > 0)
        body.mocap = bool(model.body_mocapid[i] >= 0)
    for i in range(model.njnt):
        joint = bodies[model.jnt_bodyid[i]].add_joint(name=_name(model, "joint", i))
        _copy(model, joint, i, "jnt_")
        _copy(model, joint, int(model.jnt_dofadr[i]), "dof_")
        joint.ref = model.qpos0[model.jnt_qposadr[i]]
        joint.springref = model.qpos_spring[model.jnt_qposadr[i]]
    for i in range(model.ngeom):
        geom = bodies[model.geom_bodyid[i]].add_geom(name=_name(model, "geom", i))
        _copy(model, geom, i, "geom_")
        if model.geom_dataid[i] >= 0:
            geom.meshname = _name(model, "mesh", int(model.geom_dataid[i]))
        if model.geom_matid[i] >= 0:
            geom.rgba = model.mat_rgba[model.geom_matid[i]]
    for i in range(model.nsite):
        _copy(
            model, bodies[model.site_bodyid[i]].add_site(name=_name(model, "site", i)), i, "site_"
        )
    for i in range(model.ncam):
        _copy(
            model, bodies[model.cam_bodyid[i]].add_camera(name=_name(model, "camera", i)), i, "cam_"
        )
    for i in range(model.nlight):
        _copy(
            model,
            bodies[model.light_bodyid[i]].add_light(name=_name(model, "light", i)),
            i,
            "light_",
        )
    for signature in model.exclude_signature:
        one, other = divmod(int(signature), 1 << 16)
        spec.add_exclude(bodyname1=_name(model, "body", one), bodyname2=_name(model, "body", other))
    for i in range(model.npair):
        pair = spec.add_pair()
        _copy(model, pair, i, "pair_")
        pair.geomname1 = _name(model, "geom", int(model.pair_geom1[i]))
        pair.geomname2 = _name(model, "geom", int(model.pair_geom2[i]))
    for i in range(model.ntendon):
        tendon = spec.add_tendon(name=_name(model, "tendon", i))
        _copy(model, tendon, i, "tendon_")
        _wrap(model, tendon, i)
    for i in range(model.neq):
        tie = spec.add_equality(name=_name(model, "equality", i))
        _copy(model, tie, i, "eq_")
        kinds = {"mjEQ_JOINT": "joint", "mjEQ_TENDON": "tendon"}
        of_site = model.eq_objtype[i] == int(mujoco.mjtObj.mjOBJ_SITE)
        kind = kinds.get(mujoco.mjtEq(model.eq_type[i]).name, "site" if of_site else "body")
        tie.active = bool(model.eq_active0[i])
        tie.name1, tie.name2 = (
            _name(model, kind, int(one)) if one >= 0 else ""
            for one in (model.eq_obj1id[i], model.eq_obj2id[i])
        )
    for i in range(model.nu):
        _actuate(model, spec.add_actuator(name=_name(model, "actuator", i)), i)
    for i in range(model.nkey):
        _copy(model, spec.add_key(name=model.key(i).name), i, "key_")
    return spec


def _name(model: mujoco.MjModel, kind: str, i: int) -> str:
    """The name of an element; of the world's body that of MuJoCo."""
    return str(getattr(model, kind)(i).name) or f"{UNNAMED}{kind}{i}"


def _copy(model: mujoco.MjModel, element: Any, i: int, prefix: str) -> None:
    """Write a row of a model's arrays into the element of the same kind."""
    for name in (name for name in dir(model) if name.startswith(prefix)):
        field = ELSEWHERE.get(name, name.removeprefix(prefix))
        if field in ("plugin", "userdata", "simple", "signature") or not hasattr(element, field):
            continue
        value = getattr(model, name)[i]
        if hasattr(model, f"{name}poly"):
            value = [value, *getattr(model, f"{name}poly")[i]]
        setattr(element, field, value)


def _wrap(model: mujoco.MjModel, tendon: Any, i: int) -> None:
    first = int(model.tendon_adr[i])
    for at in range(first, first + int(model.tendon_num[i])):
        kind, what = _WRAP(model.wrap_type[at]), int(model.wrap_objid[at])
        value = float(model.wrap_prm[at])
        if kind == _WRAP.mjWRAP_JOINT:
            tendon.wrap_joint(_name(model, "joint", what), value)
        elif kind == _WRAP.mjWRAP_SITE:
            tendon.wrap_site(_name(model, "site", what))
        elif kind == _WRAP.mjWRAP_PULLEY:
            tendon.wrap_pulley(value)
        else:
            side = _name(model, "site", int(value)) if value >= 0 else ""
            tendon.wrap_geom(_name(model, "geom", what), side)


def _actuate(model: mujoco.MjModel, actuator: Any, i: int) -> None:
    _copy(model, actuator, i, "actuator_")
    kind = _TRN(model.actuator_trntype[i])
    of = {_TRN.mjTRN_TENDON: "tendon", _TRN.mjTRN_BODY: "body"}
    of |= dict.fromkeys((_TRN.mjTRN_SITE, _TRN.mjTRN_SLIDERCRANK), "site")
    one, other = map(int, model.actuator_trnid[i])
    actuator.target = _name(model, of.get(kind, "joint"), one)
    if other >= 0 and kind in (_TRN.mjTRN_SITE, _TRN.mjTRN_SLIDERCRANK):
        field = "refsite" if kind == _TRN.mjTRN_SITE else "slidersite"
        setattr(actuator, field, _name(model, "site", other))
