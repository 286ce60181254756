"""Compiled parts of the stepping loop: matrix products over the lanes, and the interface forces.

Each is compiled by itself and called through a pointer: inlined into the loop they would be optimised again at every
place, which made the first run of a new installation take half a minute.
"""

from __future__ import annotations

from typing import Any

import numba

from ..law import force_signature

#: Sums may use fused multiply-add: the result does not depend on the number of lanes.
MATH = {"contract"}
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "nogil": True}
#: Functions that only compiled code calls need no way in from Python; each costs compile time.
INNER: dict[str, Any] = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

_MATRIX = numba.float64[:, ::1]
_INDEX = numba.int64[::1]
#: As many kinds of compiled force a machine may have; more need one more compilation.
KINDS = 16
PAIR = numba.types.UniTuple(_MATRIX, 2)
LAWS = numba.types.UniTuple(numba.types.FunctionType(force_signature()), KINDS)


@numba.njit(numba.void(PAIR, _MATRIX, _MATRIX), fastmath=MATH, **OPTIONS)
def add_product(matrix, vectors, result):  # type: ignore[no-untyped-def]
    """Do result += matrix @ vectors, lanes last; ``matrix`` is (transpose, itself).

    Every sum runs over the columns in order, whatever the number of lanes, so that lanes do not change a run's bits.
    A single lane is done column by column: then the rows, not the lanes, fill the vector registers. Four columns at
    a time keep the running sums in registers.
    """
    columns, rows = matrix[0].shape
    if vectors.shape[1] == 1:
        own, sums = vectors[:, 0], result[:, 0]
        for j in range(columns):
            value = own[j]
            for i in range(rows):
                sums[i] += matrix[0][j, i] * value
        return
    whole = columns - columns % 4
    for i in range(rows):
        row, sums = matrix[1][i], result[i]
        for j in range(0, whole, 4):
            a, b, c, d = row[j], row[j + 1], row[j + 2], row[j + 3]
            for lane in range(sums.size):
                total = sums[lane] + a * vectors[j, lane]
                total = total + b * vectors[j + 1, lane]
                total = total + c * vectors[j + 2, lane]
                sums[lane] = total + d * vectors[j + 3, lane]
        for j in range(whole, columns):
            for lane in range(sums.size):
                sums[lane] += row[j] * vectors[j, lane]


@numba.njit(**INNER)
def copy(source, target):  # type: ignore[no-untyped-def]
    """Copy a matrix; written out, as compiling numba's array assignment takes seconds."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@numba.njit(**INNER)
def clear(target):  # type: ignore[no-untyped-def]
    """Set a matrix to zero."""
    for i in range(target.shape[0]):
        for j in range(target.shape[1]):
            target[i, j] = 0.0


@numba.njit(
    numba.void(LAWS, numba.int64[:, ::1], _INDEX, _INDEX, _MATRIX, _MATRIX, _MATRIX, _MATRIX), fastmath=MATH, **OPTIONS
)
def evaluate_forces(laws, plan, inputs, outputs, signals, parameters, x, u):  # type: ignore[no-untyped-def]
    """Evaluate all interface forces: u = u(signals, C y)."""
    lanes = u.shape[1]
    copy(signals[: u.shape[0]], u)
    for k in range(plan.shape[0]):
        if plan[k, 0] >= 0:
            laws[plan[k, 0]](
                signals[plan[k, 5] : plan[k, 6]],
                parameters[plan[k, 7] : plan[k, 8]],
                x,
                inputs[plan[k, 1] : plan[k, 2]],
                outputs[plan[k, 3] : plan[k, 4]],
                u,
            )
            continue
        # Without slices: each costs as much as a few products, and a single lane has only those.
        row = plan[k, 5]
        for i in range(plan[k, 3], plan[k, 4]):
            for j in range(plan[k, 1], plan[k, 2]):
                for lane in range(lanes):
                    u[outputs[i], lane] += signals[row, lane] * x[inputs[j], lane]
                row += 1
