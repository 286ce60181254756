"""Lines of a spectrum that stand above its noise, with how well their place is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .spectrum import Spectrum, peak_offsets

_LINE_THRESHOLD = 12.0  # power over mean noise power of a peak that counts as a line: one noise bin in 160 000


@dataclass(frozen=True, eq=False)
class Peaks:
    """Lines of a spectrum: interpolated frequency, its standard deviation and power ratio, sorted by frequency."""

    frequency_hz: np.ndarray
    deviation_hz: np.ndarray
    power_ratio: np.ndarray
    span_hz: float


def find_peaks(spectrum: Spectrum, channel: int, *, highest_hz: float) -> Peaks:
    """Return the local maxima of one channel that stand above the noise, up to a frequency.

    The deviation of an interpolated peak is that of a tone in white noise, 0.55 bins over the root of the power
    ratio, with a floor of 0.04 bins for the small wander that every real speed has.
    """
    row = spectrum.amplitude[channel]
    ratio = spectrum.power_ratio[channel]
    inner = np.arange(2, min(row.size - 2, int(highest_hz / spectrum.resolution_hz)))
    is_peak = (row[inner] >= row[inner - 1]) & (row[inner] > row[inner + 1]) & (ratio[inner] > _LINE_THRESHOLD)
    bins = inner[is_peak]
    resolution = spectrum.resolution_hz
    deviation = resolution * np.sqrt(0.3 / ratio[bins] + 0.04**2)
    return Peaks(
        (bins + peak_offsets(row, bins, padding=spectrum.padding)) * resolution,
        deviation,
        ratio[bins],
        float(spectrum.frequency_hz[-1]),
    )
