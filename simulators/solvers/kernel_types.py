"""Types and options of the compiled loop. With the types given, it is compiled once and for all arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

from ..compiled_code import njit
from ..law import no_collecting

#: Sums may use fused multiply-add: the result does not depend on the number of lanes.
MATH = {"contract"}
OPTIONS: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "nogil": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}
#: Of a function that only compiled code calls, by its address: what Python would need is a sixth of its compiling.
HIDDEN: dict[str, Any] = {**OPTIONS, "no_cpython_wrapper": True}
#: Parts of one function, each called at one place: put in before it is compiled, they are not compiled by themselves.
INNER: dict[str, Any] = {"error_model": "numpy", "nogil": True, "inline": "always"}

VECTOR, MATRIX, CUBE = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
DEEP, INDEX, TABLE = numba.float64[:, :, :, ::1], numba.int64[::1], numba.int64[:, ::1]
#: Plan of the forces, inputs, outputs and addresses of the compiled forces.
PLAN = numba.types.Tuple((TABLE, INDEX, INDEX, INDEX))
#: `layout.Layout.rows`: as a tuple, as each look into an array costs the compiler ten times as much.
ROWS = numba.types.UniTuple(numba.int64, 11)
#: Whole numbers, tables, room to work.
JUMP = numba.types.Tuple((INDEX, CUBE, MATRIX))
#: `plan.BlockSignals`: pushes, coefficients, halves, jumped.
SIGNALS = numba.types.Tuple((CUBE, CUBE, CUBE, DEEP))
#: `product.add_products`: memory, program, its rows from and to, lanes.
PRODUCTS = numba.types.void(VECTOR, TABLE, numba.int64, numba.int64, numba.int64)


def compiled(signature: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function for one signature, at once."""

    def decorate(function: Callable[..., Any]) -> Any:
        with no_collecting():
            return njit(signature, **options)(function)

    return decorate
