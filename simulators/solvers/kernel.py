"""The compiled inner loop of the exponential Runge-Kutta method, for many lanes at once.

Lanes are runs side by side on the same linear core with different forces, speeds or parameters. They are the last
index of every array, so that each arithmetic step is one vector operation over the lanes. One compiled loop serves
every machine: interface forces are called by their address.

All vectors of a step are rows of one work matrix, see `layout.Layout`, and the step is a short list of products between
them. Each part below is called at one place only, so that it is compiled once: the first run of a new installation
waits for it.
"""

from __future__ import annotations

import numba

from .kernel_types import (
    CUBE,
    DEEP,
    INDEX,
    INNER,
    JUMP,
    MATH,
    MATRIX,
    OPTIONS,
    PLAN,
    ROWS,
    SIGNALS,
    TABLE,
    VECTOR,
    compiled,
)
from .law_call import call_force, call_jump, call_products, clear_numbers, copy_numbers, numbers_of, rows_of


@numba.njit(**INNER)
def _evaluate_forces(plan, parameters, signals, instant, jumping, x, u):  # type: ignore[no-untyped-def]
    """Evaluate all interface forces, u = u(signals, C y); ``jumping`` are the signals of those that jump."""
    table, inputs, outputs, addresses = plan
    lanes, coefficients, own = u.shape[1], signals[1], signals[2][instant]
    copy_numbers(u, 0, signals[0], instant * u.size, u.size)  # type: ignore[call-arg]
    for k in range(table.shape[0]):
        kind, read, reads, act, acts, row, rows, first, last, jumps = numbers_of(table, k)  # type: ignore[call-arg,misc]
        if kind >= 0:
            call_force(  # type: ignore[call-arg]
                addresses[kind],
                rows_of(jumping if jumps >= 0 else own, row, rows),  # type: ignore[call-arg]
                rows_of(parameters, first, last),
                x,
                rows_of(inputs, read, reads),
                rows_of(outputs, act, acts),
                u,
            )
            continue
        # Without slices: each costs as much as a few products, and a single lane has only those.
        for i in range(act, acts):
            for j in range(read, reads):
                for lane in range(lanes):
                    u[outputs[i], lane] += coefficients[row, instant, lane] * x[inputs[j], lane]
                row += 1


@numba.njit(**INNER)
def _free_motion(work, flat, rows, diagonals):  # type: ignore[no-untyped-def]
    """Set the states after the step to e^(hL) y, and clear stages and probes; ``flat`` is the work matrix."""
    lanes = work.shape[1]
    first, following, stages = rows[4], rows[8], rows[6]
    clear_numbers(flat, stages * lanes, (following - stages) * lanes)  # type: ignore[call-arg]
    if lanes == 1:
        # The same sums: with the lanes innermost a single lane would fill no vector register.
        # As slices, whose indices cannot be negative: the compiler then takes several rows together.
        count = rows[0]
        low, here = rows_of(flat, first - 1, first + count), rows_of(flat, first, first + count)
        high, after = rows_of(flat, first + 1, first + count + 1), rows_of(flat, following, following + count)
        for i in range(rows[0]):
            total = diagonals[0, i] * low[i] + diagonals[1, i] * here[i]
            after[i] = total + diagonals[2, i] * high[i]
    else:
        for i in range(rows[0]):
            before, on, after = diagonals[0, i], diagonals[1, i], diagonals[2, i]
            for lane in range(lanes):
                total = before * work[first + i - 1, lane] + on * work[first + i, lane]
                work[following + i, lane] = total + after * work[first + i + 1, lane]


@numba.njit(**INNER)
def _products(memory, work, flat, rows, program, parts, stage):  # type: ignore[no-untyped-def]
    """Do what follows from the forces of a stage, at stage 0 also what follows from the states."""
    states, motions, forces = rows[0], rows[1], rows[2]
    stages, following = rows[6], rows[8]
    if stage == 3:
        # The weights of the update lie side by side: forces of one part of the machine then stay neighbours.
        u, last, lanes = rows[9], rows[9] + 4 * forces, work.shape[1]
        for i in range(forces):
            for lane in range(lanes):
                work[last + 3 * i, lane] = work[u + i, lane]
                work[last + 3 * i + 1, lane] = work[u + forces + i, lane] + work[u + 2 * forces + i, lane]
                work[last + 3 * i + 2, lane] = work[u + 3 * forces + i, lane]
    for part in range(stage + 1 if stage else 0, stage + 2):
        call_products(rows[10], memory, program, parts[part], parts[part + 1], work.shape[1])  # type: ignore[call-arg]
        if part == 0:
            # C e^(hL/2) y opens stages a and b, C e^(hL) y stage c and the motions of the next step.
            size = motions * work.shape[1]
            first, after = stages * work.shape[1], (following + states) * work.shape[1]
            copy_numbers(flat, first, flat, first + size, size)  # type: ignore[call-arg]
            copy_numbers(flat, after, flat, first + 2 * size, size)  # type: ignore[call-arg]


@compiled(
    numba.void(VECTOR, MATRIX, ROWS, TABLE, INDEX, MATRIX, PLAN, MATRIX, SIGNALS, JUMP, MATRIX, DEEP, CUBE),
    fastmath=MATH,
    **OPTIONS,
)
def run_block(memory, work, rows, program, parts, diagonals, plan, parameters, signals, jump, events, branches, record):  # type: ignore[no-untyped-def]
    """Advance the work matrix by as many steps as ``record`` has, and record the probes.

    Parameters
    ----------
    memory, work, rows, program, parts, diagonals : ndarray
        See `layout.Layout`. ``diagonals`` holds e^(hL) of a core with blocks of one or two rows: the diagonal before,
        on and after the main one.
    plan : tuple
        Ten numbers for each force, see `plan.ForcePlan`; inputs; outputs; addresses of the compiled forces.
    parameters : ndarray (parameters, lanes)
    signals : tuple
        ``pushes``, ``coefficients``, ``halves`` and ``jumped`` of `plan.BlockSignals`.
    jump : tuple
        See `layout.jump_layout`.
    events, branches
        See `plan.BlockSignals`; sorted by step.
    record : ndarray (steps, probes, lanes)
    """
    states, motions, forces, probes = rows[0], rows[1], rows[2], rows[3]
    lanes, flat = work.shape[1], rows_of(memory, memory.size - work.size, memory.size)  # type: ignore[call-arg]
    event = 0
    for step in range(record.shape[0]):
        for stage in range(4):
            # The motions lie in the order b, a, c: those that e^(hL/2) y and e^(hL) y open together.
            turned = 1 if stage == 1 else (0 if stage == 2 else 2)
            at_x = rows[5] if stage == 0 else rows[6] + turned * motions
            at_u = rows[9] + forces * stage
            half = (stage + 1) // 2
            x, u = rows_of(work, at_x, at_x + motions), rows_of(work, at_u, at_u + forces)
            _evaluate_forces(plan, parameters, signals, 2 * step + half, signals[3][step, half], x, u)
            if stage == 0:
                _free_motion(work, flat, rows, diagonals)
            _products(memory, work, flat, rows, program, parts, stage)
        copy_numbers(record, step * probes * lanes, flat, rows[7] * lanes, probes * lanes)  # type: ignore[call-arg]
        while event < events.shape[0] and events[event, 0] == step:
            call_jump(jump[0][0], jump, work, plan, parameters, events[event], branches[event])  # type: ignore[call-arg]
            event += 1
        copy_numbers(flat, rows[4] * lanes, flat, rows[8] * lanes, (states + motions) * lanes)  # type: ignore[call-arg]
