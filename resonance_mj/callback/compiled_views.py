"""The controller's block as compiled control steps see it: `views.Own`, as Numba understands it.

A value of the type is the header's numbers, read once; an array is made of them where it is asked
for. (Functions that return all the arrays take three times as long to compile.)
"""

from typing import Any

import numpy as np
from numba import carray, types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    models,
    overload,
    register_model,
    type_callable,
)
from numba.np.arrayobj import make_array, populate_array

from ..laws import views
from ..laws.memory import ARRAYS, NUMBERS
from ..laws.views import FLAGS, INTEGERS, SIZES, TABLES, header_name, own


class OwnType(types.Type):
    """Type of `views.own`."""

    def __init__(self) -> None:
        super().__init__("Own")


_OWN = OwnType()


def _number(name: str) -> types.Type:
    """Type of a number of the header; of an array's, where it begins."""
    return types.intp if name in (*INTEGERS, *FLAGS, *ARRAYS) else types.float64


@register_model(OwnType)
class _OwnModel(models.StructModel):
    def __init__(self, manager: Any, own_type: OwnType) -> None:
        numbers = [(name, _number(name)) for name in NUMBERS]
        super().__init__(manager, own_type, [("memory", types.CPointer(types.float64)), *numbers])


@type_callable(own)
def _type_of_own(context: Any) -> Any:
    return lambda memory: _OWN


@lower_builtin(own, types.Array)
def _own(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    memory = make_array(signature.args[0])(context, builder, arguments[0]).data
    made = cgutils.create_struct_proxy(_OWN)(context, builder)
    made.memory = memory
    for at, name in enumerate(NUMBERS):
        number = builder.load(builder.gep(memory, [context.get_constant(types.intp, at)]))
        if _number(name) is types.intp:
            number = builder.fptosi(number, context.get_value_type(types.intp))
        setattr(made, name, number)
    return made._getvalue()


@infer_getattr
class _OwnAttributes(AttributeTemplate):
    key = OwnType

    def generic_resolve(self, _: OwnType, name: str) -> types.Type | None:
        name = header_name(name)
        if name in ARRAYS:
            return types.Array(types.float64, len(_shape(name)), "C")
        if name not in NUMBERS:
            return None
        return types.boolean if name in FLAGS else _number(name)


def _shape(name: str) -> tuple[str, ...]:
    """Names of the sizes of an array's view; a table over the cycle is seen as this step's row."""
    return ARRAYS[name][1:] if ARRAYS[name][0] in TABLES else ARRAYS[name]


@lower_getattr_generic(OwnType)
def _attribute(context: Any, builder: Any, _: OwnType, value: Any, name: str) -> Any:
    name = header_name(name)
    seen = cgutils.create_struct_proxy(_OWN)(context, builder, value)
    number = getattr(seen, name)
    if name in FLAGS:
        return builder.icmp_signed("==", number, context.get_constant(types.intp, 1))
    if name not in ARRAYS:
        return number

    def size(of: str) -> Any:
        if of in SIZES:
            return context.get_constant(types.intp, SIZES[of])
        return getattr(seen, header_name(of))

    shape = [size(of) for of in _shape(name)]
    if ARRAYS[name][0] in TABLES:
        number = builder.add(number, builder.mul(seen.step, shape[0]))
    strides = [context.get_constant(types.intp, 8)]
    for length in shape[:0:-1]:
        strides.insert(0, builder.mul(length, strides[0]))
    array = make_array(types.Array(types.float64, len(shape), "C"))(context, builder)
    data = builder.gep(seen.memory, [number])
    populate_array(array, data=data, shape=shape, strides=strides, itemsize=8, meminfo=None)
    return array._getvalue()


@overload(views.vector)
def _vector(memory, start, size):  # type: ignore[no-untyped-def]
    """A view is built from its address: slicing as Numba does it takes as long as the law."""
    return lambda memory, start, size: carray(_address(memory, int(start)), size, np.float64)


@intrinsic
def _address(typing_context: Any, memory: Any, start: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.bitcast(builder.gep(array.data, [arguments[1]]), cgutils.voidptr_t)

    return types.voidptr(memory, types.intp), generate
