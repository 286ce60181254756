"""Spectra with a noise floor, and the chance that noise alone makes a line.

Convention: a sine of amplitude A gives a line of height A. The noise floor is the local mean power of the noise,
estimated by a median so that a few lines do not lift it, however strong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError

_MEDIAN_OF_EXPONENTIAL = np.log(2.0)
_SAMPLES_TOGETHER = 1 << 16
_LONGEST_KEPT = 1 << 15  # samples of a window, a quarter of a MB


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided amplitude spectrum of one or more channels.

    Attributes
    ----------
    frequency_hz : numpy.ndarray, shape (bins,)
    amplitude : numpy.ndarray, shape (channels, bins)
        Peak amplitude of the sine at each bin, in the signal's unit.
    floor : numpy.ndarray, shape (channels, bins)
        Root of the local mean noise power, in the same scale as ``amplitude``.
    padding : float
        Length of the transform over the length of the record, 1 or a little more.
    """

    frequency_hz: np.ndarray
    amplitude: np.ndarray
    floor: np.ndarray
    padding: float = 1.0

    @property
    def resolution_hz(self) -> float:
        """Spacing of the bins."""
        return float(self.frequency_hz[1])

    @cached_property
    def power_ratio(self) -> np.ndarray:
        """Line power over mean noise power; exponential with mean 1 where there is only Gaussian noise."""
        return (self.amplitude / np.maximum(self.floor, np.finfo(float).tiny)) ** 2

    @cached_property
    def highest_ratio(self) -> float:
        """Highest power ratio of all channels and bins."""
        return float(self.power_ratio.max(initial=0.0))

    def each_channel(self) -> list[Spectrum]:
        """Return the channels one by one; their power ratios are computed together."""
        rows = [slice(row, row + 1) for row in range(self.amplitude.shape[0])]
        made = [Spectrum(self.frequency_hz, self.amplitude[one], self.floor[one], self.padding) for one in rows]
        highest = self.power_ratio.max(axis=1, initial=0.0)
        for number, one in enumerate(made):
            one.__dict__.update(power_ratio=self.power_ratio[rows[number]], highest_ratio=float(highest[number]))
        return made


@dataclass(frozen=True, eq=False)
class PlainSpectrum:
    """Amplitude spectra without a noise floor yet; each floor is computed once, whoever asks for it.

    Attributes
    ----------
    frequency_hz : numpy.ndarray, shape (bins,)
    amplitude : numpy.ndarray, shape (channels, bins)
    padding : float
        As in `Spectrum`.
    """

    frequency_hz: np.ndarray
    amplitude: np.ndarray
    padding: float
    _made: dict[int, Spectrum] = field(default_factory=dict)

    def with_floor(self, floor_width_hz: float) -> Spectrum:
        """Return the spectrum with a floor from a neighbourhood of this width, 40 bins at least."""
        half_width = max(20, round(0.5 * floor_width_hz / float(self.frequency_hz[1])))
        if half_width not in self._made:
            floor = noise_floor(self.amplitude, half_width_bins=half_width)
            self._made[half_width] = Spectrum(self.frequency_hz, self.amplitude, floor, self.padding)
        return self._made[half_width]


def hann(samples: int) -> np.ndarray:
    """Return the periodic Hann window of this length, shape (samples,), read-only."""
    # Short ones are kept: a record's bands have the same few lengths again and again.
    return _kept_hann(samples) if samples <= _LONGEST_KEPT else _hann(samples)


def _hann(samples: int) -> np.ndarray:
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(samples) / samples)
    window.setflags(write=False)
    return window


_kept_hann = lru_cache(maxsize=64)(_hann)


@lru_cache(maxsize=512)
def fast_length(samples: int) -> int:
    """Return the smallest length of at least this many samples whose only prime factors are 2, 3 and 5.

    Examples
    --------
    >>> fast_length(121265)
    121500
    """
    best = 1 << max(samples - 1, 1).bit_length()
    five = 1
    while five < best:
        three = five
        while three < best:
            quotient = -(-samples // three)
            best = min(best, three << max(quotient - 1, 0).bit_length())
            three *= 3
        five *= 5
    return best


def fast_length_within(samples: int) -> int:
    """Return the largest length of at most this many samples whose only prime factors are 2, 3 and 5.

    Examples
    --------
    >>> fast_length_within(121265)
    120000
    """
    best, five = 1, 1
    while five <= samples:
        three = five
        while three <= samples:
            best = max(best, three << ((samples // three).bit_length() - 1))
            three *= 3
        five *= 5
    return best


def amplitude_spectrum(signals: np.ndarray, *, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and the Hann-windowed, window-corrected amplitude spectrum.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples) or (samples,)
    rate_hz : float

    Returns
    -------
    frequency_hz : numpy.ndarray, shape (bins,)
    amplitude : numpy.ndarray, shape (channels, bins)
        A(f) = 2 |sum w x exp(-2 pi i f t)| / sum w; a sine on a bin gives its peak amplitude
        (F. J. Harris, Proc. IEEE 66 (1978) 51).

    Examples
    --------
    >>> t = np.arange(1000) / 1000
    >>> f, a = amplitude_spectrum(3 * np.sin(2 * np.pi * 50 * t), rate_hz=1000)
    >>> round(float(a[0, 50]), 6)
    3.0
    """
    block = np.atleast_2d(np.asarray(signals, dtype=float))
    samples = block.shape[1]
    if samples < 16:
        raise InvalidValueError(f"Signal of {samples} samples; allowed: 16 or more. Give a longer record.")
    window = hann(samples)
    centred = block - block.mean(axis=1, keepdims=True)
    # Padding to a length of small factors avoids the slow transform of a prime length.
    length = fast_length(samples)
    transform = np.abs(fft.rfft(centred * window, n=length, axis=1))
    frequency = fft.rfftfreq(length, 1.0 / rate_hz)
    return frequency, transform * (2.0 / window.sum())


def noise_floor(amplitude: np.ndarray, *, half_width_bins: int) -> np.ndarray:
    """Return the root of the local mean noise power, from running medians of the power.

    Parameters
    ----------
    amplitude : numpy.ndarray, shape (channels, bins)
    half_width_bins : int
        Half the width of the neighbourhood; lines must fill less than half of it.

    Notes
    -----
    Noise power in a bin is exponential: its mean is its median over ln 2. Medians are taken at every quarter
    width and joined in the logarithm. Lines of any strength that fill a share s of the bins raise the power by
    -log2(1 - 0.5 / (1 - s)): 0.7 dB for 1/10, 3 dB for 1/3. That is wanted: a line must stand out of its crowd.
    """
    power = np.atleast_2d(amplitude) ** 2
    bins = power.shape[1]
    half = int(min(max(half_width_bins, 4), max(bins // 2 - 1, 1)))
    centres = np.arange(0, bins, max(half // 2, 1))
    if centres[-1] != bins - 1:
        centres = np.append(centres, bins - 1)
    # The window is shifted, not cut, at the ends, so that every median has as many bins.
    starts = np.clip(centres - half, 0, bins - 2 * half)
    # What sliding_window_view gives, without its checks: they take longer than the copy of a short record.
    shape, strides = (len(power), bins - 2 * half + 1, 2 * half), (*power.strides, power.strides[1])
    windows = np.lib.stride_tricks.as_strided(power, shape, strides)[:, starts]
    # Sorting short rows is vectorised and takes an eighteenth of the time of numpy's median.
    windows.sort(axis=2)
    median = 0.5 * (windows[:, :, half - 1] + windows[:, :, half])
    tiny = np.finfo(float).tiny
    logarithm = 0.5 * np.log(np.maximum(median / _MEDIAN_OF_EXPONENTIAL, tiny))
    return np.exp(_between(logarithm, centres))


def _between(values: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Return values joined by straight lines, shape (channels, last centre + 1).

    Parameters
    ----------
    values : numpy.ndarray, shape (channels, centres)
    centres : numpy.ndarray of int, shape (centres,)
        From 0 on, equally spaced but for the last one.
    """
    if centres.size < 3:
        grid = np.arange(int(centres[-1]) + 1)
        return np.array([np.interp(grid, centres, row) for row in values])
    step, last = int(centres[1]), int(centres[-1] - centres[-2])
    rise = np.diff(values, axis=1)
    found = np.empty((len(values), int(centres[-1]) + 1))
    even = (values.shape[1] - 2) * step
    steps = found[:, :even].reshape(len(values), -1, step)
    np.multiply(rise[:, :-1, None], np.arange(step) / step, out=steps)
    steps += values[:, :-2, None]
    found[:, even:] = values[:, -2:-1] + rise[:, -1:] * (np.arange(last + 1) / last)
    return found


def spectrum_with_floor(
    signals: np.ndarray,
    *,
    rate_hz: float,
    floor_width_hz: float,
    plain: PlainSpectrum | None = None,
) -> Spectrum:
    """Return the amplitude spectrum with its noise floor.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples) or (samples,)
    rate_hz : float
    floor_width_hz : float
        Width of the neighbourhood for the floor; widened to 40 bins where the record is short.
    plain : PlainSpectrum or None
        What `plain_spectrum` gives for these signals, where it is known already.
    """
    return (plain or plain_spectrum(signals, rate_hz=rate_hz)).with_floor(floor_width_hz)


def plain_spectrum(signals: np.ndarray, *, rate_hz: float) -> PlainSpectrum:
    """Return `amplitude_spectrum` as what keeps the noise floors that are asked of it."""
    samples = np.shape(signals)[-1]
    return PlainSpectrum(*amplitude_spectrum(signals, rate_hz=rate_hz), fast_length(samples) / samples)


def peak_near(
    spectrum: Spectrum, channel: int, frequency_hz: float, *, tolerance_hz: float
) -> tuple[float, float, float]:
    """Return frequency, amplitude and noise floor of the highest bin within a tolerance, peak interpolated.

    The frequency comes from ``peak_offsets``, the amplitude from the window's known shape at that offset.
    """
    resolution = spectrum.resolution_hz
    last = spectrum.amplitude.shape[1] - 2
    low = min(max(math.ceil((frequency_hz - tolerance_hz) / resolution), 1), last)
    high = min(max(math.floor((frequency_hz + tolerance_hz) / resolution), low), last)
    row = spectrum.amplitude[channel]
    peak = low + int(row[low : high + 1].argmax())
    floor = float(spectrum.floor[channel, peak])
    left, height, right = float(row[peak - 1]), float(row[peak]), float(row[peak + 1])
    if height < left or height < right or height <= 0:
        return peak * resolution, height, floor
    side, neighbour = (1, right) if right >= left else (-1, left)
    lobe = _main_lobe(spectrum.padding)
    offset = min(max(lobe.scale * (neighbour / height - lobe.flat) / (neighbour / height + lobe.pole), 0.0), 0.5)
    return (peak + side * offset) * resolution, height / _hann_line(offset / spectrum.padding), floor


def peak_offsets(row: np.ndarray, bins: np.ndarray, *, padding: float = 1.0) -> np.ndarray:
    """Return the signed offsets in bins of the tones behind local maxima of a Hann spectrum, -0.5 to 0.5.

    With r = higher neighbour / peak the offset is (2 r - 1) / (r + 1) towards that neighbour (T. Grandke, IEEE
    Trans. Instrum. Meas. 32 (1983) 350). A padded transform has a wider main lobe, up to 0.05 bins off that formula;
    its constants then follow from the lobe's shape, error below 1e-4 bins.
    """
    lobe = _main_lobe(padding)
    side = np.where(row[bins + 1] >= row[bins - 1], 1, -1)
    ratio = row[bins + side] / np.maximum(row[bins], np.finfo(float).tiny)
    return side * np.clip(lobe.scale * (ratio - lobe.flat) / (ratio + lobe.pole), 0.0, 0.5)


@dataclass(frozen=True)
class _MainLobe:
    """Constants of offset = scale (r - flat) / (r + pole)."""

    scale: float
    flat: float
    pole: float


@lru_cache(maxsize=64)
def _main_lobe(padding: float) -> _MainLobe:
    """Return the constants that make the offset exact at 0, 1/4 and 1/2 bin; 2, 1/2 and 1 without padding."""
    flat = _hann_line(1 / padding)
    quarter = _hann_line(0.75 / padding) / _hann_line(0.25 / padding)
    pole = (2 * (quarter - flat) - (1 - flat) * quarter) / ((1 - flat) - 2 * (quarter - flat))
    return _MainLobe(0.5 * (1 + pole) / (1 - flat), flat, pole)


def _hann_line(offset: float) -> float:
    """Return the height of a tone's Hann line at a distance in bins of the record's own resolution, 1 at 0."""

    def sinc(x: float) -> float:
        return math.sin(math.pi * x) / (math.pi * x) if x else 1.0

    return sinc(offset) + 0.5 * (sinc(offset - 1) + sinc(offset + 1))


def chance_of_noise(power_ratio: float | np.ndarray, *, bins_searched: float | np.ndarray = 1.0) -> np.ndarray:
    """Return the chance that Gaussian noise alone reaches this line power over mean noise power.

    p = 1 - (1 - exp(-R))^m for the highest of m bins.

    Examples
    --------
    >>> round(float(chance_of_noise(3.0)), 4)
    0.0498
    """
    single = np.exp(-np.asarray(power_ratio, dtype=float))
    return -np.expm1(np.asarray(bins_searched) * np.log1p(-np.minimum(single, 1 - 1e-16)))


def averaged_power_density(
    signals: np.ndarray, *, rate_hz: float, segment_samples: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and Welch's power density, shape (channels, bins), in unit^2/Hz.

    Hann segments with half overlap (P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70).
    """
    block = np.atleast_2d(np.asarray(signals, dtype=float))
    length = int(min(segment_samples, block.shape[1]))
    window = hann(length)
    starts = np.arange(0, block.shape[1] - length + 1, max(length // 2, 1))
    centred = block - block.mean(axis=1, keepdims=True)
    total = np.zeros((block.shape[0], length // 2 + 1))
    # Many short segments in one call, few long ones: the copies stay small.
    together = max(_SAMPLES_TOGETHER // length, 1)
    for first in range(0, starts.size, together):
        segments = np.lib.stride_tricks.sliding_window_view(centred, length, axis=1)[
            :, starts[first : first + together]
        ]
        transform = fft.rfft(segments * window, axis=2)
        total += (transform.real**2 + transform.imag**2).sum(axis=1)
    density = total * (2.0 / (rate_hz * (window**2).sum() * starts.size))
    return fft.rfftfreq(length, 1.0 / rate_hz), density
