"""Fast kurtogram: the band in which a signal is most impulsive.

The band is split in 1, 2, 3, 4, 6, 8, 12, ... equal parts, and the spectral kurtosis of each part is that of its
complex envelope, <|z|^4> / <|z|^2>^2 - 2: 0 for Gaussian noise, -1 for a sine, high for rare bursts
(J. Antoni, MSSP 21 (2007) 108). Here the parts are cut out of one Fourier transform, with cosine edges, instead of
being filtered one after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...simulators.errors import InvalidValueError
from .spectrum import fast_length

_EDGE = 8  # one part in so many, at each end of a band, is a cosine flank
_FEWEST_SAMPLES = 128
_RINGING = 4  # samples of a band's envelope at each end that the ends of the record have touched
_SURE = 6.0  # standard deviations: the best of hundreds of bands reaches it in one record of noise out of a hundred


@dataclass(frozen=True, eq=False)
class Kurtogram:
    """Spectral kurtosis of bands.

    Attributes
    ----------
    level : numpy.ndarray, shape (bands,)
        Base-2 logarithm of the number of parts.
    low_hz, high_hz : numpy.ndarray, shape (bands,)
    kurtosis : numpy.ndarray, shape (bands,)
    deviation : numpy.ndarray, shape (bands,)
        Standard deviation of the kurtosis of Gaussian noise in such a band, 2 / sqrt(samples).
    """

    level: np.ndarray
    low_hz: np.ndarray
    high_hz: np.ndarray
    kurtosis: np.ndarray
    deviation: np.ndarray

    @property
    def best(self) -> int:
        """Index of the band with the highest kurtosis, six standard deviations of noise taken off."""
        return int(np.argmax(self.kurtosis - _SURE * self.deviation))

    @property
    def is_significant(self) -> bool:
        """Whether the best band is more impulsive than Gaussian noise."""
        return bool(self.kurtosis[self.best] > _SURE * self.deviation[self.best])


def fast_kurtogram(
    signal: np.ndarray, *, rate_hz: float, narrowest_hz: float | None = None, levels: int = 7
) -> Kurtogram:
    """Return the kurtogram of one channel.

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
    rate_hz : float
    narrowest_hz : float or None
        Bands are no narrower; three times the rate of the impacts looked for keeps them apart.
    levels : int
        At most 2^levels parts; fewer where a band would hold under 128 samples.

    Examples
    --------
    >>> t = np.arange(40000) / 20000
    >>> ring = np.exp(-800 * (t % 0.01)) * np.sin(2 * np.pi * 4200 * t)
    >>> found = fast_kurtogram(ring + np.random.default_rng(0).normal(0, 0.3, t.size), rate_hz=20000)
    >>> bool(found.low_hz[found.best] < 4200 < found.high_hz[found.best])
    True
    """
    from scipy import fft

    row = np.asarray(signal, dtype=float)
    if row.ndim != 1 or row.size < 2 * _FEWEST_SAMPLES:
        raise InvalidValueError(
            f"Signal of shape {row.shape}; allowed: one channel of {2 * _FEWEST_SAMPLES} samples or more."
        )
    row = row - row.mean()
    scale = float(np.sqrt((row**2).mean())) or 1.0
    # Single precision is a hundred thousand times finer than the kurtosis scatters.
    transform = np.asarray(fft.rfft((row / scale).astype(np.float32), n=fast_length(row.size)))
    share = row.size / fast_length(row.size)
    bins = transform.size - 1
    columns: list[list[np.ndarray]] = []
    for parts in _splits(levels):
        width = bins // parts
        if width < _FEWEST_SAMPLES or (parts > 1 and narrowest_hz is not None and 0.5 * rate_hz / parts < narrowest_hz):
            break
        bands = transform[1 : 1 + parts * width].reshape(parts, width) * _flanks(width)
        envelope = np.asarray(fft.ifft(bands, n=fast_length(width), axis=1, overwrite_x=True))
        power = _power(envelope, share)
        mean = power.mean(axis=1)
        kurtosis = np.einsum("ij,ij->i", power, power) / power.shape[1] / np.maximum(mean, 1e-30) ** 2 - 2.0
        low = np.arange(parts) * (0.5 * rate_hz * width / bins)
        independent = width * share
        columns.append(
            [
                np.full(parts, np.log2(parts)),
                low,
                low + 0.5 * rate_hz * width / bins,
                kurtosis.astype(float),
                np.full(parts, 2.0 / np.sqrt(independent)),
            ]
        )
    return Kurtogram(*(np.concatenate(column) for column in zip(*columns, strict=True)))


def _splits(levels: int) -> list[int]:
    """Return 1, 2, 3, 4, 6, 8, 12, ... up to 2^levels."""
    binary = [1 << level for level in range(levels + 1)]
    return sorted([*binary, *(3 * one for one in binary[:-2])])


def _flanks(width: int) -> np.ndarray:
    window = np.ones(width, dtype=np.float32)
    edge = max(width // _EDGE, 1)
    ramp = 0.5 - 0.5 * np.cos(np.pi * (np.arange(edge) + 0.5) / edge)
    window[:edge], window[-edge:] = ramp, ramp[::-1]
    return window


def _power(envelope: np.ndarray, share: float) -> np.ndarray:
    """Return the squared modulus within the record, without its ends."""
    count = int(envelope.shape[1] * share)
    inner = envelope[:, _RINGING : max(count - _RINGING, _RINGING + 1)]
    return np.real(inner) ** 2 + np.imag(inner) ** 2
