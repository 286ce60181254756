"""Compiled interpolation at uneven places. Kept apart because importing numba takes half a second."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...simulators.compiled_code import njit

#: Zero crossings on each side of the interpolating sinc, and table entries between two of them.
HALF_WIDTH = 16
ENTRIES = 512


@lru_cache(maxsize=1)
def kernel_table() -> np.ndarray:
    """Return half of the Kaiser-windowed sinc at distances 0 to 16 in steps of 1/512, with one entry to spare.

    Made once: its Bessel functions cost more than interpolating a short record.
    """
    distance = np.arange(HALF_WIDTH * ENTRIES + 2) / ENTRIES
    window = np.i0(8.0 * np.sqrt(np.clip(1 - (distance / HALF_WIDTH) ** 2, 0.0, 1.0))) / np.i0(8.0)
    return np.where(distance < HALF_WIDTH, np.sinc(distance) * window, 0.0)


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"})
def interpolate(
    signals: np.ndarray, positions: np.ndarray, stretch: np.ndarray, table: np.ndarray, result: np.ndarray
) -> None:
    """Fill ``result`` with the signals at fractional sample numbers, low-passed at 1 / (2 stretch) of the rate.

    Parameters
    ----------
    signals : float64, shape (channels, samples)
    positions, stretch : float64, shape (places,)
        ``stretch`` is 1 or more: the kernel is that much wider, and lower.
    table : float64, from ``kernel_table``
    result : float64, shape (channels, places)
    """
    channels, samples = signals.shape
    widest = 0.0
    for value in stretch:
        widest = max(widest, value)
    weight = np.empty(2 * int(HALF_WIDTH * widest) + 4)
    last = samples - 1
    for place in range(positions.size):
        position, wide = positions[place], stretch[place]
        reach = HALF_WIDTH * wide
        first = int(np.ceil(position - reach))
        count = int(np.floor(position + reach)) - first + 1
        scale = ENTRIES / wide
        for tap in range(count):
            at = abs(first + tap - position) * scale
            cell = int(at)
            weight[tap] = (table[cell] + (at - cell) * (table[cell + 1] - table[cell])) / wide
        for channel in range(channels):
            total = 0.0
            if first >= 0 and first + count <= samples:
                for tap in range(count):
                    total += weight[tap] * signals[channel, first + tap]
            else:
                # Beyond its ends the record is continued by its mirror image, as often as the kernel is wider.
                for tap in range(count):
                    index = abs(first + tap) % (2 * last) if last > 0 else 0
                    total += weight[tap] * signals[channel, index if index <= last else 2 * last - index]
            result[channel, place] = total
