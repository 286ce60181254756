"""Whether a machine stays in a periodic motion: what a small disturbance becomes within one period.

About a motion that repeats, a disturbance obeys y' = [L + B S(t) C] y with the slopes S of the interface forces along
it. Its growth over one period are the Floquet multipliers (G. Floquet 1883; M. Krack, J. Gross, Harmonic Balance for
Nonlinear Vibration Problems, Springer 2019, section 3.6). A motion of which one is larger than 1 is left at the least
touch: no record shows it.

The period is gone through by the trapezoidal rule, which makes no decaying motion grow, in the slow motions of the core
only: what is faster than the samples of the slopes tell follows the forces at once, and whether that grows is not seen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any

import numpy as np

from ..system import System
from .along_motion import slopes_along
from .periodic_balance import solved_lanes
from .periodic_forces import PeriodicForces

#: Motions up to about this share of the highest frequency that samples of the slopes hold are followed: as far as the
#: widest gap between their frequencies within this factor to both sides.
SLOW, NEARBY = 0.5, 2.0
#: Cores whose slow motions are kept, and lanes that are gone through side by side.
KEPT_CORES, TOGETHER = 64, 32


def largest_multipliers(
    forces: PeriodicForces, motions: np.ndarray, speeds_rad_s: Sequence[float], revolutions: int
) -> np.ndarray:
    """Return the largest modulus of the Floquet multipliers of each lane, shape (lanes,).

    Infinite where a disturbance grows by more than numbers hold.

    Parameters
    ----------
    forces : PeriodicForces
    motions : ndarray (lanes, K + 1, motions), complex
        Two-sided harmonics of the motion that repeats.
    speeds_rad_s : sequence of float
        Of the reference shaft.
    revolutions : int
        Of a period.
    """
    acts, reads, slopes = _slopes(forces, motions)
    steps_s = 2 * math.pi * revolutions / np.asarray(speeds_rad_s) / slopes.shape[1]
    lanes = list(zip(forces.systems, speeds_rad_s, steps_s, strict=True))
    found = []
    for first in range(0, len(lanes), TOGETHER):
        some = slice(first, first + TOGETHER)
        with np.errstate(over="ignore", invalid="ignore"):
            found.append(_largest(lanes[some], acts, reads, slopes[some]))
    return np.concatenate(found)


def _largest(
    lanes: Sequence[tuple[System, float, float]], acts: np.ndarray, reads: np.ndarray, slopes: np.ndarray
) -> np.ndarray:
    """Return the same of lanes, each a system, its speed and the step in s."""
    parts = [_slow_motions(_core(system, speed), SLOW * math.pi / step) for system, speed, step in lanes]
    states = max(part.slow.shape[0] for part in parts)
    through = np.zeros((len(lanes), states, states))
    pushed, read = np.zeros((len(lanes), states, acts.size)), np.zeros((len(lanes), reads.size, states))
    at_once = np.zeros((len(lanes), reads.size, acts.size))
    for lane, ((system, _, step), part) in enumerate(zip(lanes, parts, strict=True)):
        columns, rows, own = system.force_columns[:, acts], system.motion_rows[reads], part.slow.shape[0]
        unit = np.eye(own)
        inverse = np.linalg.inv(unit - step / 2 * part.slow)
        through[lane, :own, :own] = inverse @ (unit + step / 2 * part.slow)
        pushed[lane, :own] = step / 2 * inverse @ (part.into @ columns)
        read[lane, :, :own] = rows @ part.out_of
        at_once[lane] = rows @ part.fast @ columns
    # Fast motions follow: u = S (x + D u).
    unit = np.eye(acts.size)
    slopes = solved_lanes(unit - slopes @ at_once[:, None], slopes)
    # The rule's implicit half, at the few places where forces act (Sherman, Morrison and Woodbury).
    implicit = solved_lanes(unit - slopes @ (read @ pushed)[:, None], slopes)
    moved = np.broadcast_to(np.eye(states), through.shape)
    for instant in range(slopes.shape[1]):
        moved = through @ moved + pushed @ (slopes[:, instant] @ (read @ moved))
        moved = moved + pushed @ (implicit[:, instant] @ (read @ moved))
    bounded = np.isfinite(moved).all(axis=(1, 2))
    largest = np.full(len(lanes), np.inf)
    largest[bounded] = np.abs(np.linalg.eigvals(moved[bounded])).max(axis=1, initial=0.0)
    return largest


def _slopes(forces: PeriodicForces, motions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which forces have slopes, in which motions, and these, (lanes, instants, forces, motions)."""
    constant, linear = forces.linear_parts()
    _, bent = slopes_along(forces, np.arange(motions.shape[0]), motions, constant.shape)
    acts, reads = (np.unique([pair[i] for pair in (*linear, *bent)]).astype(int) for i in (0, 1))
    found = np.zeros((motions.shape[0], constant.shape[2], acts.size, reads.size))
    for part in (linear, bent):
        for (act, motion), wave in part.items():
            found[:, :, np.searchsorted(acts, act), np.searchsorted(reads, motion)] += wave
    return acts, reads, found


def _core(system: System, speed_rad_s: float) -> np.ndarray:
    """Return L at a speed of the reference shaft: systems are shared between speeds but for the gyroscopic terms."""
    n = system.mass_matrix.shape[0]
    core = system.core.copy()
    more = speed_rad_s - system.speed_rad_s
    if more and system.gyroscopic_matrix.any():
        core[n : 2 * n, n : 2 * n] -= more * np.linalg.solve(system.mass_matrix, system.gyroscopic_matrix)
    return core


@dataclass(frozen=True, eq=False)
class _SlowMotions:
    """Slow free motions of a core: y = out_of z + fast B u with z' = slow z + into B u.

    Attributes
    ----------
    slow : ndarray (slow, slow)
    into : ndarray (slow, states)
    out_of : ndarray (states, slow)
    fast : ndarray (states, states)
        What faster motions make of a force at once.
    """

    slow: np.ndarray
    into: np.ndarray
    out_of: np.ndarray
    fast: np.ndarray


def _slow_motions(core: np.ndarray, below_rad_s: float) -> _SlowMotions:
    """Return the free motions slower than a limit, apart from the faster ones: an ordered Schur form, decoupled."""
    key = blake2b(core.tobytes()).digest(), round(below_rad_s, 6)
    kept = _kept_cores.pop(key, None)
    if kept is None:
        kept = _decoupled(core, below_rad_s)
    _kept_cores[key] = kept
    while len(_kept_cores) > KEPT_CORES:
        _kept_cores.pop(next(iter(_kept_cores)))
    return kept


_kept_cores: dict[tuple[bytes, float], _SlowMotions] = {}


def _decoupled(core: np.ndarray, below_rad_s: float) -> _SlowMotions:
    from scipy.linalg import schur, solve_sylvester

    sizes = np.sort(np.abs(np.linalg.eigvals(core)))
    near = sizes[(sizes > below_rad_s / NEARBY) & (sizes < below_rad_s * NEARBY)]
    ends = np.array([below_rad_s / NEARBY, *near, below_rad_s * NEARBY])
    widest = int(np.argmax(ends[1:] / ends[:-1]))
    # Two motions of one frequency on both sides could not be told apart.
    limit = math.sqrt(ends[widest] * ends[widest + 1])
    found: Any = schur(core, sort=lambda real, imaginary: math.hypot(real, imaginary) < limit)
    triangle, turned, count = found
    slow, between, fast = triangle[:count, :count], triangle[:count, count:], triangle[count:, count:]
    if count == core.shape[0]:
        return _SlowMotions(slow, turned.T, turned, np.zeros(core.shape))
    # [1 X; 0 1] on both sides leaves the two without each other.
    apart = solve_sylvester(slow, -fast, -between) if count else between
    into = turned[:, :count].T - apart @ turned[:, count:].T
    out_of_fast = turned[:, :count] @ apart + turned[:, count:]
    at_once = -out_of_fast @ np.linalg.solve(fast, turned[:, count:].T)
    return _SlowMotions(slow, into, turned[:, :count], at_once)
