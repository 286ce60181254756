"""Matrices of one exponential Runge-Kutta step, computed once for a linear core and a step.

The method is Krogstad's ETDRK4: S. Krogstad, J. Comput. Phys. 203 (2005) 72, equation (51); its order for stiff
problems is studied by M. Hochbruck and A. Ostermann, Acta Numerica 19 (2010) 209. With phi_k the usual functions of
the core, phi_1(z) = (exp(z) - 1) / z and so on, one step h from y with u1 = u(t, C y) is

    C a = C e^(hL/2) y + (h/2) C phi_1(hL/2) B u1                                         u2 = u(t + h/2, C a)
    C b = C e^(hL/2) y + h C [(phi_1/2 - phi_2)(hL/2) B u1 + phi_2(hL/2) B u2]             u3 = u(t + h/2, C b)
    C c = C e^(hL)   y + h C [(phi_1 - 2 phi_2)(hL) B u1 + 2 phi_2(hL) B u3]               u4 = u(t + h, C c)
    y+  = e^(hL) y + h [(phi_1 - 3 phi_2 + 4 phi_3) B u1 + (2 phi_2 - 4 phi_3) B (u2 + u3) + (4 phi_3 - phi_2) B u4]

Stages are needed only through C, the few motions that forces read, so that stages cost little.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidValueError
from .block_form import BlockForm

#: Points of the tables for jumps: one step in 32 intervals.
JUMP_POINTS = 33
#: The first term left out of phi_3 is below 1 / 23!, that is 4e-23.
SERIES_TERMS = 19


@dataclass(frozen=True)
class StepTables:
    """See the module. All arrays are contiguous; n states, p motions, m forces, r probes.

    Attributes
    ----------
    step_s : float
    full : (n, n), first, last : (n,)
        e^(hL), and the columns [first, last) of each row that are not zero.
    half_rows, full_rows : (p, n)
        C e^(hL/2), C e^(hL).
    stages : (5, p, m)
        Weights of u1 in a; u1, u2 in b; u1, u3 in c.
    update : (3, n, m)
        Weights of u1, u2 + u3 and u4 in y+.
    """

    step_s: float
    full: np.ndarray
    first: np.ndarray
    last: np.ndarray
    half_rows: np.ndarray
    full_rows: np.ndarray
    stages: np.ndarray
    update: np.ndarray


def step_tables(form: BlockForm, step_s: float) -> StepTables:
    """Return the tables of one step of ``step_s`` seconds for a core in block form."""
    if not step_s > 0:
        raise InvalidValueError(f"Step {step_s} s; allowed: more than 0.")
    make = (
        phi_columns_of_blocks if form.is_blocks else lambda form, step: phi_columns(form.core, form.force_columns, step)
    )
    half, (one_h, two_h, _) = make(form, step_s / 2)
    full, (one, two, three) = make(form, step_s)
    full[~form.pattern] = 0.0
    # phi_columns returns (step/2) phi_k(hL/2) B, hence the factor 2 where the formula has h.
    stages = [one_h, one_h - 2 * two_h, 2 * two_h, one - 2 * two, 2 * two]
    update = [one - 3 * two + 4 * three, 2 * two - 4 * three, 4 * three - two]
    return StepTables(
        step_s=step_s,
        full=np.ascontiguousarray(full),
        first=form.first,
        last=form.last,
        half_rows=np.ascontiguousarray(form.motion_rows @ half),
        full_rows=np.ascontiguousarray(form.motion_rows @ full),
        stages=np.ascontiguousarray([form.motion_rows @ columns for columns in stages]),
        update=np.ascontiguousarray(update),
    )


def phi_columns(core: np.ndarray, columns: np.ndarray, step_s: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return e^(hL) and h phi_k(hL) B for k = 1, 2, 3.

    From one exponential of an augmented matrix: A. Al-Mohy and N. Higham, SIAM J. Sci. Comput. 33 (2011) 488.
    """
    from scipy.linalg import expm

    n, m = columns.shape
    augmented = np.zeros((n + 3 * m, n + 3 * m))
    augmented[:n, :n] = step_s * core
    augmented[:n, n : n + m] = step_s * columns
    for k in range(2):
        start = n + k * m
        augmented[start : start + m, start + m : start + 2 * m] = np.eye(m)
    exponential = expm(augmented)
    return exponential[:n, :n].copy(), [exponential[:n, n + k * m : n + (k + 1) * m].copy() for k in range(3)]


def phi_columns_of_blocks(form: BlockForm, step_s: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the same as `phi_columns` for a core of blocks (see `BlockForm.is_blocks`), block by block.

    Each force column is then computed by itself: a further force does not change the bits of the others.
    """
    n, m = form.force_columns.shape
    exponential, columns = np.zeros((n, n)), [np.zeros((n, m)) for _ in range(3)]
    size = form.last - form.first
    alone, pair = np.flatnonzero(size == 1), np.unique(form.first[size == 2])
    grown, *phi = phi_functions(step_s * form.core[alone, alone])
    exponential[alone, alone] = grown
    for own, weight in zip(columns, phi, strict=True):
        own[alone] = step_s * weight[:, None] * form.force_columns[alone]
    # The block [[a, b], [-b, a]] acts on (p, q) as the number a - i b on p + i q.
    grown, *phi = phi_functions(step_s * (form.core[pair, pair] - 1j * form.core[pair, pair + 1]))
    exponential[pair, pair] = exponential[pair + 1, pair + 1] = np.real(grown)
    exponential[pair, pair + 1], exponential[pair + 1, pair] = -np.imag(grown), np.imag(grown)
    forced = form.force_columns[pair] + 1j * form.force_columns[pair + 1]
    for own, weight in zip(columns, phi, strict=True):
        pushed = step_s * weight[:, None] * forced
        own[pair], own[pair + 1] = np.real(pushed), np.imag(pushed)
    return exponential, columns


def phi_functions(z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return exp(z) and phi_k(z) = integral_0^1 e^((1 - s) z) s^(k-1) / (k-1)! ds for k = 1, 2, 3, same shape as z.

    By phi_k = (phi_(k-1) - 1 / (k-1)!) / z, and for small z, where that loses digits, by the series of phi_3 downwards:
    phi_(k-1) = z phi_k + 1 / (k-1)!.
    """
    small = np.abs(z) < 1.0
    divisor = np.where(small, 1.0, z)
    exponential = np.exp(z)
    one = (exponential - 1) / divisor
    two = (one - 1) / divisor
    three = (two - 0.5) / divisor
    near = np.where(small, z, 0.0)
    series = np.zeros_like(near)
    for k in range(SERIES_TERMS, -1, -1):
        series = series * near + 1 / math.factorial(k + 3)
    three = np.where(small, series, three)
    two = np.where(small, near * three + 0.5, two)
    one = np.where(small, near * two + 1, one)
    return exponential, one, two, three


@dataclass(frozen=True)
class JumpTables:
    """What a force that sets in part-way through a step adds to its end, against the time left.

    For one force of j columns b and time left tau: P_k(tau) = integral_0^tau e^(L s) (tau - s)^(k-1) / (k-1)! b ds.

    Attributes
    ----------
    spacing_s : float
        Between table points; there are points at 0 .. step.
    states : (4, points, n, j)
        P_0 (the derivative of P_1), P_1, P_2, P_3.
    """

    spacing_s: float
    states: np.ndarray

    @property
    def cubics(self) -> np.ndarray:
        """Cubics in s = 0 to 1 between neighbouring points, of P_1 to P_3: (points - 1, 3 j 4, n).

        The last four columns are the coefficients of 1, s, s^2 and s^3; the derivative of P_k is P_(k-1).
        """
        value, slope = self.states[1:], self.spacing_s * self.states[:-1]
        low, high, start, stop = value[:, :-1], value[:, 1:], slope[:, :-1], slope[:, 1:]
        powers = [low, start, 3 * (high - low) - 2 * start - stop, 2 * (low - high) + start + stop]
        # (powers, k, points, n, j) to (points, k, j, powers, n).
        turned = np.transpose(powers, (2, 1, 4, 0, 3))
        return turned.reshape(turned.shape[0], -1, turned.shape[-1])


def jump_tables(form: BlockForm, columns: np.ndarray, step_s: float, *, points: int = JUMP_POINTS) -> JumpTables:
    """Return the tables for force columns (n, j) of a core in block form."""
    from scipy.linalg import expm

    n, m = columns.shape
    spacing = step_s / (points - 1)
    augmented = np.zeros((n + 3 * m, n + 3 * m))
    augmented[:n, :n] = form.core
    augmented[:n, n : n + m] = columns
    for k in range(2):
        start = n + k * m
        augmented[start : start + m, start + m : start + 2 * m] = np.eye(m)
    advance = expm(spacing * augmented)
    state = np.zeros((n + 3 * m, 4 * m))
    state[:n, :m] = columns
    state[n:, m:] = np.eye(3 * m)
    tables = np.zeros((4, points, n, m))
    for point in range(points):
        for k in range(4):
            tables[k, point] = state[:n, k * m : (k + 1) * m]
        state = advance @ state
    return JumpTables(spacing, tables)
