"""Cepstrum of a band: the spacing of its line families in one peak.

Lines at equal distances make the logarithm of the spectrum periodic; its transform has a peak at the quefrency one over
the distance, and at multiples of it (R. B. Randall, MSSP 97 (2017) 3). Families round several carriers add up, however
unequal their lines are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError
from .spectrum import averaged_power_density, fast_length, hann, noise_floor

_FEWEST_BINS = 64
_MOST_PARTS = 8
_PART = 0.6
_LEAST_RATIO = 7.0  # of a part: noise reaches it in one of a thousand bins
_BINS_A_SPACING = 8
_FLOOR = -2.5  # decades of power: further below the noise floor lie zeros, whose logarithm has no lower end


@dataclass(frozen=True, eq=False)
class Cepstrum:
    """Cepstrum of one channel in one band.

    Attributes
    ----------
    quefrency_s : numpy.ndarray, shape (bins,)
    height : numpy.ndarray, shape (bins,)
        Amplitude of the periodic part of ln A(f): 0.5 is a ripple of +-4.3 dB.
    floor : numpy.ndarray, shape (bins,)
        Root of the local mean noise power.
    """

    quefrency_s: np.ndarray
    height: np.ndarray
    floor: np.ndarray

    @property
    def power_ratio(self) -> np.ndarray:
        """Power over mean noise power."""
        return (self.height / np.maximum(self.floor, np.finfo(float).tiny)) ** 2


@dataclass(frozen=True)
class Spacing:
    """A line spacing: its frequency, what one quefrency bin means for it, and the power over noise of its peak."""

    spacing_hz: float
    resolution_hz: float
    power_ratio: float


def band_cepstrum(
    signal: np.ndarray, *, rate_hz: float, low_hz: float, high_hz: float, narrowest_hz: float
) -> Cepstrum:
    """Return the cepstrum of a band of one channel.

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
    rate_hz : float
    low_hz, high_hz : float
        The band; eight of the narrowest spacings or more.
    narrowest_hz : float
        Narrowest line spacing looked for.

    Notes
    -----
    |sum w (ln P - mean) exp(2 pi i f q)| / 2, Hann-weighted over the band. P is an averaged power density with eight
    bins to the narrowest spacing: a finer one would be noise between the lines, for the most part. The modulus is taken
    since a band that does not begin at 0 Hz turns the phase. The noise floor of P is divided off, and with it the slow
    change that resonances make.

    Examples
    --------
    >>> t = np.arange(60000) / 10000
    >>> x = sum(np.cos(2 * np.pi * (800 + 16.7 * k) * t) / (1 + k * k) for k in range(-9, 10))
    >>> found = band_cepstrum(
    ...     x + np.random.default_rng(0).normal(0, 0.1, t.size), rate_hz=10000, low_hz=500, high_hz=1100, narrowest_hz=8
    ... )
    >>> round(line_spacing(found, narrowest_hz=8, widest_hz=80).spacing_hz, 1)
    16.7
    """
    row = np.asarray(signal, dtype=float)
    frequency, density = averaged_power_density(
        row, rate_hz=rate_hz, segment_samples=fast_length(int(_BINS_A_SPACING * rate_hz / narrowest_hz))
    )
    inside = (frequency >= low_hz) & (frequency <= high_hz)
    count = int(inside.sum())
    if count < _FEWEST_BINS:
        raise InvalidValueError(
            f"Band {low_hz} to {high_hz} Hz holds {count} lines of the spectrum; allowed: {_FEWEST_BINS} or more. "
            "Widen it or look for narrower spacings."
        )
    floor = noise_floor(np.sqrt(density), half_width_bins=4 * _BINS_A_SPACING)[0, inside] ** 2
    level = 0.5 * np.log(np.maximum(density[0, inside] / np.maximum(floor, np.finfo(float).tiny), 10**_FLOOR))
    window = hann(count)
    level = level - (level * window).sum() / window.sum()
    height = np.abs(fft.rfft(level * window)) * (2.0 / window.sum())
    quefrency = np.arange(height.size) / (count * float(frequency[1]))
    return Cepstrum(quefrency, height, noise_floor(height, half_width_bins=max(height.size // 16, 20))[0])


def line_spacing(cepstrum: Cepstrum, *, narrowest_hz: float, widest_hz: float) -> Spacing | None:
    """Return the spacing that explains the cepstrum best, or None when the range holds no bin.

    Parameters
    ----------
    cepstrum : Cepstrum
    narrowest_hz, widest_hz : float
        Spacings looked for.

    Notes
    -----
    The evidence of a quefrency is its power ratio and those of its multiples up to the fourth, as a comb makes peaks at
    all of them. The highest evidence is taken, or that of its shortest whole part that has three fifths of it: a comb
    makes no peak at parts of its quefrency. Few and faint lines round several carriers may give a neighbour instead,
    one over the carriers' distance off: look at the lines (`find_families`) as well.
    """
    step = float(cepstrum.quefrency_s[1])
    ratio = cepstrum.power_ratio
    last = ratio.size - 2
    first = max(int(np.ceil(1 / (widest_hz * step))), 3)
    stop = min(int(1 / (narrowest_hz * step)), last)
    if stop < first:
        return None
    near = np.maximum(ratio, np.maximum(np.roll(ratio, 1), np.roll(ratio, -1)))
    bins = np.arange(first, stop + 1)
    evidence = ratio[bins] + sum(
        np.where(number * bins < last, near[np.minimum(number * bins, last)], 0.0) for number in (2, 3, 4)
    )
    best = int(np.argmax(evidence))
    for part in range(_MOST_PARTS, 1, -1):
        low, high = max(round(bins[best] / part) - 1, first), min(round(bins[best] / part) + 1, stop)
        if low <= high:
            shorter = low - first + int(np.argmax(evidence[low - first : high - first + 1]))
            if evidence[shorter] > _PART * evidence[best] and ratio[bins[shorter]] > _LEAST_RATIO:
                best = shorter
                break
    best = int(bins[best])
    left, peak, right = cepstrum.height[best - 1 : best + 2]
    curve = left - 2 * peak + right
    offset = 0.5 * (left - right) / curve if curve < 0 else 0.0
    place = (best + float(np.clip(offset, -0.5, 0.5))) * step
    return Spacing(1.0 / place, step / place**2, float(ratio[best]))
