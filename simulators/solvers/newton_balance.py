"""The balance of harmonics for forces that are not linear in the motion: Newton's method on what those forces read.

Linear forces u = s + L x are put into the responses first: with z the harmonics of the displacements that forces read,
real parts then imaginary parts,

    z = H (s + n + L z + N z)  becomes  z = (I - H L)^-1 H s + (I - H L)^-1 H (n + N z),

n + N z being the nonlinear forces about the motion found last. Of z only what these read is unknown in a step, often a
tenth of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .periodic_balance import (
    Responses,
    Slopes,
    identity_minus,
    moved_by_slopes,
    real_parts,
    slopes_of,
    solved,
    solved_lanes,
    spectrum_of,
    times,
    with_slopes,
)
from .periodic_forces import PeriodicForces
from .slope_matrix import slope_matrix

MOST_STEPS = 30
#: Relative change of the motions at which Newton's method ends, and above which it has found nothing.
TOLERANCE, WORST = 1e-10, 1e-6
#: Shares in which forces are let in, what the last but one leaves out, and steps of Newton's method at each.
SHARES, LEFT_OUT, FEW_STEPS = 24, 1e-3, 12
#: Shares without a balance, one after the other, after which a lane is given up.
MOST_PASSED = 4


def balanced_newton(
    forces: PeriodicForces, responding: Responses, start: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the harmonics of the forces in balance, (lanes, K + 1, forces), and the last relative change of each lane.

    From ``start``, motions (lanes, K + 1, motions), or from rest. Where that leads nowhere, as with contacts that open
    and close, the nonlinear forces are let in little by little, each balance being sought from the one before. A lane
    that does not converge ends with a change above `WORST`, or not a number.
    """
    constant, slope = forces.linear_parts()
    given, linear = spectrum_of(constant, responding.top), slopes_of(slope, responding.top)
    lanes = np.arange(given.shape[0])
    condensed = _condensed(forces, given, linear, responding)
    found = np.zeros(responding.factors.shape, dtype=complex)
    if start is not None:
        found[:, :, condensed.reads] = start[:, :, condensed.reads]
    found, change = _newton(forces, condensed, lanes, found, constant.shape)
    lost = lanes[~(change < WORST)]
    if lost.size:
        found[lost], change[lost] = _let_in(forces, condensed, lost, constant.shape)
    pushed = given + _pushed(forces, lanes, found, constant.shape)
    return with_slopes(pushed, linear, solved(pushed, linear, responding)), change


def _newton(
    forces: PeriodicForces,
    condensed: _Condensed,
    lanes: np.ndarray,
    start: np.ndarray,
    shape: tuple[int, ...],
    *,
    share: float = 1.0,
    most: int = MOST_STEPS,
) -> tuple[np.ndarray, np.ndarray]:
    """Return motions (lanes, K + 1, motions) in balance with a share of the nonlinear forces, and their last change.

    Each lane until it has converged: nonlinear forces are replaced by their slopes along the motion found last.
    """
    found, change, going = start.copy(), np.full(lanes.size, np.inf), np.arange(lanes.size)
    for _ in range(most):
        pushes, slopes = linearised(forces, lanes[going], found[going], shape)
        slopes = Slopes(slopes.pairs, share * slopes.spectrum)
        following = condensed.motions(lanes[going], share * pushes, slopes)
        scale = np.abs(following).max(axis=(1, 2))
        moved = np.abs(following - found[going]).max(axis=(1, 2))
        change[going] = np.divide(moved, scale, out=np.zeros(going.size), where=scale != 0)
        found[going] = following
        going = going[np.isfinite(change[going]) & (change[going] >= TOLERANCE)]
        if not going.size:
            break
    return found, change


def _let_in(
    forces: PeriodicForces, condensed: _Condensed, lanes: np.ndarray, shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return motions in balance and their last change, the nonlinear forces being let in little by little.

    What is left out falls by the same factor from step to step: a support that has lost nearly all of its stiffness
    changes most at the end. A share that finds no balance is passed over, but not many in a row.
    """
    best = np.zeros((lanes.size, *condensed.factors.shape[1:]), dtype=complex)
    change, passed = np.full(lanes.size, np.inf), np.zeros(lanes.size, dtype=int)
    for step in range(1, SHARES + 1):
        going = np.flatnonzero(passed < MOST_PASSED)
        if not going.size:
            break
        share = 1.0 if step == SHARES else 1.0 - LEFT_OUT ** (step / SHARES)
        found, changed = _newton(forces, condensed, lanes[going], best[going], shape, share=share, most=FEW_STEPS)
        fine = changed < WORST
        best[going[fine]] = found[fine]
        passed[going] = np.where(fine, 0, passed[going] + 1)
        if step == SHARES:
            change[going] = changed
    return best, change


@dataclass(frozen=True)
class _Condensed:
    """What moves the displacements that nonlinear forces read, the linear forces taking part.

    Vectors hold real parts, then imaginary parts; in them direction by direction (or force by force) the harmonics.

    Attributes
    ----------
    given : ndarray (lanes, displacements)
        Without nonlinear forces.
    of_forces : ndarray (lanes, displacements, forces)
        By the nonlinear forces.
    acts, reads : ndarray of int
        Numbers of the nonlinear forces, and of the motions that they read.
    place : ndarray of int (motions,)
        Of each motion that they read, its displacement.
    factors : ndarray (lanes, K + 1, motions), complex
    """

    given: np.ndarray
    of_forces: np.ndarray
    acts: np.ndarray
    reads: np.ndarray
    place: np.ndarray
    factors: np.ndarray

    def motions(self, lanes: np.ndarray, pushes: np.ndarray, slopes: Slopes) -> np.ndarray:
        """Return the motions (lanes, K + 1, motions) that linearised forces make; only those that they read."""
        factors, own = self.factors[lanes], self.of_forces[lanes]
        orders = factors.shape[1]
        right = self.given[lanes] + times(own, real_parts(pushes[:, :, self.acts]))
        matrix = identity_minus(own @ self._slope_matrix(slopes, factors))
        solution = solved_lanes(matrix, right[..., None]).reshape(lanes.size, 2, -1, orders)
        displacements = (solution[:, 0] + 1j * solution[:, 1]).swapaxes(1, 2)
        found = np.zeros(factors.shape, dtype=complex)
        found[:, :, self.reads] = displacements[:, :, self.place] * factors[:, :, self.reads]
        return found

    def _slope_matrix(self, slopes: Slopes, factors: np.ndarray) -> np.ndarray:
        """Return S for real parts, then imaginary parts, shape (lanes, forces, displacements)."""
        acts, reads = slopes.pairs.T
        places = self.place[np.searchsorted(self.reads, reads)]
        sizes = self.acts.size, int(self.place.max()) + 1
        return slope_matrix(
            slopes.spectrum, np.searchsorted(self.acts, acts), places, factors[:, :, reads], sizes=sizes
        )


def _condensed(forces: PeriodicForces, given: np.ndarray, linear: Slopes, responding: Responses) -> _Condensed:
    system = forces.systems[0]
    acts = np.unique(np.concatenate([system.outputs[k] for k in forces.nonlinear]))
    reads = np.unique(np.concatenate([system.inputs[k] for k in forces.nonlinear]))
    wanted, place = np.unique(responding.directions[reads], return_inverse=True)
    # Rows: these displacements first, then those that only linear forces read.
    others = np.setdiff1d(responding.directions[linear.pairs[:, 1]], wanted)
    rows = np.concatenate([wanted, others])
    own = responding.of_directions[:, :, rows]
    lanes, orders, size, _ = own.shape
    each = np.arange(orders)
    columns = np.zeros((lanes, 2, size, orders, 2, acts.size, orders))
    of_acts = own[..., acts].transpose(1, 0, 2, 3)
    columns[:, 0, :, each, 0, :, each] = columns[:, 1, :, each, 1, :, each] = np.real(of_acts)
    columns[:, 1, :, each, 0, :, each] = np.imag(of_acts)
    columns[:, 0, :, each, 1, :, each] = -np.imag(of_acts)
    right = np.concatenate(
        [columns.reshape(lanes, 2 * size * orders, -1), real_parts(times(own, given))[..., None]], axis=2
    )
    if linear.pairs.size:
        number = {int(row): i for i, row in enumerate(rows)}
        where = np.array([number[int(responding.directions[read])] for read in linear.pairs[:, 1]], dtype=int)
        right = solved_lanes(identity_minus(moved_by_slopes(own, linear, where, responding.factors)), right)
    kept = right.reshape(lanes, 2, size, orders, -1)[:, :, : wanted.size].reshape(lanes, -1, right.shape[2])
    return _Condensed(kept[..., -1], kept[..., :-1], acts, reads, place, responding.factors)


def _waves(motions: np.ndarray, instants: int) -> np.ndarray:
    """Return x(t) over one period, shape (motions, lanes, instants), from harmonics (lanes, K + 1, motions)."""
    return np.fft.irfft(motions.transpose(2, 0, 1) * instants, instants)


def _pushed(forces: PeriodicForces, lanes: np.ndarray, motions: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return the harmonics (lanes, K + 1, forces) of the nonlinear forces along motions (lanes, K + 1, motions)."""
    x, u = _waves(motions, shape[2]), np.zeros((shape[0], lanes.size, shape[2]))
    system = forces.systems[0]
    for k in forces.nonlinear:
        np.add.at(u, system.outputs[k], forces.pushed(k, lanes, x[system.inputs[k], None])[:, 0])
    return spectrum_of(u, motions.shape[1] - 1)


def linearised(
    forces: PeriodicForces, lanes: np.ndarray, motions: np.ndarray, shape: tuple[int, ...]
) -> tuple[np.ndarray, Slopes]:
    """Return s (lanes, K + 1, forces) and S of the nonlinear forces along a motion, by central differences."""
    constant, slope = slopes_along(forces, lanes, motions, shape)
    top = motions.shape[1] - 1
    return spectrum_of(constant, top), slopes_of(slope, top)


def slopes_along(
    forces: PeriodicForces, lanes: np.ndarray, motions: np.ndarray, shape: tuple[int, ...]
) -> tuple[np.ndarray, dict[tuple[int, int], np.ndarray]]:
    """Return the same over the period: s (forces, lanes, instants), S by (force, motion), each (lanes, instants)."""
    x, constant = _waves(motions, shape[2]), np.zeros((shape[0], lanes.size, shape[2]))
    slope: dict[tuple[int, int], np.ndarray] = {}
    system = forces.systems[0]
    for k in forces.nonlinear:
        reads, acts = system.inputs[k], system.outputs[k]
        own = x[reads]
        width = (1e-6 * np.abs(own).max(axis=2) + 1e-12)[:, :, None]
        points = np.repeat(own[:, None], 1 + 2 * reads.size, axis=1)
        for j in range(reads.size):
            points[j, 1 + 2 * j] += width[j]
            points[j, 2 + 2 * j] -= width[j]
        u = forces.pushed(k, lanes, points)
        rising = (u[:, 1::2] - u[:, 2::2]) / (2 * width)
        np.add.at(constant, acts, u[:, 0] - (rising * own).sum(axis=1))
        for i, act in enumerate(acts.tolist()):
            for j, read in enumerate(reads.tolist()):
                slope[act, read] = slope.get((act, read), 0.0) + rising[i, j]
    return constant, slope
