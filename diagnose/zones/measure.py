"""The levels that the zone tables ask for, measured on one channel with bounded memory."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

_BLOCK_SAMPLES = 1 << 19


def peak_to_peak(signal: np.ndarray, *, rate_hz: float) -> tuple[float, float]:
    """Return the largest and the median peak-to-peak value of stretches of about one second.

    A stretch of a second holds many turns, and slow drift of a probe's gap does not add up over a long
    record. Both NaN when no sample is finite.
    """
    stretches = max(1, int(signal.size / rate_hz))
    edges = np.linspace(0, signal.size, stretches + 1).round().astype(int)
    found = []
    for start, stop in pairwise(edges):
        values = np.asarray(signal[start:stop], dtype=float)
        values = values[np.isfinite(values)]
        if values.size:
            found.append(float(np.ptp(values)))
    return (max(found), float(np.median(found))) if found else (math.nan, math.nan)


def largest_radius(x: np.ndarray, y: np.ndarray) -> float:
    """Return the largest sqrt(x^2 + y^2), offset included; NaN when no sample is finite in both."""
    largest = math.nan
    for first, second in zip(_blocks(x), _blocks(y), strict=True):
        radius = np.hypot(first, second)
        radius = radius[np.isfinite(radius)]
        if radius.size:
            largest = float(np.fmax(largest, radius.max()))
    return largest


def is_constant(signal: np.ndarray) -> bool:
    """Whether all finite samples have one value, as a dead sensor or a cut cable gives."""
    low, high = math.inf, -math.inf
    for values in _blocks(signal):
        finite = values[np.isfinite(values)]
        if finite.size:
            low, high = min(low, float(finite.min())), max(high, float(finite.max()))
            if high > low:
                return False
    return True


def gap_share(signal: np.ndarray) -> float:
    """Return the share of samples that are not finite, 0 to 1."""
    missing = sum(int(np.count_nonzero(~np.isfinite(values))) for values in _blocks(signal))
    return missing / max(signal.size, 1)


def _blocks(signal: np.ndarray) -> Iterator[np.ndarray]:
    for start in range(0, signal.size, _BLOCK_SAMPLES):
        yield np.asarray(signal[start : start + _BLOCK_SAMPLES], dtype=float)
