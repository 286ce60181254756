"""What prepares an envelope: deterministic lines taken off, and spectra made flat.

Gears and shafts repeat exactly, bearing impacts slip. A signal and its own past share the lines of the former only:
how coherent they are, frequency by frequency, separates the two (J. Antoni and R. B. Randall, MSSP 18 (2004) 103).
Cepstrum prewhitening makes every line of the spectrum equally high, which takes the power off lines and resonances
alike (P. Borghesani et al., MSSP 36 (2013) 370).
"""

from __future__ import annotations

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError
from .spectrum import hann

_OVERLAP = 4  # frames over each sample
_FEWEST_FRAMES = 8
#: Independent averages a frame's length of record, Hann frames with three quarters overlap (P. D. Welch).
_AVERAGES_A_LENGTH = 2.0


def prewhiten(signals: np.ndarray) -> np.ndarray:
    """Return the signals with every Fourier amplitude equal, at unchanged rms; same shape.

    y = F^-1(X / |X|): the phases are kept, and with them when things happen.

    Parameters
    ----------
    signals : numpy.ndarray, shape (..., samples)

    Examples
    --------
    >>> t = np.arange(1000) / 1000
    >>> white = prewhiten(np.sin(2 * np.pi * 50 * t) + np.random.default_rng(0).normal(0, 0.1, 1000))
    >>> bool(np.ptp(np.abs(np.fft.rfft(white))[1:-1]) < 1e-9)
    True
    """
    array = np.asarray(signals, dtype=float)
    centred = array - array.mean(axis=-1, keepdims=True)
    spectrum = fft.rfft(centred, axis=-1)
    size = np.abs(spectrum)
    # The mean is rounding; so is what lies sixteen decades below the rest.
    size[..., 0] = np.inf
    floor = 1e-15 * np.where(np.isfinite(size), size, 0.0).max(axis=-1, keepdims=True)
    white = fft.irfft(np.where(size > floor, spectrum / np.maximum(size, 1e-300), 0.0), n=array.shape[-1], axis=-1)
    rms = np.sqrt((white**2).mean(axis=-1, keepdims=True))
    return white * (np.sqrt((centred**2).mean(axis=-1, keepdims=True)) / np.maximum(rms, 1e-300))


def separate(
    signal: np.ndarray, *, segment_samples: int, delay_samples: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the deterministic and the random part of one channel; their sum is the signal.

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
    segment_samples : int
        Lines four bins of rate / segment_samples apart are kept apart. The record should hold thirty segments, and
        must hold four.
    delay_samples : int or None
        Between a frame and the past one that it is compared with; rounded to a quarter of a segment. The random part
        must have forgotten itself by then. One segment by default.

    Returns
    -------
    deterministic, random : numpy.ndarray, shape (samples,)

    Notes
    -----
    Each bin is weighted by the coherence g between frames one delay apart, freed of its bias: g^2 -> (n g^2 - 1) /
    (n - 1) with n independent averages. For a line of power r over the noise in its bin g = r / (1 + r), the Wiener
    weight.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> t, noise = np.arange(100000), rng.normal(0, 1, 100000)
    >>> line = np.cos(0.3 * t)
    >>> lines, rest = separate(line + noise, segment_samples=1024)
    >>> bool(np.std(lines - line) < 0.1 and np.std(rest - noise) < 0.1)
    True
    """
    row = np.asarray(signal, dtype=float)
    hop = segment_samples // _OVERLAP
    if row.ndim != 1 or hop < 4 or row.size < 4 * segment_samples:
        raise InvalidValueError(
            f"Segments of {segment_samples} samples in a signal of shape {row.shape}; allowed: 16 or more, and at most "
            "a quarter of one channel."
        )
    length = hop * _OVERLAP
    behind = max(round((length if delay_samples is None else delay_samples) / hop), 1)
    mean = row.mean()
    # Mirrored ends, so that the first and last samples have as many frames as all others.
    tail = -(row.size + 2 * length) % hop
    padded = np.pad(row - mean, (length, length + tail), mode="reflect")
    window = np.sqrt(hann(length))
    frames = np.lib.stride_tricks.sliding_window_view(padded, length)[::hop]
    spectra = fft.rfft(frames * hann(length), axis=1)
    inner = spectra[_OVERLAP : -_OVERLAP or None]
    if inner.shape[0] < behind + _FEWEST_FRAMES:
        raise InvalidValueError(
            f"Delay of {delay_samples} samples; allowed: up to {(inner.shape[0] - _FEWEST_FRAMES) * hop} here. Give a "
            "longer record."
        )
    weight = _line_weight(inner[behind:], inner[:-behind], row.size / length)
    shaped = fft.rfft(frames * window, axis=1) * weight
    pieces = fft.irfft(shaped, n=length, axis=1) * window
    total = _overlap_add(pieces, hop, padded.size) / (0.5 * _OVERLAP)
    deterministic = total[length : length + row.size] + mean
    return deterministic, row - deterministic


def _line_weight(now: np.ndarray, before: np.ndarray, lengths: float) -> np.ndarray:
    """Return the unbiased coherence of frames and their past, 0 to 1, shape (bins,)."""
    cross = np.abs((now * before.conj()).sum(axis=0)) ** 2
    own = (np.abs(now) ** 2).sum(axis=0) * (np.abs(before) ** 2).sum(axis=0)
    averages = max(_AVERAGES_A_LENGTH * lengths, 2.0)
    squared = cross / np.maximum(own, 1e-300)
    return np.sqrt(np.clip((averages * squared - 1.0) / (averages - 1.0), 0.0, 1.0))


def _overlap_add(pieces: np.ndarray, hop: int, samples: int) -> np.ndarray:
    total = np.zeros((samples // hop, hop))
    quarters = pieces.reshape(pieces.shape[0], _OVERLAP, hop)
    for number in range(_OVERLAP):
        total[number : number + pieces.shape[0]] += quarters[:, number]
    return total.ravel()
