"""Displacements that nonlinear forces read, as these forces move them: what is linear takes part beforehand.

Linear forces u = s + L x are put into the responses: with z the harmonics of the displacements that forces read, real
parts then imaginary parts,

    z = H (s + n + L z + N z)  becomes  z = (I - H L)^-1 H s + (I - H L)^-1 H (n + N z),

n + N z being the nonlinear forces about the motion found last. Slopes K of nearly linear forces that are kept belong to
L, and what these forces do beside K z to n. Of z only what the other nonlinear forces, those that bend, read is unknown
in a step: often a tenth of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .along_motion import pushed_along
from .periodic_balance import (
    Responses,
    Slopes,
    identity_minus,
    moved_by_slopes,
    real_parts,
    solved_lanes,
    times,
    with_slopes,
)
from .periodic_forces import PeriodicForces
from .slope_matrix import slope_matrix


@dataclass(frozen=True)
class Condensed:
    """What moves the displacements that nonlinear forces read, linear forces and kept slopes taking part.

    Vectors hold real parts, then imaginary parts; in them direction by direction (or force by force) the harmonics.
    The displacements that bent forces read come first.

    Attributes
    ----------
    given : ndarray (lanes, displacements)
        Without nonlinear forces.
    of_forces : ndarray (lanes, displacements, forces)
        By the nonlinear forces.
    of_bent : ndarray (lanes, displacements that bent forces read, forces)
        By the bent forces.
    acts, bent_acts, reads : ndarray of int
        Numbers of the forces that the nonlinear ones are, that the bent ones are, and of the motions that they read.
    place : ndarray of int (motions,)
        Of each motion that they read, its displacement.
    factors : ndarray (lanes, K + 1, motions), complex
    kept : Slopes
        Of the nearly linear forces.
    mild, bent : tuple of int
        Numbers of the laws whose slopes are kept, and of those whose slopes are computed in each step.
    """

    given: np.ndarray
    of_forces: np.ndarray
    of_bent: np.ndarray
    acts: np.ndarray
    bent_acts: np.ndarray
    reads: np.ndarray
    place: np.ndarray
    factors: np.ndarray
    kept: Slopes
    mild: tuple[int, ...]
    bent: tuple[int, ...]

    def beside_kept(
        self, forces: PeriodicForces, lanes: np.ndarray, motions: np.ndarray, shape: tuple[int, ...]
    ) -> np.ndarray:
        """Return what nearly linear forces do along motions beside their kept slopes, (lanes, K + 1, forces)."""
        if not self.mild:
            return np.zeros((lanes.size, motions.shape[1], shape[0]), dtype=complex)
        pushed = pushed_along(forces, self.mild, lanes, motions, shape)
        return with_slopes(pushed, Slopes(self.kept.pairs, -self.kept.spectrum[:, lanes]), motions)

    def motions(self, lanes: np.ndarray, pushes: np.ndarray, slopes: Slopes) -> np.ndarray:
        """Return the motions (lanes, K + 1, motions) that linearised forces make; only those that they read."""
        factors, orders = self.factors[lanes], self.factors.shape[1]
        acting = real_parts(pushes[:, :, self.acts])
        if slopes.pairs.size:
            acting = acting + self._by_slopes(lanes, acting, slopes, factors)
        solution = (self.given[lanes] + times(self.of_forces[lanes], acting)).reshape(lanes.size, 2, -1, orders)
        displacements = (solution[:, 0] + 1j * solution[:, 1]).swapaxes(1, 2)
        found = np.zeros(factors.shape, dtype=complex)
        found[:, :, self.reads] = displacements[:, :, self.place] * factors[:, :, self.reads]
        return found

    def _by_slopes(self, lanes: np.ndarray, acting: np.ndarray, slopes: Slopes, factors: np.ndarray) -> np.ndarray:
        """Return S z for the displacements z that follow from it, as forces like ``acting`` (lanes, forces)."""
        own, orders = self.of_bent[lanes], factors.shape[1]
        slope = self._slope_matrix(slopes, factors)
        inner = own.shape[1] // (2 * orders)
        right = (self.given[lanes] + times(self.of_forces[lanes], acting)).reshape(lanes.size, 2, -1, orders)
        right = right[:, :, :inner].reshape(lanes.size, -1)
        moved = solved_lanes(identity_minus(own @ slope), right[..., None])[..., 0]
        found = np.zeros((lanes.size, 2, self.acts.size, orders))
        found[:, :, np.searchsorted(self.acts, self.bent_acts)] = times(slope, moved).reshape(lanes.size, 2, -1, orders)
        return found.reshape(acting.shape)

    def _slope_matrix(self, slopes: Slopes, factors: np.ndarray) -> np.ndarray:
        """Return S for real parts, then imaginary parts, shape (lanes, bent forces, displacements that they read)."""
        acts, reads = slopes.pairs.T
        places = self.place[np.searchsorted(self.reads, reads)]
        sizes = self.bent_acts.size, self.of_bent.shape[1] // (2 * factors.shape[1])
        return slope_matrix(
            slopes.spectrum, np.searchsorted(self.bent_acts, acts), places, factors[:, :, reads], sizes=sizes
        )


def condensed(
    forces: PeriodicForces,
    given: np.ndarray,
    linear: Slopes,
    responding: Responses,
    kept: Slopes,
    mild: tuple[int, ...],
) -> Condensed:
    """Return the displacements that nonlinear forces read, the others solved for.

    Parameters
    ----------
    forces : PeriodicForces
    given : ndarray (lanes, K + 1, forces), complex
        Harmonics of the linear forces without motion.
    linear, kept : Slopes
        Of the linear forces, and of the nearly linear ones, which are the numbers ``mild``.
    responding : Responses
    mild : tuple of int
    """
    system, bent = forces.systems[0], tuple(k for k in forces.nonlinear if k not in mild)
    acts, bent_acts = (_distinct([system.outputs[k] for k in some]) for some in (forces.nonlinear, bent))
    reads = _distinct([system.inputs[k] for k in forces.nonlinear])
    inner = np.unique(responding.directions[_distinct([system.inputs[k] for k in bent])])
    wanted = np.concatenate([inner, np.setdiff1d(responding.directions[reads], inner)])
    # Rows: these displacements first, then those that only linear forces read.
    taken = _both(linear, kept)
    others = np.setdiff1d(responding.directions[taken.pairs[:, 1]], wanted)
    rows = np.concatenate([wanted, others])
    number = np.zeros(int(responding.directions.max(initial=0)) + 1, dtype=int)
    number[rows] = np.arange(rows.size)
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
    if taken.pairs.size:
        where = number[responding.directions[taken.pairs[:, 1]]]
        right = solved_lanes(identity_minus(moved_by_slopes(own, taken, where, responding.factors)), right)
    right = right.reshape(lanes, 2, size, orders, -1)
    whole = right[:, :, : wanted.size].reshape(lanes, -1, right.shape[-1])
    unknown = 2 * inner.size * orders
    of_bent = right[:, :, : inner.size, :, :-1].reshape(lanes, unknown, 2, acts.size, orders)
    of_bent = of_bent[:, :, :, np.searchsorted(acts, bent_acts)].reshape(lanes, unknown, 2 * bent_acts.size * orders)
    place = number[responding.directions[reads]]
    matrices = whole[..., -1], np.ascontiguousarray(whole[..., :-1]), of_bent
    return Condensed(*matrices, acts, bent_acts, reads, place, responding.factors, kept, mild, bent)


def _both(one: Slopes, other: Slopes) -> Slopes:
    if not (one.pairs.size and other.pairs.size):
        return one if one.pairs.size else other
    return Slopes(np.concatenate([one.pairs, other.pairs]), np.concatenate([one.spectrum, other.spectrum]))


def _distinct(numbers: list[np.ndarray]) -> np.ndarray:
    return np.unique(np.concatenate([np.zeros(0, dtype=int), *numbers]))
