"""Sizes of lines without phase on a scale that is logarithmic above their noise.

A machine that does not repeat itself shows hundreds of lines whose size no model predicts to better than a factor, and
where a resonance has shifted to no better than to ten. On this scale, D arsinh(size / D), a factor is a difference: one
line that is thirty times too small says no more than its share, and three times too small is as far off as three times
too large. Below the knee D, a few times the noise, it is the size itself. Lines of the envelope are on it with any
machine: how hard balls strike, and what passes to a sensor, is told to a factor only. By their sizes alone a fit would
end where all lines are simulated too large: what is wrong is a share of what is simulated, and that share costs little.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from .lines import OrderLines

#: The knee, in the smallest standard deviation of the line.
KNEE = 3.0
#: Standard deviations down to which the scale's slope counts for the deviation of a size.
NOISE_REACHES = 3.0
#: Share of its deviation below which a size is nothing.
NOTHING = 1e-9
#: Largest size over knee, as logarithm, that is turned back.
LARGEST = 60.0


def knees_of(sets: Sequence[OrderLines], *, envelope_only: bool = False) -> np.ndarray:
    """Return the knee of each line without phase, shape (probes, orders); infinite where the scale is the size itself.

    Parameters
    ----------
    sets : sequence of OrderLines
        All that are compared: of the same probes and lines.
    envelope_only : bool
        Of lines of the envelope, not of those in the spectrum.
    """
    least = np.min([one.deviations.min(axis=0) for one in sets], axis=0)
    sizes = np.array([kind.envelope if envelope_only else not kind.phase for kind in sets[0].kinds])
    return np.where(sizes & (least > 0), KNEE * least, np.inf)


def to_scale(sizes: np.ndarray, knees: np.ndarray | None) -> np.ndarray:
    """Return lines (..., probes, orders), complex, with sizes on the scale."""
    if knees is None:
        return sizes
    own = np.isfinite(knees)
    knee = np.where(own, knees, 1.0)
    return np.where(own, knee * np.arcsinh(np.real(sizes) / knee), sizes)


def from_scale(values: np.ndarray, knees: np.ndarray | None) -> np.ndarray:
    """Return lines (..., probes, orders), complex, with sizes in the probes' units again."""
    if knees is None:
        return values
    own = np.isfinite(knees)
    knee = np.where(own, knees, 1.0)
    return np.where(own, knee * np.sinh(np.clip(np.real(values) / knee, -LARGEST, LARGEST)), values)


def on_scale(lines: OrderLines, knees: np.ndarray) -> OrderLines:
    """Return the lines with sizes and their deviations on the scale.

    The knee is that of the quietest record. In a noisier one a size that is all noise lies above it, where the scale is
    so flat that by its slope there noise would be far from nothing: three deviations stay three.
    """
    deviations = _deviations_as(lines, knees, _drop_on_scale)
    return replace(lines, amplitudes=to_scale(lines.amplitudes, knees), deviations=deviations, knees=knees)


def in_units(lines: OrderLines) -> OrderLines:
    """Return the lines with sizes and their deviations in the probes' units."""
    if lines.knees is None:
        return lines
    deviations = _deviations_as(lines, lines.knees, _drop_in_units)
    return replace(lines, amplitudes=from_scale(lines.amplitudes, lines.knees), deviations=deviations, knees=None)


def _deviations_as(lines: OrderLines, knees: np.ndarray, dropped: Callable[..., np.ndarray]) -> np.ndarray:
    """Return the deviations of sizes that are turned: by the mean slope over `NOISE_REACHES` of them, above nothing."""
    own = np.isfinite(knees)
    sizes = np.where(own, np.abs(lines.amplitudes), 0.0)
    down = np.minimum(NOISE_REACHES * lines.deviations, sizes)
    knee, told = np.where(own, knees, 1.0), (down > 0) & (down > NOTHING * lines.deviations)
    slope = np.divide(dropped(sizes / knee, down / knee), down / knee, out=np.ones(sizes.shape), where=told)
    return lines.deviations * slope


def _drop_on_scale(size: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Return arsinh(size) - arsinh(size - down), without the difference of two numbers that are nearly the same."""
    low = size - down
    high_root, low_root = np.hypot(1.0, size), np.hypot(1.0, low)
    return np.log1p(down * (1 + (size + low) / (high_root + low_root)) / (low + low_root))


def _drop_in_units(value: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Return sinh(value) - sinh(value - down), likewise."""
    return 2 * np.cosh(np.minimum(value, LARGEST) - down / 2) * np.sinh(down / 2)


def at_most_once(change: np.ndarray, knees: np.ndarray | None) -> np.ndarray:
    """Return changes of lines with those of sizes as large as a tolerance refers to, (..., probes, orders).

    Half of a line and half of one that is ten times as large are the same difference on the scale: a tolerance is that
    factor, and less where the line itself changes by less.
    """
    if knees is None:
        return change
    return np.where(np.isfinite(knees), np.clip(np.real(change), -knees, knees), change)


def gained(lines: np.ndarray, knees: np.ndarray | None) -> np.ndarray:
    """Return by how much lines (..., probes, orders) on the scale change with their probe's gain: derivative at 1."""
    if knees is None:
        return lines
    own = np.isfinite(knees)
    knee = np.where(own, knees, 1.0)
    return np.where(own, knee * np.tanh(np.real(lines) / knee), lines)
