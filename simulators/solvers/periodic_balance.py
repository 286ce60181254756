"""The balance of harmonics: forces that make just the motions from which they follow.

Unknown are the harmonics of the interface motions that a force really reads. With x = sum over k of x_k exp(i k w t),
x_-k the conjugate of x_k, and forces u = s + S x, every harmonic obeys

    x_k = H_k (s_k + sum over l of S_(k-l) x_l).

Real and imaginary parts of k = 0..K are solved for, all lanes in one call.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .periodic_forces import PeriodicForces


@dataclass(frozen=True)
class Responses:
    """What forces do, harmonic by harmonic.

    Attributes
    ----------
    of_directions : ndarray (lanes, K + 1, directions, forces), complex
        H of the displacements that interface motions are, or whose velocities they are.
    of_probes : ndarray (lanes, K + 1, probes, forces), complex
    directions : ndarray of int (motions,)
        Of each interface motion.
    factors : ndarray (lanes, K + 1, motions), complex
        Motion over displacement: 1, or i k w of a velocity.
    """

    of_directions: np.ndarray
    of_probes: np.ndarray
    directions: np.ndarray
    factors: np.ndarray

    @property
    def top(self) -> int:
        """K, the highest harmonic."""
        return self.factors.shape[1] - 1

    def motions(self, forces: np.ndarray) -> np.ndarray:
        """Return the motions (lanes, K + 1, motions) that forces (lanes, K + 1, forces) make."""
        return times(self.of_directions, forces)[:, :, self.directions] * self.factors


@dataclass(frozen=True)
class Slopes:
    """S(t), as far as it is not zero.

    Attributes
    ----------
    pairs : ndarray of int (pairs, 2)
        Force and motion.
    spectrum : ndarray (pairs, lanes, 2 K + 1), complex
        Harmonics 0 to 2 K.
    """

    pairs: np.ndarray
    spectrum: np.ndarray


def balanced_linear(forces: PeriodicForces, responding: Responses) -> np.ndarray:
    """Return the harmonics of linear forces in balance, shape (lanes, K + 1, forces)."""
    constant, slope = forces.linear_parts()
    spectrum = spectrum_of(constant, responding.top)
    slopes = slopes_of(slope, responding.top)
    return with_slopes(spectrum, slopes, solved(spectrum, slopes, responding))


def spectrum_of(waves: np.ndarray, top: int) -> np.ndarray:
    """Return harmonics 0 to ``top`` of (forces, lanes, instants), shape (lanes, top + 1, forces)."""
    return (np.fft.rfft(waves)[..., : top + 1] / waves.shape[-1]).transpose(1, 2, 0)


def slopes_of(slope: dict[tuple[int, int], np.ndarray], top: int) -> Slopes:
    """Return the harmonics 0 to 2 ``top`` of slopes by (force, motion), each (lanes, instants)."""
    waves = np.array(list(slope.values())).reshape(len(slope), *next(iter(slope.values()), np.zeros((1, 1))).shape)
    pairs = np.array(list(slope)).reshape(-1, 2).astype(int)
    return Slopes(pairs, np.fft.rfft(waves)[..., : 2 * top + 1] / waves.shape[-1])


def times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return matrices (..., n, m) times vectors (..., m)."""
    return (matrices @ vectors[..., None])[..., 0]


def with_slopes(spectrum: np.ndarray, slopes: Slopes, motions: np.ndarray) -> np.ndarray:
    """Return s_k + sum over l of S_(k-l) x_l, shape (lanes, K + 1, forces); ``motions`` (lanes, K + 1, motions)."""
    if not slopes.pairs.size:
        return spectrum
    before, after = shifted(slopes.spectrum)
    own = motions[:, :, slopes.pairs[:, 1]].transpose(2, 0, 1)
    added = times(before, own) + times(after[..., 1:], np.conj(own[..., 1:]))
    found = spectrum.copy()
    for number, act in enumerate(slopes.pairs[:, 0]):
        found[:, :, act] += added[number]
    return found


def shifted(spectrum: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return S_(k-l) and S_(k+l) for k, l = 0..K, each (pairs, lanes, K + 1, K + 1)."""
    order = np.arange((spectrum.shape[-1] + 1) // 2)
    lag = order[:, None] - order
    before = spectrum[..., np.abs(lag)]
    return np.where(lag < 0, np.conj(before), before), spectrum[..., order[:, None] + order]


def solved(spectrum: np.ndarray, slopes: Slopes, responding: Responses) -> np.ndarray:
    """Return the motions (lanes, K + 1, motions) that the forces s + S x make; those that no slope reads stay zero."""
    found = np.zeros(responding.factors.shape, dtype=complex)
    if not slopes.pairs.size:
        return found
    wanted, place = np.unique(responding.directions[slopes.pairs[:, 1]], return_inverse=True)
    own = responding.of_directions[:, :, wanted]
    lanes, orders, size, _ = own.shape
    matrix = identity_minus(moved_by_slopes(own, slopes, place, responding.factors))
    right = real_parts(times(own, spectrum))[..., None]
    solution = solved_lanes(matrix, right).reshape(lanes, 2, size, orders)
    read = slopes.pairs[:, 1]
    moved = (solution[:, 0] + 1j * solution[:, 1]).swapaxes(1, 2)
    found[:, :, read] = moved[:, :, place] * responding.factors[:, :, read]
    return found


def moved_by_slopes(own: np.ndarray, slopes: Slopes, place: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """Return H S for real parts, then imaginary parts: what displacements do to themselves through the slopes.

    Parameters
    ----------
    own : ndarray (lanes, K + 1, directions, forces), complex
        H of these directions.
    slopes : Slopes
    place : ndarray of int (pairs,)
        Which of these directions each pair reads.
    factors : ndarray (lanes, K + 1, motions), complex

    Returns
    -------
    ndarray (lanes, 2 x directions x (K + 1), the same), real
    """
    lanes, orders, size, _ = own.shape
    # Axes: lanes, part and direction and order of the row, then of the column.
    matrix = np.zeros((lanes, 2, size, orders, 2, size, orders))
    for at, acts, before, after in by_direction(slopes, place, factors):
        column = own[:, :, :, acts]
        add_real_form(matrix[..., at, :], (column @ before).swapaxes(1, 2), (column @ after).swapaxes(1, 2))
    return matrix.reshape(lanes, 2 * orders * size, 2 * orders * size)


def add_real_form(matrix: np.ndarray, one: np.ndarray, other: np.ndarray) -> None:
    """Add A z + B conj(z), complex, to a matrix of real parts, then imaginary parts.

    Parameters
    ----------
    matrix : ndarray (lanes, 2, ..., 2, K + 1), real
        Axes of two: of the result, of z.
    one, other : ndarray (lanes, ..., K + 1), complex
        A and B.
    """
    plus, minus = one + other, one - other
    matrix[:, 0, ..., 0, :] += np.real(plus)
    matrix[:, 0, ..., 1, :] -= np.imag(minus)
    matrix[:, 1, ..., 0, :] += np.imag(plus)
    matrix[:, 1, ..., 1, :] += np.real(minus)


def real_parts(harmonics: np.ndarray) -> np.ndarray:
    """Return (lanes, K + 1, n) complex as real parts, then imaginary parts, (lanes, 2 x n x (K + 1))."""
    each = harmonics.swapaxes(1, 2).reshape(harmonics.shape[0], -1)
    return np.concatenate([np.real(each), np.imag(each)], axis=1)


def identity_minus(matrix: np.ndarray) -> np.ndarray:
    """Return 1 - A for each lane of A (lanes, n, n), in its place."""
    np.negative(matrix, out=matrix)
    own = np.arange(matrix.shape[1])
    matrix[:, own, own] += 1.0
    return matrix


def solved_lanes(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the solutions of (lanes, n, n) for (lanes, n, columns); not numbers where a matrix is singular."""
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return np.full(right.shape, np.nan)


def by_direction(
    slopes: Slopes, place: np.ndarray, factors: np.ndarray
) -> Iterator[tuple[int, np.ndarray, np.ndarray, np.ndarray]]:
    """Give each direction, the forces of its pairs, and S_(k-l), S_(k+l), each (lanes, K + 1, pairs, K + 1).

    The former multiplies the displacement's harmonic l, the latter its conjugate.
    """
    before, after = shifted(slopes.spectrum)
    after[..., 0] = 0.0
    for at in np.unique(place).tolist():
        own = np.flatnonzero(place == at)
        acts, reads = slopes.pairs[own].T
        factor = factors[:, :, reads].transpose(2, 0, 1)[:, :, None]
        first, second = before[own] * factor, after[own] * np.conj(factor)
        yield at, acts, first.transpose(1, 2, 0, 3), second.transpose(1, 2, 0, 3)
