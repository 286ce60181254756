"""What nonlinear forces do along a given motion: their harmonics, and those of their slopes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .periodic_balance import Slopes, slopes_of, spectrum_of
from .periodic_forces import PeriodicForces

NO_PAIRS = np.zeros((0, 2), dtype=int)


def _waves(motions: np.ndarray, instants: int) -> np.ndarray:
    """Return x(t) over one period, shape (motions, lanes, instants), from harmonics (lanes, K + 1, motions)."""
    return np.fft.irfft(motions.transpose(2, 0, 1) * instants, instants)


def pushed_along(
    forces: PeriodicForces, which: Sequence[int], lanes: np.ndarray, motions: np.ndarray, shape: tuple[int, ...]
) -> np.ndarray:
    """Return the harmonics (lanes, K + 1, forces) of nonlinear forces along motions (lanes, K + 1, motions)."""
    x, u = _waves(motions, shape[2]), np.zeros((shape[0], lanes.size, shape[2]))
    system = forces.systems[0]
    for k in which:
        np.add.at(u, system.outputs[k], forces.pushed(k, lanes, x[system.inputs[k], None])[:, 0])
    return spectrum_of(u, motions.shape[1] - 1)


def linearised(
    forces: PeriodicForces,
    lanes: np.ndarray,
    motions: np.ndarray,
    shape: tuple[int, ...],
    which: Sequence[int] | None = None,
) -> tuple[np.ndarray, Slopes]:
    """Return s (lanes, K + 1, forces) and S of nonlinear forces along a motion, by central differences.

    Of all, or of those with the numbers ``which``.
    """
    constant, slope = slopes_along(forces, lanes, motions, shape, which)
    top = motions.shape[1] - 1
    if not slope:
        return spectrum_of(constant, top), Slopes(NO_PAIRS, np.zeros((0, lanes.size, 2 * top + 1), dtype=complex))
    return spectrum_of(constant, top), slopes_of(slope, top)


def slopes_along(
    forces: PeriodicForces,
    lanes: np.ndarray,
    motions: np.ndarray,
    shape: tuple[int, ...],
    which: Sequence[int] | None = None,
) -> tuple[np.ndarray, dict[tuple[int, int], np.ndarray]]:
    """Return the same over the period: s (forces, lanes, instants), S by (force, motion), each (lanes, instants)."""
    x, constant = _waves(motions, shape[2]), np.zeros((shape[0], lanes.size, shape[2]))
    slope: dict[tuple[int, int], np.ndarray] = {}
    system = forces.systems[0]
    for k in forces.nonlinear if which is None else which:
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
