"""Compiled correction of a step in which a force jumps.

The stages of the step continue the branch of its start. What the new branch adds from the jump to the end of the step
then follows from tables of the integrals of e^(L s) (see `tables.JumpTables`). Order four at every jump: the force
difference is a quadratic through three instants, on the motion that it has changed itself.
"""

from __future__ import annotations

import numba
import numpy as np

from .kernel_types import CUBE, HIDDEN, INNER, JUMP, MATRIX, PLAN, VECTOR, compiled
from .law_call import call_force, rows_of


@numba.njit(**INNER)
def _smooth_motion(jump, work, reads, lane, tau, room, at):  # type: ignore[no-untyped-def]
    """Set the motion at the jump, half-way and at the end: the cubic through both ends of the step without a jump.

    ``reads`` numbers k displacements, then their k velocities; the result stands in ``room`` from row ``at`` on, and
    once more behind it.
    """
    start, end, step = jump[0][2], jump[0][3], jump[1][0]
    count = reads.size
    half = count // 2
    for stage in range(3):
        s = 1.0 - tau / step * (1.0 - 0.5 * stage)
        for i in range(half):
            d0, d1 = work[start + reads[i], lane], work[end + reads[i], lane]
            v0, v1 = step * work[start + reads[half + i], lane], step * work[end + reads[half + i], lane]
            bend, twist = 3 * (d1 - d0) - 2 * v0 - v1, 2 * (d0 - d1) + v0 + v1
            row = at + stage * count + i
            room[row, 0] = d0 + s * (v0 + s * (bend + s * twist))
            room[row + half, 0] = (v0 + s * (2 * bend + 3 * s * twist)) / step
    for row in range(at, at + 3 * count):
        room[row + 3 * count, 0] = room[row, 0]


@numba.njit(**INNER)
def _weigh(room, at, wide, tau):  # type: ignore[no-untyped-def]
    """Replace the forces on the old branch by the quadratic g0 + a s + b s^2 / 2 through the force difference."""
    for j in range(at, at + wide):
        g0 = room[j + 3 * wide, 0] - room[j, 0]
        g1 = room[j + 4 * wide, 0] - room[j + wide, 0]
        g2 = room[j + 5 * wide, 0] - room[j + 2 * wide, 0]
        room[j, 0] = g0
        room[j + wide, 0] = (-3 * g0 + 4 * g1 - g2) / tau
        room[j + 2 * wide, 0] = 4 * (g0 - 2 * g1 + g2) / (tau * tau)


@numba.njit(**INNER)
def _integrate(tables, spacing, first, points, tau, weights, low, high, room, at, base):  # type: ignore[no-untyped-def]
    """Set rows of ``room`` to those at ``base`` plus sum P_k(tau) weights, k = 1 to 3, by cubic interpolation.

    The derivative of P_k is P_(k-1). ``low`` to ``high`` are the rows of the tables.
    """
    point = np.int64(tau / spacing)
    if point > points - 2:
        point = points - 2
    s = tau / spacing - point
    point += first
    h00, h10 = (1 + 2 * s) * (1 - s) * (1 - s), s * (1 - s) * (1 - s) * spacing
    h01, h11 = s * s * (3 - 2 * s), s * s * (s - 1) * spacing
    wide = tables.shape[3]
    for i in range(low, high):
        total = room[base + i - low, 0]
        for power in range(1, 4):
            for j in range(wide):
                value = h00 * tables[power, point, i, j] + h10 * tables[power - 1, point, i, j]
                value += h01 * tables[power, point + 1, i, j] + h11 * tables[power - 1, point + 1, i, j]
                total += value * room[weights + (power - 1) * wide + j, 0]
        room[at + i - low, 0] = total


@compiled(numba.void(JUMP, MATRIX, PLAN, MATRIX, VECTOR, CUBE), **HIDDEN)
def apply_jump(jump, work, plan, parameters, event, branches):  # type: ignore[no-untyped-def]
    """Correct one lane's state and motions at the end of a step for the jump of one force inside it.

    Parameters as in `kernel.run_block`; ``jump`` is made by `layout.jump_layout`.
    """
    # Python's own int, min and max are compiled as functions of their own.
    lane, which, tau = np.int64(event[1]), np.int64(event[2]), event[3]
    # A jump on the end of the step, as a mesh in a whole ratio to the step makes, has no time to act in it.
    if tau <= 0.0:
        return
    numbers, tables, room = jump[0], jump[2], jump[3]
    table, inputs, address = plan[0], plan[1], plan[3]
    points, end, height, k = numbers[1], numbers[4], numbers[5], numbers[6 + which]
    count, wide = table[k, 2] - table[k, 1], tables.shape[3]
    own = table[k, 8] - table[k, 7]
    smooth, moved, forces, zero = own, own + 3 * count, own + 6 * count, own + 6 * count + 6 * wide
    order = rows_of(numbers, numbers.size - (count if count > wide else wide), numbers.size)  # type: ignore[call-arg]
    for i in range(own):
        room[i, 0] = parameters[table[k, 7] + i, lane]
    _smooth_motion(jump, work, rows_of(inputs, table[k, 1], table[k, 2]), lane, tau, room, smooth)
    for sweep in range(3):
        for side in range(6):
            at = forces + side * wide
            for j in range(wide):
                room[at + j, 0] = 0.0
            # Three instants on the old branch and the smooth motion, then on the new branch and the moved one.
            x = rows_of(room, smooth + side * count, smooth + (side + 1) * count)
            u = rows_of(room, at, at + wide)
            call_force(address[table[k, 0]], branches[side], rows_of(room, 0, own), x, order, order, u)  # type: ignore[call-arg]
        _weigh(room, forces, wide, tau)
        for part in range(2 if sweep < 2 else 1):
            if sweep < 2:
                base, at, low, high, left = smooth, moved, 0, count, 0.5 * tau * (part + 1)
                base += (part + 1) * count
                at += (part + 1) * count
            else:
                base, at, low, high, left = zero, zero + height, count, count + height, tau
            _integrate(tables, jump[1][1], which * points, points, left, forces, low, high, room, at, base)
    for i in range(height):
        work[end + i, lane] += room[zero + height + i, 0]
