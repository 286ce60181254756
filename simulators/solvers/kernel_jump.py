"""Compiled correction of a step in which a force jumps.

The stages of the step continue the branch of its start. What the new branch adds from the jump to the end of the step
then follows from tables of the integrals of e^(L s) (see `tables.JumpTables`). Order four at every jump: the force
difference is a quadratic through three instants, on the motion that it has changed itself.
"""

from __future__ import annotations

import numba
import numpy as np

from .kernel_parts import INNER, LAWS, OPTIONS, PAIR, clear, copy

_MATRIX, _CUBE, _INDEX = numba.float64[:, ::1], numba.float64[:, :, ::1], numba.int64[::1]
_DEEP, _DEEPEST = numba.float64[:, :, :, ::1], numba.float64[:, :, :, :, ::1]
#: Spacing, tables of the states and of the motions, numbers of the forces; then room to work in, see `jump_work`.
_JUMP = numba.types.Tuple(
    (numba.float64, _DEEPEST, _DEEPEST, _INDEX, _INDEX, _MATRIX, _DEEP, _CUBE, _MATRIX, _MATRIX, _MATRIX)
)


def jump_work(states: int, motions: int, columns: int, parameters: int) -> tuple[np.ndarray, ...]:
    """Return room to work in: making arrays inside compiled code costs seconds of compiling at every place.

    Index numbers from 0; motions at both ends; smooth and moved motion; forces; weights; change of the states; own
    parameters.
    """
    return (
        np.arange(max(motions, columns), dtype=np.int64),
        np.zeros((2, motions)),
        np.zeros((2, 3, motions, 1)),
        np.zeros((3, columns, 1)),
        np.zeros((3, columns)),
        np.zeros((states, 1)),
        np.zeros((parameters, 1)),
    )


@numba.njit(**INNER)
def _add_hermite(tables, k, spacing, tau, weights, result):  # type: ignore[no-untyped-def]
    """Do result += P_k(tau) weights, by cubic interpolation; the derivative of P_k is P_(k-1)."""
    at = min(int(tau / spacing), tables.shape[1] - 2)
    s = tau / spacing - at
    h00, h10 = (1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2 * spacing
    h01, h11 = s * s * (3 - 2 * s), s * s * (s - 1) * spacing
    for i in range(result.shape[0]):
        for j in range(weights.shape[1]):
            value = h00 * tables[k, at, i, j] + h10 * tables[k - 1, at, i, j]
            value += h01 * tables[k, at + 1, i, j] + h11 * tables[k - 1, at + 1, i, j]
            result[i, 0] += value * weights[k - 1, j]


@numba.njit(**INNER)
def _smooth_motion(start, end, step, tau, motion):  # type: ignore[no-untyped-def]
    """Set the motion at the jump, half-way and at the end: the cubic through both ends of the step without a jump.

    ``start`` and ``end`` hold k displacements, then their k velocities.
    """
    count = start.size // 2
    for stage in range(3):
        s = 1.0 - tau / step * (1.0 - 0.5 * stage)
        for i in range(count):
            d0, d1, v0, v1 = start[i], end[i], step * start[count + i], step * end[count + i]
            bend, twist = 3 * (d1 - d0) - 2 * v0 - v1, 2 * (d0 - d1) + v0 + v1
            motion[stage, i, 0] = d0 + s * (v0 + s * (bend + s * twist))
            motion[stage, count + i, 0] = (v0 + s * (2 * bend + 3 * s * twist)) / step


@numba.njit(**INNER)
def _difference(law, branches, own, smooth, moved, number, tau, g, weights):  # type: ignore[no-untyped-def]
    """Set the weights of the quadratic g0 + a s + b s^2 / 2 through the force difference at three instants.

    New branch on the moved motion less old branch on the smooth one.
    """
    for stage in range(3):
        u = g[stage]
        clear(u)
        law(branches[stage, 0], own, smooth[stage], number, number, u)
        for j in range(u.shape[0]):
            u[j, 0] = -u[j, 0]
        law(branches[stage, 1], own, moved[stage], number, number, u)
    for j in range(g.shape[1]):
        weights[0, j] = g[0, j, 0]
        weights[1, j] = (-3 * g[0, j, 0] + 4 * g[1, j, 0] - g[2, j, 0]) / tau
        weights[2, j] = 4 * (g[0, j, 0] - 2 * g[1, j, 0] + g[2, j, 0]) / tau**2


@numba.njit(
    numba.void(
        LAWS, numba.int64[:, ::1], numba.int64[::1], numba.float64[:, ::1], numba.float64, _JUMP, numba.float64[::1],
        numba.float64[:, :, :, ::1], PAIR, numba.float64[:, ::1], numba.float64[:, ::1],
    ),
    **OPTIONS,
)  # fmt: skip
def apply_jump(laws, plan, inputs, parameters, step_s, jump, event, branches, motion_rows, x, following):  # type: ignore[no-untyped-def]
    """Correct one lane's state and motions at the end of a step for the jump of one force inside it.

    Parameters as in `kernel.run_block`; ``following`` holds the states, then the motions, at the end of the step.
    """
    lane, which, tau = int(event[1]), int(event[2]), event[3]
    # A jump on the end of the step, as a mesh in a whole ratio to the step makes, has no time to act in it.
    if tau <= 0.0:
        return
    k, spacing, states, rows = jump[3][which], jump[0], jump[1][which], jump[2][which]
    n, first, count = states.shape[2], plan[k, 1], plan[k, 2] - plan[k, 1]
    number, ends, motion, g, weights, change, room = jump[4], jump[5], jump[6], jump[7], jump[8], jump[9], jump[10]
    own = room[: plan[k, 8] - plan[k, 7]]
    for i in range(own.shape[0]):
        own[i, 0] = parameters[plan[k, 7] + i, lane]
    for i in range(count):
        ends[0, i], ends[1, i] = x[inputs[first + i], lane], following[n + inputs[first + i], lane]
    smooth, moved = motion[0], motion[1]
    _smooth_motion(ends[0], ends[1], step_s, tau, smooth)
    for stage in range(3):
        copy(smooth[stage], moved[stage])
    law = laws[plan[k, 0]]
    for sweep in range(3):
        _difference(law, branches, own, smooth, moved, number, tau, g, weights)
        for stage in range(1, 3 if sweep < 2 else 1):
            copy(smooth[stage], moved[stage])
            for power in range(1, 4):
                _add_hermite(rows, power, spacing, 0.5 * tau * stage, weights, moved[stage])
    clear(change)
    for power in range(1, 4):
        _add_hermite(states, power, spacing, tau, weights, change)
    for i in range(n):
        following[i, lane] += change[i, 0]
    for i in range(x.shape[0]):
        total = 0.0
        for j in range(n):
            total += motion_rows[1][i, j] * following[j, lane]
        following[n + i, lane] = total
