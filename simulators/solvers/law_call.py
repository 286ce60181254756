"""Calling a compiled function by its address from compiled code.

The address is a run-time value, so that one compiled loop serves every machine whatever its forces. (numba's own
function types do the same, but each call of the loop then costs a look-up in Python for each of them, and each place
of call seconds of compiling.)
"""

from __future__ import annotations

from typing import Any

from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np import arrayobj

from ..law import force_signature
from .kernel_types import PRODUCTS


def address_of(dispatcher: Any) -> int:
    """Return the address of a function compiled with one signature; valid as long as the dispatcher lives."""
    compiled = dispatcher.overloads[dispatcher.signatures[0]]
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)


def _call(context: Any, builder: Any, address: Any, own: Any, arguments: Any) -> Any:
    convention = context.call_conv
    pointer = builder.inttoptr(address, convention.get_function_type(types.none, own).as_pointer())
    convention.call_function(builder, pointer, types.none, own, arguments)
    return context.get_dummy_value()


@intrinsic
def call_force(typing, address, signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    """Call the force at ``address``."""
    own = force_signature().args

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        return _call(context, builder, arguments[0], own, arguments[1:])

    return types.void(types.int64, *own), generate


@intrinsic
def call_jump(typing, address, jump, work, plan, parameters, event, branches):  # type: ignore[no-untyped-def]
    """Call `kernel_jump.apply_jump` at ``address``."""
    own = (jump, work, plan, parameters, event, branches)

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        return _call(context, builder, arguments[0], own, arguments[1:])

    return types.void(types.int64, *own), generate


@intrinsic
def call_products(typing, address, memory, program, start, stop, lanes):  # type: ignore[no-untyped-def]
    """Call `product.add_products` at ``address``."""
    own = PRODUCTS.args

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        return _call(context, builder, arguments[0], own, arguments[1:])

    return types.void(types.int64, *own), generate


@intrinsic
def rows_of(typing, array, start, stop):  # type: ignore[no-untyped-def]
    """Return the rows from ``start`` to ``stop`` of an array, which must outlive them.

    As a slice, without the tests for indices that count from the end: these make half of the loop's code.
    """

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        whole = context.make_array(signature.args[0])(context, builder, arguments[0])
        part = context.make_array(signature.args[0])(context, builder)
        shape, strides = cgutils.unpack_tuple(builder, whole.shape), cgutils.unpack_tuple(builder, whole.strides)
        first = arguments[1]
        for size in shape[1:]:
            first = builder.mul(first, size)
        shape[0] = builder.sub(arguments[2], arguments[1])
        data = builder.gep(whole.data, [first])
        arrayobj.populate_array(part, data, shape, strides, whole.itemsize, None)
        return part._getvalue()

    return array(array, types.int64, types.int64), generate
