"""Calling a compiled function by its address from compiled code.

The address is a run-time value, so that one compiled loop serves every machine whatever its forces. (numba's own
function types do the same, but each call of the loop then costs a look-up in Python for each of them, and each place
of call seconds of compiling.)
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
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


@intrinsic
def numbers_of(typing, table, row):  # type: ignore[no-untyped-def]
    """Return the ten whole numbers of a row of `plan.ForcePlan.rows`."""

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        start = builder.mul(arguments[1], ir.Constant(arguments[1].type, 10))
        places = [builder.add(start, ir.Constant(start.type, i)) for i in range(10)]
        return context.make_tuple(
            builder, signature.return_type, [builder.load(builder.gep(data, [own])) for own in places]
        )

    return types.UniTuple(types.int64, 10)(table, types.int64), generate


@intrinsic
def copy_numbers(typing, target, start, source, begin, count):  # type: ignore[no-untyped-def]
    """Copy so many neighbouring numbers; as a loop it would be compiled for every case of overlapping arrays."""

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        ends = [context.make_array(signature.args[i])(context, builder, arguments[i]).data for i in (0, 2)]
        into, out_of = (builder.gep(end, [at]) for end, at in zip(ends, (arguments[1], arguments[3]), strict=True))
        cgutils.raw_memmove(builder, into, out_of, arguments[4], ir.Constant(arguments[4].type, 8))
        return context.get_dummy_value()

    return types.void(target, types.int64, source, types.int64, types.int64), generate


@intrinsic
def clear_numbers(typing, target, start, count):  # type: ignore[no-untyped-def]
    """Set so many neighbouring numbers to zero."""

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        size = builder.mul(arguments[2], ir.Constant(arguments[2].type, 8))
        cgutils.memset(builder, builder.gep(data, [arguments[1]]), size, 0)
        return context.get_dummy_value()

    return types.void(target, types.int64, types.int64), generate
