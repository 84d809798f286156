"""A compiled model as one that can be edited: MuJoCo keeps no way back."""

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

PREFIX = {"joint": "jnt", "camera": "cam", "equality": "eq"}
"""What the arrays of a kind of element begin with, where it is not the kind."""

_TRN, _WRAP = mujoco.mjtTrn, mujoco.mjtWrap

TARGET = {
    _TRN.mjTRN_TENDON: "tendon",
    _TRN.mjTRN_BODY: "body",
    _TRN.mjTRN_SITE: "site",
    _TRN.mjTRN_SLIDERCRANK: "site",
}
"""What an actuator acts on if not on a joint."""


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
        body = _add(model, bodies[model.body_parentid[i]], "body", i)
        body.explicitinertial = bool(model.body_mass[i] > 0)
        body.mocap = bool(model.body_mocapid[i] >= 0)
        bodies.append(body)
    for kind in ("joint", "geom", "site", "camera", "light"):
        for i, carrier in enumerate(getattr(model, f"{PREFIX.get(kind, kind)}_bodyid")):
            element = _add(model, bodies[carrier], kind, i)
            if kind == "joint":
                _copy(model, element, int(model.jnt_dofadr[i]), "dof_")
                element.ref = model.qpos0[model.jnt_qposadr[i]]
                element.springref = model.qpos_spring[model.jnt_qposadr[i]]
            elif kind == "geom" and model.geom_dataid[i] >= 0:
                element.meshname = _name(model, "mesh", model.geom_dataid[i])
            if kind == "geom" and model.geom_matid[i] >= 0:
                element.rgba = model.mat_rgba[model.geom_matid[i]]
    for signature in model.exclude_signature:
        one, other = (_name(model, "body", i) for i in divmod(int(signature), 1 << 16))
        spec.add_exclude(bodyname1=one, bodyname2=other)
    for i in range(model.npair):
        pair = _add(model, spec, "pair", i)
        pair.geomname1 = _name(model, "geom", model.pair_geom1[i])
        pair.geomname2 = _name(model, "geom", model.pair_geom2[i])
    for i in range(model.ntendon):
        _wrap(model, _add(model, spec, "tendon", i), i)
    for i in range(model.neq):
        tie = _add(model, spec, "equality", i)
        kind = mujoco.mjtEq(model.eq_type[i]).name.removeprefix("mjEQ_").lower()
        if kind not in ("joint", "tendon"):
            kind = mujoco.mjtObj(model.eq_objtype[i]).name.removeprefix("mjOBJ_").lower()
        tie.active = bool(model.eq_active0[i])
        tie.name1 = _name(model, kind, model.eq_obj1id[i])
        tie.name2 = _name(model, kind, model.eq_obj2id[i])
    for i in range(model.nu):
        actuator, (one, other) = _add(model, spec, "actuator", i), model.actuator_trnid[i]
        trn = _TRN(model.actuator_trntype[i])
        actuator.target = _name(model, TARGET.get(trn, "joint"), one)
        if trn == _TRN.mjTRN_SITE:
            actuator.refsite = _name(model, "site", other)
        elif trn == _TRN.mjTRN_SLIDERCRANK:
            actuator.slidersite = _name(model, "site", other)
    for i in range(model.nkey):
        _add(model, spec, "key", i)
    return spec


def _add(model: mujoco.MjModel, parent: Any, kind: str, i: int) -> Any:
    """Add the element that a row of a model's arrays describes."""
    element = getattr(parent, f"add_{kind}")(name=_name(model, kind, i))
    _copy(model, element, i, f"{PREFIX.get(kind, kind)}_")
    return element


def _name(model: mujoco.MjModel, kind: str, i: int) -> str:
    """The name of an element, which all that others refer to get; none for no element."""
    return "" if i < 0 else getattr(model, kind)(i).name or f"{UNNAMED}{kind}{i}"


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
            tendon.wrap_geom(_name(model, "geom", what), _name(model, "site", int(value)))
