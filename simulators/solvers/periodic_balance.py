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

MOST_STEPS = 40
#: Relative change of the motions at which Newton's method ends, and above which it has found nothing.
TOLERANCE, WORST = 1e-10, 1e-6


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

    def of(self, lanes: np.ndarray) -> Responses:
        """Return those of some lanes."""
        return Responses(self.of_directions[lanes], self.of_probes[lanes], self.directions, self.factors[lanes])

    def motions(self, forces: np.ndarray) -> np.ndarray:
        """Return the motions (lanes, K + 1, motions) that forces (lanes, K + 1, forces) make."""
        return _times(self.of_directions, forces)[:, :, self.directions] * self.factors


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

    def of(self, lanes: np.ndarray) -> Slopes:
        """Return those of some lanes."""
        return Slopes(self.pairs, self.spectrum[:, lanes]) if self.pairs.size else self


def balanced_linear(forces: PeriodicForces, responding: Responses) -> np.ndarray:
    """Return the harmonics of linear forces in balance, shape (lanes, K + 1, forces)."""
    constant, slope = forces.linear_parts()
    spectrum = _spectrum(constant, responding.top)
    slopes = _slopes(slope, responding.top)
    return _with_slopes(spectrum, slopes, _solved(spectrum, slopes, responding))


def balanced_newton(forces: PeriodicForces, responding: Responses) -> tuple[np.ndarray, np.ndarray]:
    """Return the harmonics of the forces in balance, (lanes, K + 1, forces), and the last relative change of each lane.

    Newton's method from rest, each lane until it has converged: nonlinear forces are replaced by their slopes along the
    motion found last. A lane that does not converge ends with a change above `WORST`, or not a number.
    """
    constant, slope = forces.linear_parts()
    given, linear = _spectrum(constant, responding.top), _slopes(slope, responding.top)
    lanes = given.shape[0]
    found = np.zeros(responding.factors.shape, dtype=complex)
    change = np.full(lanes, np.inf)
    going = np.arange(lanes)
    for _ in range(MOST_STEPS):
        pushes, slopes = _linearised(forces, going, found[going], constant.shape)
        spectrum = given[going] + pushes
        both = _joined(linear.of(going), slopes)
        own = responding.of(going)
        following = own.motions(_with_slopes(spectrum, both, _solved(spectrum, both, own)))
        scale = np.abs(following).max(axis=(1, 2))
        moved = np.abs(following - found[going]).max(axis=(1, 2))
        change[going] = np.divide(moved, scale, out=np.zeros(going.size), where=scale != 0)
        found[going] = following
        going = going[np.isfinite(change[going]) & (change[going] >= TOLERANCE)]
        if not going.size:
            break
    every = np.arange(lanes)
    pushed = _with_slopes(given, linear, found) + _pushed(forces, every, found, constant.shape)
    return pushed, change


def _spectrum(waves: np.ndarray, top: int) -> np.ndarray:
    """Return harmonics 0 to ``top`` of (forces, lanes, instants), shape (lanes, top + 1, forces)."""
    return (np.fft.rfft(waves)[..., : top + 1] / waves.shape[-1]).transpose(1, 2, 0)


def _slopes(slope: dict[tuple[int, int], np.ndarray], top: int) -> Slopes:
    waves = np.array(list(slope.values())).reshape(len(slope), *next(iter(slope.values()), np.zeros((1, 1))).shape)
    pairs = np.array(list(slope)).reshape(-1, 2).astype(int)
    return Slopes(pairs, np.fft.rfft(waves)[..., : 2 * top + 1] / waves.shape[-1])


def _joined(first: Slopes, second: Slopes) -> Slopes:
    if not first.pairs.size:
        return second
    return Slopes(np.concatenate([first.pairs, second.pairs]), np.concatenate([first.spectrum, second.spectrum]))


def _waves(motions: np.ndarray, instants: int) -> np.ndarray:
    """Return x(t) over one period, shape (motions, lanes, instants), from harmonics (lanes, K + 1, motions)."""
    return np.fft.irfft(motions.transpose(2, 0, 1) * instants, instants)


def _pushed(forces: PeriodicForces, lanes: np.ndarray, motions: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return the harmonics (lanes, K + 1, forces) of the nonlinear forces along motions (lanes, K + 1, motions)."""
    x, u = _waves(motions, shape[2]), np.zeros((shape[0], lanes.size, shape[2]))
    system = forces.systems[0]
    for k in forces.nonlinear:
        np.add.at(u, system.outputs[k], forces.pushed(k, lanes, x[system.inputs[k], None])[:, 0])
    return _spectrum(u, motions.shape[1] - 1)


def _linearised(
    forces: PeriodicForces, lanes: np.ndarray, motions: np.ndarray, shape: tuple[int, ...]
) -> tuple[np.ndarray, Slopes]:
    """Return s (lanes, K + 1, forces) and S of the nonlinear forces along a motion, by central differences."""
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
    top = motions.shape[1] - 1
    return _spectrum(constant, top), _slopes(slope, top)


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return (matrices @ vectors[..., None])[..., 0]


def _with_slopes(spectrum: np.ndarray, slopes: Slopes, motions: np.ndarray) -> np.ndarray:
    """Return s_k + sum over l of S_(k-l) x_l, shape (lanes, K + 1, forces); ``motions`` (lanes, K + 1, motions)."""
    if not slopes.pairs.size:
        return spectrum
    before, after = _shifted(slopes.spectrum)
    own = motions[:, :, slopes.pairs[:, 1]].transpose(2, 0, 1)
    added = _times(before, own) + _times(after[..., 1:], np.conj(own[..., 1:]))
    found = spectrum.copy()
    for number, act in enumerate(slopes.pairs[:, 0]):
        found[:, :, act] += added[number]
    return found


def _shifted(spectrum: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return S_(k-l) and S_(k+l) for k, l = 0..K, each (pairs, lanes, K + 1, K + 1)."""
    order = np.arange((spectrum.shape[-1] + 1) // 2)
    lag = order[:, None] - order
    before = spectrum[..., np.abs(lag)]
    return np.where(lag < 0, np.conj(before), before), spectrum[..., order[:, None] + order]


def _solved(spectrum: np.ndarray, slopes: Slopes, responding: Responses) -> np.ndarray:
    """Return the motions (lanes, K + 1, motions) that the forces s + S x make; those that no slope reads stay zero."""
    found = np.zeros(responding.factors.shape, dtype=complex)
    if not slopes.pairs.size:
        return found
    wanted, place = np.unique(responding.directions[slopes.pairs[:, 1]], return_inverse=True)
    own = responding.of_directions[:, :, wanted]
    lanes, orders, size, _ = own.shape
    # Axes: lanes, part and direction and order of the row, then of the column.
    matrix = np.empty((lanes, 2, size, orders, 2, size, orders))
    for at, (acts, before, after) in enumerate(_by_direction(slopes, place, responding.factors)):
        column = own[:, :, :, acts]
        one, other = (column @ before).swapaxes(1, 2), (column @ after).swapaxes(1, 2)
        plus, minus = one + other, one - other
        matrix[:, 0, :, :, 0, at] = -np.real(plus)
        matrix[:, 0, :, :, 1, at] = np.imag(minus)
        matrix[:, 1, :, :, 0, at] = -np.imag(plus)
        matrix[:, 1, :, :, 1, at] = -np.real(minus)
    unknowns = 2 * orders * size
    matrix = matrix.reshape(lanes, unknowns, unknowns)
    matrix[:, np.arange(unknowns), np.arange(unknowns)] += 1.0
    right = _times(own, spectrum).swapaxes(1, 2)
    parts = np.concatenate([np.real(right).reshape(lanes, -1), np.imag(right).reshape(lanes, -1)], axis=1)
    try:
        solution = np.linalg.solve(matrix, parts[..., None]).reshape(lanes, 2, size, orders)
    except np.linalg.LinAlgError:
        solution = np.full((lanes, 2, size, orders), np.nan)
    read = slopes.pairs[:, 1]
    moved = (solution[:, 0] + 1j * solution[:, 1]).swapaxes(1, 2)
    found[:, :, read] = moved[:, :, place] * responding.factors[:, :, read]
    return found


def _by_direction(
    slopes: Slopes, place: np.ndarray, factors: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Give, for each direction, the forces of its pairs and S_(k-l), S_(k+l), each (lanes, K + 1, pairs, K + 1).

    The former multiplies the displacement's harmonic l, the latter its conjugate.
    """
    before, after = _shifted(slopes.spectrum)
    after[..., 0] = 0.0
    for at in range(place.max() + 1):
        own = np.flatnonzero(place == at)
        acts, reads = slopes.pairs[own].T
        factor = factors[:, :, reads].transpose(2, 0, 1)[:, :, None]
        first, second = before[own] * factor, after[own] * np.conj(factor)
        yield acts, first.transpose(1, 2, 0, 3), second.transpose(1, 2, 0, 3)
