"""The compiled inner loop of the exponential Runge-Kutta method, for many lanes at once.

Lanes are runs side by side on the same linear core with different forces, speeds or parameters. They are the last
index of every array, so that each arithmetic step is one vector operation over the lanes. One compiled loop serves
every machine: interface forces are called through a tuple of functions of one signature.
"""

from __future__ import annotations

import numba
import numpy as np

#: Sums may use fused multiply-add: the result does not depend on the number of lanes.
_MATH = {"contract"}


@numba.njit(cache=True, fastmath=_MATH, error_model="numpy", nogil=True)
def _add_product(matrix, vectors, result):  # type: ignore[no-untyped-def]
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


@numba.njit(cache=True, fastmath=_MATH, error_model="numpy", nogil=True)
def _forces(laws, plan, inputs, outputs, signals, parameters, x, u):  # type: ignore[no-untyped-def]
    """Evaluate all interface forces: u = u(signals, C y)."""
    lanes = u.shape[1]
    for row in range(u.shape[0]):
        for lane in range(lanes):
            u[row, lane] = 0.0
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
        row = plan[k, 5] + plan[k, 4] - plan[k, 3]
        for i in range(plan[k, 3], plan[k, 4]):
            own = plan[k, 5] + i - plan[k, 3]
            for lane in range(lanes):
                u[outputs[i], lane] += signals[own, lane]
            for j in range(plan[k, 1], plan[k, 2]):
                for lane in range(lanes):
                    u[outputs[i], lane] += signals[row, lane] * x[inputs[j], lane]
                row += 1


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _hermite(tables, k, spacing, tau, result):  # type: ignore[no-untyped-def]
    """Set result = P_k(tau) by cubic interpolation; the derivative of P_k is P_(k-1)."""
    points = tables.shape[1]
    at = min(int(tau / spacing), points - 2)
    s = tau / spacing - at
    h00, h10 = (1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2 * spacing
    h01, h11 = s * s * (3 - 2 * s), s * s * (s - 1) * spacing
    for i in range(result.shape[0]):
        for j in range(result.shape[1]):
            result[i, j] = (
                h00 * tables[k, at, i, j]
                + h10 * tables[k - 1, at, i, j]
                + h01 * tables[k, at + 1, i, j]
                + h11 * tables[k - 1, at + 1, i, j]
            )


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _jump_difference(law, old, new, parameters, smooth, moved, reads, acts, u):  # type: ignore[no-untyped-def]
    """Set u = force on the new branch at the moved point - force on the old branch at the smooth continuation."""
    u[:] = 0.0
    law(old, parameters, smooth, reads, acts, u)
    for i in range(u.shape[0]):
        u[i, 0] = -u[i, 0]
    law(new, parameters, moved, reads, acts, u)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _jump(law, branches, parameters, x0, x1, step, tau, spacing, states, rows, change):  # type: ignore[no-untyped-def]
    """Return in ``change`` what the branch change at ``step - tau`` adds to the state at the end of the step.

    x0 and x1 (2 k, 1) hold k displacements, then their k velocities, at both ends of the step without the jump; the
    motion between them is their cubic interpolant d(s). The force difference g(s) is sampled at the jump, half-way
    and at the end, on the moved point, in two sweeps; its quadratic g0 + a s + b s^2 / 2 then meets the tables.
    """
    change[:] = 0.0
    # A jump on the end of the step, as a mesh in a whole ratio to the step makes, has no time to act in it.
    if tau <= 0.0:
        return
    count, columns = x0.shape[0] // 2, rows.shape[3]
    reads, acts = np.arange(2 * count), np.arange(columns)
    smooth, moved = np.zeros((3, 2 * count, 1)), np.zeros((3, 2 * count, 1))
    for stage in range(3):
        s = 1.0 - tau / step * (1.0 - 0.5 * stage)
        for i in range(count):
            d0, d1, v0, v1 = x0[i, 0], x1[i, 0], step * x0[count + i, 0], step * x1[count + i, 0]
            bend, twist = 3 * (d1 - d0) - 2 * v0 - v1, 2 * (d0 - d1) + v0 + v1
            smooth[stage, i, 0] = d0 + s * (v0 + s * (bend + s * twist))
            smooth[stage, count + i, 0] = (v0 + s * (2 * bend + 3 * s * twist)) / step
    moved[:] = smooth
    g = np.zeros((3, columns, 1))
    weights = np.zeros((3, columns))
    table = np.zeros((2 * count, columns))
    for sweep in range(3):
        for stage in range(3):
            _jump_difference(
                law,
                branches[stage, 0],
                branches[stage, 1],
                parameters,
                smooth[stage],
                moved[stage],
                reads,
                acts,
                g[stage],
            )
        for j in range(columns):
            weights[0, j] = g[0, j, 0]
            weights[1, j] = (-3 * g[0, j, 0] + 4 * g[1, j, 0] - g[2, j, 0]) / tau
            weights[2, j] = 4 * (g[0, j, 0] - 2 * g[1, j, 0] + g[2, j, 0]) / tau**2
        if sweep == 2:
            break
        for stage in range(1, 3):
            moved[stage] = smooth[stage]
            for k in range(1, 4):
                _hermite(rows, k, spacing, 0.5 * tau * stage, table)
                for i in range(2 * count):
                    for j in range(columns):
                        moved[stage, i, 0] += table[i, j] * weights[k - 1, j]
    change[:] = 0.0
    whole = np.zeros((states.shape[2], columns))
    for k in range(1, 4):
        _hermite(states, k, spacing, tau, whole)
        for i in range(whole.shape[0]):
            for j in range(columns):
                change[i] += whole[i, j] * weights[k - 1, j]


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _apply_jump(laws, plan, inputs, parameters, step_s, jump, event, branches, motion_rows, x, following, change):  # type: ignore[no-untyped-def]
    """Correct one lane's state and motions at the end of a step for the jump of one force inside it."""
    lane, which = int(event[1]), int(event[2])
    k, n = jump[3][which], change.size
    reads = inputs[plan[k, 1] : plan[k, 2]]
    own = np.ascontiguousarray(parameters[plan[k, 7] : plan[k, 8], lane]).reshape(-1, 1)
    x0, x1 = np.zeros((reads.size, 1)), np.zeros((reads.size, 1))
    for i in range(reads.size):
        x0[i, 0], x1[i, 0] = x[reads[i], lane], following[n + reads[i], lane]
    _jump(
        laws[plan[k, 0]], branches, own, x0, x1, step_s, event[3], jump[0], jump[1][which], jump[2][which], change
    )  # fmt: skip
    for i in range(n):
        following[i, lane] += change[i]
    for i in range(x.shape[0]):
        total = 0.0
        for j in range(n):
            total += motion_rows[1][i, j] * following[j, lane]
        following[n + i, lane] = total


@numba.njit(cache=True, fastmath=_MATH, error_model="numpy", nogil=True)
def run_block(laws, plan, inputs, outputs, parameters, step_s, tables, jump, signals, events, branches, y, record):  # type: ignore[no-untyped-def]
    """Advance the states ``y`` (n, lanes) in place by as many steps as ``signals`` has, and record the probes.

    Parameters
    ----------
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
    full, first, last, ahead, stages, update, motion_rows, probe_columns = tables
    n, lanes = y.shape
    p, m = motion_rows[0].shape[1], stages[0][0].shape[0]
    x, stage = np.zeros((p, lanes)), np.zeros((p, lanes))
    u1, u2, u3, u4 = np.zeros((m, lanes)), np.zeros((m, lanes)), np.zeros((m, lanes)), np.zeros((m, lanes))
    known, following, change = np.zeros((ahead[0].shape[1], lanes)), np.zeros((n + p, lanes)), np.zeros(n)
    half, whole, seen = known[:p], known[p : 2 * p], known[2 * p :]
    event = 0
    _add_product(motion_rows, y, x)
    for step in range(signals.shape[0]):
        _forces(laws, plan, inputs, outputs, signals[step, 0], parameters, x, u1)
        known[:] = 0.0
        _add_product(ahead, y, known)
        record[step] = seen
        _add_product(probe_columns, u1, record[step])
        stage[:] = half
        _add_product(stages[0], u1, stage)
        _forces(laws, plan, inputs, outputs, signals[step, 1], parameters, stage, u2)
        stage[:] = half
        _add_product(stages[1], u1, stage)
        _add_product(stages[2], u2, stage)
        _forces(laws, plan, inputs, outputs, signals[step, 1], parameters, stage, u3)
        stage[:] = whole
        _add_product(stages[3], u1, stage)
        _add_product(stages[4], u3, stage)
        _forces(laws, plan, inputs, outputs, signals[step, 2], parameters, stage, u4)
        following[:n] = 0.0
        for i in range(n):
            for j in range(first[i], last[i]):
                weight = full[i, j]
                for lane in range(lanes):
                    following[i, lane] += weight * y[j, lane]
        following[n:] = whole
        u2 += u3
        _add_product(update[0], u1, following)
        _add_product(update[1], u2, following)
        _add_product(update[2], u4, following)
        while event < events.shape[0] and events[event, 0] == step:
            _apply_jump(
                laws, plan, inputs, parameters, step_s, jump, events[event], branches[event], motion_rows, x,
                following, change,
            )  # fmt: skip
            event += 1
        y[:] = following[:n]
        x[:] = following[n:]
