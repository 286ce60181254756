"""Compiled correction of a step in which a force jumps.

The stages of the step continue the branch of its start. What the new branch adds from the jump to the end of the step
then follows from tables of the integrals of e^(L s) (see `tables.JumpTables`). Order four at every jump: the force
difference is a quadratic through three instants, on the motion that it has changed itself.

What depends on the instant only comes with the event (see `jumps.SHAPE`): the weights of the cubic and the quadratic,
and the place in the tables.
"""

from __future__ import annotations

import numba
import numpy as np

from .kernel_types import CUBE, HIDDEN, INNER, JUMP, MATRIX, PLAN, VECTOR, compiled
from .law_call import call_force, numbers_of, rows_of


@numba.njit(**INNER)
def _smooth_motion(jump, work, reads, lane, event, room, at):  # type: ignore[no-untyped-def]
    """Set the motion at the jump, half-way and at the end: the cubic through both ends of the step without a jump.

    ``reads`` numbers k displacements, then their k velocities; the result stands in ``room`` from row ``at`` on, and
    once more behind it.
    """
    count = reads.size
    half = count // 2
    for row in range(6):
        for i in range(half):
            total = 0.0
            for k in range(4):
                # Displacement at the start and at the end, then the velocities.
                total += event[4 + 4 * row + k] * work[jump[0][1 + k % 2] + reads[k // 2 * half + i], lane]
            room[at + row * half + i, 0] = room[at + 3 * count + row * half + i, 0] = total


@numba.njit(**INNER)
def _weigh(event, room, forces, wide):  # type: ignore[no-untyped-def]
    """Set behind the forces the quadratic g0 + a s + b s^2 / 2 through the difference of both branches."""
    for row in range(3):
        for j in range(wide):
            total = 0.0
            for k in range(3):
                old = forces + k * wide + j
                total += event[28 + 3 * row + k] * (room[old + 3 * wide, 0] - room[old, 0])
            room[forces + (6 + row) * wide + j, 0] = total


@numba.njit(**INNER)
def _integrate(tables, point, s, first, count, room, weights, many, at, base):  # type: ignore[no-untyped-def]
    """Set rows of ``room`` to those at ``base`` plus sum P_k(tau) weights, k = 1 to 3, by the cubics of the tables.

    ``first`` and ``count`` say which rows of the tables.
    """
    for i in range(count):
        room[at + i, 0] = room[base + i, 0]
    for column in range(many):
        value = room[weights + column, 0]
        for power in range(4):
            for i in range(count):
                room[at + i, 0] += tables[point, 4 * column + power, first + i] * value
            value *= s


@compiled(numba.void(JUMP, MATRIX, PLAN, MATRIX, VECTOR, CUBE), **HIDDEN)
def apply_jump(jump, work, plan, parameters, event, branches):  # type: ignore[no-untyped-def]
    """Correct one lane's state and motions at the end of a step for the jump of one force inside it.

    Parameters as in `kernel.run_block`; ``jump`` is made by `layout.jump_layout`.
    """
    numbers, tables, room = jump
    table, inputs, address = plan[0], plan[1], plan[3]
    lane, which = np.int64(event[1]), np.int64(event[2])
    end, height, count, wide = numbers[3], numbers[4], numbers[5], numbers[6]
    kind, read, reads, _, _, _, _, given, last, _ = numbers_of(table, numbers[7 + which])  # type: ignore[call-arg,misc]
    own = last - given
    forces = own + 6 * count
    zero = forces + 9 * wide
    order = rows_of(numbers, numbers.size - (count if count > wide else wide), numbers.size)  # type: ignore[call-arg]
    for i in range(own):
        room[i, 0] = parameters[given + i, lane]
    _smooth_motion(jump, work, rows_of(inputs, read, reads), lane, event, room, own)
    for sweep in range(3):
        for side in range(6):
            at = forces + side * wide
            for j in range(wide):
                room[at + j, 0] = 0.0
            # Three instants on the old branch and the smooth motion, then on the new branch and the moved one.
            x = rows_of(room, own + side * count, own + (side + 1) * count)
            u = rows_of(room, at, at + wide)
            call_force(address[kind], branches[side], rows_of(room, 0, own), x, order, order, u)  # type: ignore[call-arg]
        _weigh(event, room, forces, wide)
        for part in range(1, 3 if sweep < 2 else 2):
            # Half-way and at the end; at last all states at the end.
            base, at, first, rows, place = own + part * count, own + (3 + part) * count, 0, count, 35 + 2 * part
            if sweep == 2:
                base, at, first, rows, place = zero, zero + height, count, height, 39
            _integrate(
                tables,
                np.int64(event[place]),
                event[place + 1],
                first,
                rows,
                room,
                forces + 6 * wide,
                3 * wide,
                at,
                base,
            )
    for i in range(height):
        work[end + i, lane] += room[zero + height + i, 0]
