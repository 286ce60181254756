"""Envelope analysis: band-pass, analytic signal, spectrum of the envelope, and the choice of the band.

A damaged bearing or tooth strikes at a low rate; each strike rings a resonance. In a band around the resonance the
envelope repeats at the strike rate (Randall and Antoni, MSSP 25 (2011) 485). Envelopes are divided by their mean, so
that a line's height is the modulation depth: about twice the share of the band's energy that comes in that rhythm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError
from .spectrum import Spectrum, fast_length, hann, noise_floor

_SPLITS = (1, 2, 3, 4, 6, 8, 12)


@dataclass(frozen=True, eq=False)
class EnvelopeSpectrum:
    """Spectrum of the envelope of one channel in one band.

    Attributes
    ----------
    channel : int
    low_hz, high_hz : float
        The band.
    kurtosis : float
        Spectral kurtosis of the band, <|z|^4>/<|z|^2>^2 - 2; 0 for Gaussian noise.
    mean : float
        Mean envelope, in the signal's unit.
    spectrum : Spectrum
        One row; amplitudes are modulation depths (envelope line over mean envelope).
    """

    channel: int
    low_hz: float
    high_hz: float
    kurtosis: float
    mean: float
    spectrum: Spectrum


def demodulation_bands(*, lowest_hz: float, highest_hz: float, narrowest_hz: float) -> list[tuple[float, float]]:
    """Return the bands to try: the range split in 1, 2, 3, 4, 6, 8 and 12 equal parts, none below a width.

    This is the tiling of the fast kurtogram (J. Antoni, MSSP 21 (2007) 108).

    Examples
    --------
    >>> demodulation_bands(lowest_hz=0, highest_hz=1200, narrowest_hz=500)
    [(0.0, 1200.0), (0.0, 600.0), (600.0, 1200.0)]
    """
    span = highest_hz - lowest_hz
    bands: list[tuple[float, float]] = []
    for parts in _SPLITS:
        width = span / parts
        if parts > 1 and width < narrowest_hz:
            break
        bands += [(lowest_hz + index * width, lowest_hz + (index + 1) * width) for index in range(parts)]
    return bands


def band_envelope(signal: np.ndarray, *, rate_hz: float, low_hz: float, high_hz: float) -> tuple[np.ndarray, float]:
    """Return the envelope of one channel in a band, and its sampling rate.

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
    rate_hz, low_hz, high_hz : float

    Returns
    -------
    envelope : numpy.ndarray, shape (band samples,)
        Modulus of the analytic signal, sampled at the band's own width: nothing above it is in it.
    envelope_rate_hz : float

    Examples
    --------
    >>> t = np.arange(10000) / 10000
    >>> x = (1 + 0.5 * np.cos(2 * np.pi * 20 * t)) * np.cos(2 * np.pi * 3000 * t)
    >>> envelope, rate = band_envelope(x, rate_hz=10000, low_hz=2500, high_hz=3500)
    >>> round(float(envelope.max()), 2), round(rate)
    (1.5, 1000)
    """
    if not 0 <= low_hz < high_hz <= 0.5 * rate_hz * (1 + 1e-9):
        raise InvalidValueError(f"Band {low_hz}-{high_hz} Hz at rate {rate_hz} Hz; allowed: 0 <= low < high <= rate/2.")
    transform = fft.rfft(signal - np.mean(signal))
    return envelope_from_transform(transform, signal.size, rate_hz=rate_hz, low_hz=low_hz, high_hz=high_hz)


def envelope_from_transform(
    transform: np.ndarray, samples: int, *, rate_hz: float, low_hz: float, high_hz: float
) -> tuple[np.ndarray, float]:
    """Return `band_envelope` from the real Fourier transform of so many samples, shape (samples // 2 + 1,)."""
    low, high = _bins_of_band(transform.size, samples, rate_hz, low_hz, high_hz)
    envelope = _envelopes_of_bands(transform, [(low, high)], samples)[0]
    return envelope, rate_hz * envelope.size / samples


def _bins_of_band(bins: int, samples: int, rate_hz: float, low_hz: float, high_hz: float) -> tuple[int, int]:
    """Return the first bin of a band and one past its last, their number having small factors only."""
    low = max(int(np.ceil(low_hz / rate_hz * samples)), 1)
    high = min(int(high_hz / rate_hz * samples), bins)
    wanted = fast_length(max(high - low, 8))
    high = min(low + wanted, bins)
    return max(high - wanted, 1), high


def _envelopes_of_bands(transform: np.ndarray, bands: list[tuple[int, int]], samples: int) -> np.ndarray:
    """Return the envelopes of bands that are equally wide, shape (bands, band samples)."""
    parts = np.stack([transform[low:high] for low, high in bands])
    width = parts.shape[1]
    # A short cosine edge keeps strong lines just outside from ringing through the whole band.
    edge = max(width // 20, 1)
    ramp = 0.5 - 0.5 * np.cos(np.pi * (np.arange(edge) + 0.5) / edge)
    parts[:, :edge] *= ramp
    parts[:, -edge:] *= ramp[::-1]
    return np.abs(fft.ifft(parts, axis=1)) * (2.0 * width / samples)


def envelope_spectra(
    signals: np.ndarray,
    *,
    rate_hz: float,
    bands: list[tuple[float, float]],
    highest_line_hz: float,
    floor_width_hz: float,
) -> list[EnvelopeSpectrum]:
    """Return the envelope spectrum of every channel in every band.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    rate_hz : float
    bands : list of (low_hz, high_hz)
    highest_line_hz : float
        The spectra are kept up to here.
    floor_width_hz : float
        Width of the noise-floor neighbourhood.
    """
    found: list[EnvelopeSpectrum] = []
    for channel, signal in enumerate(np.atleast_2d(signals)):
        samples = fast_length(signal.size)
        transform = fft.rfft(signal - signal.mean(), n=samples)
        bins = [_bins_of_band(transform.size, samples, rate_hz, low, high) for low, high in bands]
        # Equally wide bands go together: most of the cost of a short record is calls, not arithmetic.
        by_width: dict[int, list[int]] = {}
        for number, (low, high) in enumerate(bins):
            by_width.setdefault(high - low, []).append(number)
        groups = []
        for numbers in by_width.values():
            envelopes = _envelopes_of_bands(transform, [bins[number] for number in numbers], samples)
            band_rate = rate_hz * envelopes.shape[1] / samples
            envelopes = envelopes[:, : int(envelopes.shape[1] * (signal.size / samples))]
            places = [(channel, *bands[number]) for number in numbers]
            groups.append(_modulations(envelopes, band_rate, places, highest_line_hz))
        made = [one for group in _with_floors(groups, floor_width_hz) for one in group]
        own = dict(zip((number for numbers in by_width.values() for number in numbers), made, strict=True))
        found += [own[number] for number in range(len(bands))]
    return found


@dataclass(frozen=True, eq=False)
class _Modulations:
    """Envelope spectra of equally wide bands, still without a noise floor; each row is a band."""

    places: list[tuple[int, float, float]]
    kurtosis: np.ndarray
    mean: np.ndarray
    frequency_hz: np.ndarray
    depth: np.ndarray


def _modulations(
    envelopes: np.ndarray, rate_hz: float, places: list[tuple[int, float, float]], highest_line_hz: float
) -> _Modulations:
    samples = envelopes.shape[1]
    mean = envelopes.mean(axis=1)
    tiny = np.finfo(float).tiny
    power = envelopes * envelopes
    # Pairwise sums: records in single precision stay in it.
    kurtosis = (power * power).mean(axis=1) / np.maximum(power.mean(axis=1) ** 2, tiny) - 2.0
    window = hann(samples)
    transform = fft.rfft((envelopes - mean[:, None]) * window, axis=1)
    frequency = fft.rfftfreq(samples, 1.0 / rate_hz)
    kept = max(int(np.searchsorted(frequency, highest_line_hz)), min(64, frequency.size))
    depth = np.abs(transform[:, :kept]) * (2.0 / (window.sum() * np.maximum(mean, tiny)))[:, None]
    return _Modulations(places, kurtosis, mean, frequency[:kept], depth)


def _with_floors(groups: list[_Modulations], floor_width_hz: float) -> list[list[EnvelopeSpectrum]]:
    """Return the envelope spectra of groups; floors with as many bins are found in one go."""
    halves = [max(20, round(0.5 * floor_width_hz / float(one.frequency_hz[1]))) for one in groups]
    alike: dict[tuple[int, int], list[int]] = {}
    for number, one in enumerate(groups):
        alike.setdefault((one.depth.shape[1], halves[number]), []).append(number)
    floors: dict[int, np.ndarray] = {}
    for (_, half_width), numbers in alike.items():
        together = np.concatenate([groups[number].depth for number in numbers])
        parts = np.cumsum([len(groups[number].depth) for number in numbers])[:-1]
        floor = noise_floor(together, half_width_bins=half_width)
        floors |= dict(zip(numbers, np.split(floor, parts), strict=True))
    found = []
    for number, one in enumerate(groups):
        spectra = Spectrum(one.frequency_hz, one.depth, floors[number]).each_channel()
        values = zip(one.places, one.kurtosis.tolist(), one.mean.tolist(), spectra, strict=True)
        found.append([EnvelopeSpectrum(*place, kurtosis, mean, own) for place, kurtosis, mean, own in values])
    return found


def most_impulsive(envelopes: list[EnvelopeSpectrum], channel: int) -> EnvelopeSpectrum:
    """Return the channel's band with the largest spectral kurtosis: the kurtogram's choice."""
    return max((one for one in envelopes if one.channel == channel), key=lambda one: one.kurtosis)


def squared_envelope(signal: np.ndarray, *, rate_hz: float, low_hz: float, high_hz: float) -> tuple[np.ndarray, float]:
    """Return the squared envelope of one channel in a band over its mean, shape (band samples,), and its rate in Hz."""
    envelope, envelope_rate = band_envelope(signal, rate_hz=rate_hz, low_hz=low_hz, high_hz=high_hz)
    power = envelope**2
    return power / max(float(power.mean()), np.finfo(float).tiny), envelope_rate


def squared_envelope_spectrum(
    signal: np.ndarray, *, rate_hz: float, low_hz: float, high_hz: float, highest_line_hz: float, floor_width_hz: float
) -> Spectrum:
    """Return the spectrum of the squared envelope in a band, over its mean.

    The squared envelope of a band has no lines of its own but those that the band's content beats out: harmonics of a
    rectified shape, which the modulus adds, are absent (J. Antoni, MSSP 21 (2007) 108; N. Sawalhi and R. B. Randall).

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
    rate_hz, low_hz, high_hz : float
    highest_line_hz : float
        The spectrum is kept up to here.
    floor_width_hz : float
        Width of the noise-floor neighbourhood.

    Returns
    -------
    Spectrum
        One row; a line of height 2m is an amplitude modulation 1 + m cos, for small m.

    Examples
    --------
    >>> t = np.arange(20000) / 10000
    >>> x = (1 + 0.1 * np.cos(2 * np.pi * 20 * t)) * np.cos(2 * np.pi * 3000 * t)
    >>> found = squared_envelope_spectrum(
    ...     x, rate_hz=10000, low_hz=2500, high_hz=3500, highest_line_hz=100, floor_width_hz=30
    ... )
    >>> round(float(found.amplitude[0, 40]), 2)
    0.2
    """
    power, envelope_rate = squared_envelope(signal, rate_hz=rate_hz, low_hz=low_hz, high_hz=high_hz)
    window = hann(power.size)
    length = fast_length(power.size)
    transform = fft.rfft((power - power.mean()) * window, n=length)
    frequency = fft.rfftfreq(length, 1.0 / envelope_rate)
    kept = max(int(np.searchsorted(frequency, highest_line_hz)), min(64, frequency.size))
    height = np.abs(transform[:kept])[None, :] * (2.0 / window.sum())
    half_width = max(20, round(0.5 * floor_width_hz / float(frequency[1])))
    return Spectrum(frequency[:kept], height, noise_floor(height, half_width_bins=half_width), length / power.size)
