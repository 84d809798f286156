"""Where the fields of mjModel and mjData lie in C, for compiled code that is handed their pointers.

The layout is built from MuJoCo's own description of its structs and compared with the addresses of
a real model's arrays on import: where they differ, this module refuses to load.
"""

import ctypes
import math
from typing import Any

import mujoco
from mujoco.introspect import ast_nodes, structs

from ..errors import CallbackError

_C_TYPES: dict[str, Any] = {
    "mjtNum": ctypes.c_double,
    "mjtSize": ctypes.c_int64,
    "mjtBool": ctypes.c_bool,
    "mjtByte": ctypes.c_uint8,
    "int": ctypes.c_int,
    "float": ctypes.c_float,
    "size_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
    "uintptr_t": ctypes.c_void_p,
}


def _c_type(declared: Any) -> Any:
    if isinstance(declared, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(declared, ast_nodes.ArrayType):
        return math.prod(declared.extents) * _c_type(declared.inner_type)
    if isinstance(declared, ast_nodes.ValueType):
        return _C_TYPES.get(declared.name) or _c_type(structs.STRUCTS[declared.name])
    fields = [(field.name, _c_type(field.type)) for field in declared.fields]
    return type("Struct", (ctypes.Structure,), {"_fields_": fields})


def _checked_offsets(name: str, fields: tuple[str, ...], owner: Any) -> tuple[int, ...]:
    """Byte offset of each field in the struct, compared with what a live `owner` says of itself."""
    structure = _c_type(structs.STRUCTS[name])
    live = structure.from_address(owner._address)
    for field in fields:
        value = getattr(owner, field)
        expected = value if isinstance(value, int) else value.ctypes.data
        if getattr(live, field) != expected:
            raise CallbackError(
                f"MuJoCo {mujoco.__version__}: {name}.{field} is not where mujoco.introspect "
                "says, so that no control callback can be compiled for it; use MuJoCo >= 4.0, < 5"
            )
    return tuple(getattr(structure, field).offset for field in fields)


# All sizes of this model differ, so that no field can pass for another.
_PROBE = """<mujoco><size nuserdata="11"/><worldbody>
<body><freejoint/><geom size="1"/><site/><body><joint name="a"/><geom size="1"/><site/>
<body><joint name="b"/><geom size="1"/><site/></body></body></body>
<site/></worldbody>
<actuator><motor joint="a"/><motor joint="b"/></actuator></mujoco>"""

MODEL_FIELDS = (
    "jnt_stiffness",
    "qpos_spring",
    "dof_damping",
    "nq",
    "nv",
    "nu",
    "njnt",
    "nuserdata",
)
DATA_FIELDS = (
    "userdata",
    "qpos",
    "qvel",
    "ctrl",
    "site_xpos",
    "site_xmat",
    "xanchor",
    "qfrc_bias",
    "qfrc_passive",
)

_model = mujoco.MjModel.from_xml_string(_PROBE)
MODEL_OFFSETS = _checked_offsets("mjModel", MODEL_FIELDS, _model)
DATA_OFFSETS = _checked_offsets("mjData", DATA_FIELDS, mujoco.MjData(_model))
