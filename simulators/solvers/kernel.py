"""The compiled inner loop of the exponential Runge-Kutta method, for many lanes at once.

Lanes are runs side by side on the same linear core with different forces, speeds or parameters. They are the last
index of every array, so that each arithmetic step is one vector operation over the lanes. One compiled loop serves
every machine: interface forces are called through a tuple of functions of one signature.
"""

from __future__ import annotations

import numba
import numpy as np

from .kernel_jump import apply_jump
from .kernel_parts import MATH, OPTIONS, add_product, clear, copy, evaluate_forces

#: One-element tuples make numba call through a pointer instead of inlining.
PARTS = ((add_product,), (evaluate_forces,), (apply_jump,))

_LOOP = {**OPTIONS, "no_cfunc_wrapper": True}


@numba.njit(fastmath=MATH, **_LOOP)
def run_block(
    parts, laws, plan, inputs, outputs, parameters, step_s, tables, jump, signals, events, branches, y, record
):  # type: ignore[no-untyped-def]
    """Advance the states ``y`` (n, lanes) in place by as many steps as ``signals`` has, and record the probes.

    Parameters
    ----------
    parts : tuple
        `PARTS`.
    laws : tuple of compiled forces
    plan : ndarray of int (forces, 9)
        Kind (-1 linear, else index in ``laws``), then start and stop in inputs, outputs, signals, parameters.
    tables : tuple
        full, first, last (n x n and the columns that count), then as pairs (transpose, itself): ``ahead``, the rows
        C e^(hL/2), C e^(hL) and of the probes over the states; ``stages``, five; ``update``, three, each with the rows
        of C times it below; ``motion_rows``; ``probe_columns``.
    jump : tuple
        spacing, states (jump forces, 4, points, n, j), rows (jump forces, 4, points, 2k, j).
    signals : ndarray (steps, 3, signals, lanes)
    events : ndarray (events, 4)
        Step, lane, number of the jump force, time left; sorted by step.
    branches : ndarray (events, 3, 2, signals of that force, 1)
    record : ndarray (steps, probes, lanes)
    """
    product, forces, correct = parts[0][0], parts[1][0], parts[2][0]
    full, first, last, ahead, stages, update, motion_rows, probe_columns = tables
    n, lanes = y.shape
    p, m = motion_rows[0].shape[1], stages[0][0].shape[0]
    x, stage = np.zeros((p, lanes)), np.zeros((p, lanes))
    u1, u2, u3, u4 = np.zeros((m, lanes)), np.zeros((m, lanes)), np.zeros((m, lanes)), np.zeros((m, lanes))
    known, following = np.zeros((ahead[0].shape[1], lanes)), np.zeros((n + p, lanes))
    half, whole, seen, ahead_of = known[:p], known[p : 2 * p], known[2 * p :], (following[:n], following[n:])
    event = 0
    product(motion_rows, y, x)
    for step in range(signals.shape[0]):
        forces(laws, plan, inputs, outputs, signals[step, 0], parameters, x, u1)
        clear(known)
        product(ahead, y, known)
        copy(seen, record[step])
        product(probe_columns, u1, record[step])
        copy(half, stage)
        product(stages[0], u1, stage)
        forces(laws, plan, inputs, outputs, signals[step, 1], parameters, stage, u2)
        copy(half, stage)
        product(stages[1], u1, stage)
        product(stages[2], u2, stage)
        forces(laws, plan, inputs, outputs, signals[step, 1], parameters, stage, u3)
        copy(whole, stage)
        product(stages[3], u1, stage)
        product(stages[4], u3, stage)
        forces(laws, plan, inputs, outputs, signals[step, 2], parameters, stage, u4)
        for i in range(n):
            for lane in range(lanes):
                following[i, lane] = 0.0
            for j in range(first[i], last[i]):
                weight = full[i, j]
                for lane in range(lanes):
                    following[i, lane] += weight * y[j, lane]
        copy(whole, ahead_of[1])
        for i in range(m):
            for lane in range(lanes):
                u2[i, lane] += u3[i, lane]
        product(update[0], u1, following)
        product(update[1], u2, following)
        product(update[2], u4, following)
        while event < events.shape[0] and events[event, 0] == step:
            correct(
                laws, plan, inputs, parameters, step_s, jump, events[event], branches[event], motion_rows, x, following
            )  # fmt: skip
            event += 1
        copy(ahead_of[0], y)
        copy(ahead_of[1], x)
