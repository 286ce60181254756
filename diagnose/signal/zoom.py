"""Zoom spectra: a narrow band of the spectrum on a grid as fine as asked, by the chirp z-transform."""

from __future__ import annotations

import numpy as np

from ...simulators.errors import InvalidValueError
from .spectrum import hann


def zoom_spectrum(
    signals: np.ndarray, *, rate_hz: float, low_hz: float, high_hz: float, lines: int = 400
) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and the Hann-windowed, window-corrected amplitude spectrum of a band.

    The lines stand closer than the record's own resolution, but two tones are kept apart only where they are two of
    its bins or more from each other (L. R. Rabiner, R. W. Schafer, C. M. Rader, Bell Syst. Tech. J. 48 (1969) 1249).

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples) or (samples,)
    rate_hz, low_hz, high_hz : float
    lines : int
        Points from ``low_hz`` to ``high_hz``, both included.

    Returns
    -------
    frequency_hz : numpy.ndarray, shape (lines,)
    amplitude : numpy.ndarray, shape (channels, lines)
        A tone gives its peak amplitude at its own frequency, on a bin of the record or not.

    Examples
    --------
    >>> t = np.arange(1000) / 1000
    >>> f, a = zoom_spectrum(3 * np.cos(2 * np.pi * 50.3 * t), rate_hz=1000, low_hz=48, high_hz=52, lines=401)
    >>> round(float(f[a[0].argmax()]), 2), round(float(a.max()), 3)
    (50.3, 3.0)
    """
    from scipy.signal import zoom_fft

    block = np.atleast_2d(np.asarray(signals, dtype=float))
    if not 0 <= low_hz < high_hz <= 0.5 * rate_hz or lines < 2:
        raise InvalidValueError(
            f"{lines} lines from {low_hz} to {high_hz} Hz at rate {rate_hz} Hz; allowed: 0 <= low < high <= rate/2, 2 "
            "lines or more."
        )
    if block.shape[1] < 16:
        raise InvalidValueError(f"Signal of {block.shape[1]} samples; allowed: 16 or more. Give a longer record.")
    window = hann(block.shape[1])
    centred = block - block.mean(axis=1, keepdims=True)
    transform = zoom_fft(centred * window, [low_hz, high_hz], m=lines, fs=rate_hz, endpoint=True, axis=1)  # pyright: ignore[reportArgumentType]
    return np.linspace(low_hz, high_hz, lines), np.abs(transform) * (2.0 / window.sum())
