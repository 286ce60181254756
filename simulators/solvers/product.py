"""The matrix product of a step, written in the compiler's own terms.

Left to numba's loop vectoriser, each short inner loop starts with tests whether its arrays overlap, which cost more
than the sums. Here the sums of a tile stay in registers over all columns. They run over the columns in the same order
in every tile, so that the number of lanes does not change a run's bits.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from .kernel_types import OPTIONS, PRODUCTS, compiled

#: Rows of a single lane that are summed together; tables are filled up to the smallest.
HEIGHTS = (32, 8, 4)
#: Rows and lanes that are summed together; lanes that are left over by the next smaller number.
TILE_ROWS, TILE_LANES = 4, (8, 4, 2, 1)
_DOUBLE, _WORD = ir.DoubleType(), ir.IntType(64)


class _Tile:
    """Builds sums of several rows, each a vector of neighbouring numbers."""

    def __init__(self, builder: Any, base: Any, columns: Any) -> None:
        self.builder, self.base, self.columns = builder, base, columns

    def pointer(self, place: Any, width: int) -> Any:
        at = self.builder.gep(self.base, [place])
        return self.builder.bitcast(at, ir.VectorType(_DOUBLE, width).as_pointer()) if width > 1 else at

    def broadcast(self, value: Any, width: int) -> Any:
        if width == 1:
            return value
        kind = ir.VectorType(_DOUBLE, width)
        first = self.builder.insert_element(ir.Constant(kind, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
        order = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
        return self.builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), order)

    def add(self, results: list[Any], weights: list[Any], step: Any, values: Any, stride: Any, width: int) -> None:
        """Do results[i] += sum over the columns j of memory[weights[i] + j step] memory[values + j stride ...].

        Even and odd columns are summed apart, as a sum must wait for the one before.
        """
        builder = self.builder
        kind = ir.VectorType(_DOUBLE, width) if width > 1 else _DOUBLE
        even = [cgutils.alloca_once(builder, kind) for _ in results]
        odd = [cgutils.alloca_once(builder, kind) for _ in results]
        for result, kept, other in zip(results, even, odd, strict=True):
            builder.store(builder.load(self.pointer(result, width), align=8), kept)
            builder.store(ir.Constant(kind, None), other)

        def add_column(sums: list[Any], column: Any) -> None:
            own = builder.load(self.pointer(builder.add(values, builder.mul(column, stride)), width), align=8)
            for kept, weight in zip(sums, weights, strict=True):
                factor = builder.load(self.pointer(builder.add(weight, builder.mul(column, step)), 1))
                product = builder.fmul(self.broadcast(factor, width), own, flags=("contract",))
                builder.store(builder.fadd(builder.load(kept), product, flags=("contract",)), kept)

        one = ir.Constant(_WORD, 1)
        with cgutils.for_range(builder, builder.lshr(self.columns, one), intp=_WORD) as loop:
            first = builder.shl(loop.index, one)
            add_column(even, first)
            add_column(odd, builder.add(first, one))
        with builder.if_then(builder.trunc(self.columns, ir.IntType(1))):
            add_column(even, builder.sub(self.columns, one))
        for result, kept, other in zip(results, even, odd, strict=True):
            total = builder.fadd(builder.load(kept), builder.load(other))
            builder.store(total, self.pointer(result, width), align=8)


def _blocks(builder: Any, start: Any, stop: Any, width: int) -> Any:
    """Return a loop over the blocks of ``width`` that fit between start and stop, and where the rest starts."""
    size = ir.Constant(_WORD, width)
    count = builder.sdiv(builder.sub(stop, start), size)
    return cgutils.for_range(builder, count, intp=_WORD), builder.add(start, builder.mul(count, size))


def _single_lane(tile: _Tile, source: Any, target: Any, height: Any, at: Any) -> None:
    builder, one, start = tile.builder, ir.Constant(_WORD, 1), ir.Constant(_WORD, 0)
    for width in HEIGHTS:
        loop, rest = _blocks(builder, start, height, width)
        with loop as turn:
            row = builder.add(start, builder.mul(turn.index, ir.Constant(_WORD, width)))
            tile.add([builder.add(target, row)], [source], one, builder.add(at, row), height, width)
        start = rest


def _many_lanes(tile: _Tile, source: Any, target: Any, height: Any, at: Any, lanes: Any) -> None:
    builder, one, zero = tile.builder, ir.Constant(_WORD, 1), ir.Constant(_WORD, 0)
    with _blocks(builder, zero, height, TILE_ROWS)[0] as rows:
        row = builder.mul(rows.index, ir.Constant(_WORD, TILE_ROWS))
        some = [builder.add(row, ir.Constant(_WORD, i)) for i in range(TILE_ROWS)]
        weights = [builder.add(at, builder.mul(own, tile.columns)) for own in some]
        start = zero
        for width in TILE_LANES:
            loop, rest = _blocks(builder, start, lanes, width)
            with loop as turn:
                lane = builder.add(start, builder.mul(turn.index, ir.Constant(_WORD, width)))
                results = [builder.add(builder.add(target, builder.mul(own, lanes)), lane) for own in some]
                tile.add(results, weights, one, builder.add(source, lane), lanes, width)
            start = rest


@intrinsic
def _add_product(typing, memory, source, columns, target, height, at, lanes):  # type: ignore[no-untyped-def]
    """Do target += matrix @ source; all are places in ``memory``.

    With several lanes the matrix (height, columns) is stored row by row and source and target (rows, lanes) as well;
    with a single lane the matrix is stored column by column.
    """

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        base = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        source, columns, target, height, at, lanes = arguments[1:]
        tile = _Tile(builder, base, columns)
        with builder.if_else(builder.icmp_signed("==", lanes, ir.Constant(_WORD, 1))) as (single, many):
            with single:
                _single_lane(tile, source, target, height, at)
            with many:
                _many_lanes(tile, source, target, height, at, lanes)
        return context.get_dummy_value()

    return types.void(memory, *([types.int64] * 6)), generate


@compiled(PRODUCTS, **OPTIONS)
def add_products(memory, program, start, stop, lanes):  # type: ignore[no-untyped-def]
    """Do the products ``start`` to ``stop`` - 1 of a program, see `layout.Layout`, for so many lanes."""
    for number in range(start, stop):
        source, columns, target, height, at = program[number]
        _add_product(memory, source, columns, target, height, at, lanes)  # type: ignore[call-arg]
