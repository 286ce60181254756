"""Vibration velocity and displacement within a band, from acceleration, velocity or displacement.

Integration is a division by j 2 pi f in the frequency domain: the trapezoid rule in time is biased and
drifts. The band has the edges of ISO 2954, a third-order Butterworth magnitude that is -3 dB at both edges:

    |H(f)|^2 = 1 / (1 + (low/f)^6) * 1 / (1 + (f/high)^6)

Two roads lead to a level. ``band_rms`` weights an averaged Hann spectrum: its memory is one segment and it
has no edge effect, so levels come from there. ``band_signal`` gives the waveform, zero phase, faded at both
ends.

Reference: ISO 2954 (measuring instruments for vibration severity); P. Welch, IEEE Trans. Audio 15 (1967) for
the averaged spectrum.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...simulators.errors import InvalidValueError

#: How often each quantity is a time derivative of displacement.
DERIVATIVES = {"displacement": 0, "velocity": 1, "acceleration": 2}

# The weight bends near the lower edge; 32 periods a segment keep the smearing by the window under 0.1 %
# there.
_PERIODS_PER_SEGMENT = 32
# A magnitude alone has a cusp at 0 Hz and hence a kernel that fades slowly; rounding it below a quarter of
# the lower edge, where 36 dB are gone already, lets 16 periods of margin suffice.
_ROUNDING = 4.0
_PERIODS_OF_FADE = 2
_PERIODS_OF_MARGIN = 16
_BLOCK_SAMPLES = 1 << 20


def band_gain(frequency_hz: np.ndarray, *, low_hz: float, high_hz: float) -> np.ndarray:
    """Return the magnitude of the ISO 2954 band, third-order Butterworth at both edges.

    Parameters
    ----------
    frequency_hz : numpy.ndarray, shape (bins,)
        In Hz, of either sign.
    low_hz, high_hz : float
        Edges at -3 dB; ``math.inf`` as the upper edge leaves it open.

    Returns
    -------
    numpy.ndarray, shape (bins,)
        Gain, 0 to 1; 0 at 0 Hz.

    Examples
    --------
    >>> gain = band_gain(np.array([0.0, 10.0, 100.0, 1000.0]), low_hz=10.0, high_hz=1000.0)
    >>> [round(float(value), 3) for value in gain]
    [0.0, 0.707, 1.0, 0.707]
    """
    frequency = np.abs(np.asarray(frequency_hz, dtype=float))
    # (f/low)^6 over 1 plus itself, written so that 0 Hz needs no division.
    lower = (frequency / low_hz) ** 6
    upper = np.zeros_like(frequency) if math.isinf(high_hz) else (frequency / high_hz) ** 6
    return np.sqrt(lower / (1.0 + lower) / (1.0 + upper))


def band_signal(
    signals: np.ndarray, *, rate_hz: float, quantity: str, target: str, low_hz: float, high_hz: float
) -> np.ndarray:
    """Return the waveform of another quantity within the band, zero phase.

    Y(f) = (j 2 pi f)^k |H(f)| X(f), with k the number of derivatives from ``quantity`` to ``target``
    (negative when integrating). Mean and straight trend are removed, and the record fades in and out over two
    periods of the lower edge (a quarter of the record when that is shorter): what came before it is not
    known. Below a quarter of the lower edge the waveform falls off faster than H. Signals over a million
    samples go through in blocks that overlap by 16 periods of the lower edge.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples) or (samples,)
        In SI units of ``quantity``, all finite.
    rate_hz : float
        Sampling rate.
    quantity, target : str
        ``"acceleration"``, ``"velocity"`` or ``"displacement"``; equal ones only filter.
    low_hz, high_hz : float
        Band edges at -3 dB.

    Returns
    -------
    numpy.ndarray, same shape
        In SI units of ``target``. The first and last two periods of the lower edge are faded: do not judge
        them.

    Raises
    ------
    InvalidValueError
        On a quantity, band, rate or length that is not allowed.

    Examples
    --------
    >>> time = np.arange(8192) / 8192
    >>> acceleration = 2 * np.pi * 80 * np.cos(2 * np.pi * 80 * time)
    >>> velocity = band_signal(acceleration, rate_hz=8192.0, quantity="acceleration", target="velocity",
    ...                        low_hz=2.0, high_hz=4000.0)
    >>> bool(np.max(np.abs(velocity - np.sin(2 * np.pi * 80 * time))[2000:-2000]) < 0.01)
    True
    """
    _check(rate_hz=rate_hz, quantity=quantity, target=target, low_hz=low_hz, high_hz=high_hz)
    rows = np.atleast_2d(signals)
    _check_length(rows.shape[1], low_hz=low_hz)
    out = np.empty(rows.shape)
    power = DERIVATIVES[target] - DERIVATIVES[quantity]
    margin = math.ceil(_PERIODS_OF_MARGIN * rate_hz / low_hz)
    block = max(_BLOCK_SAMPLES, 4 * margin)
    for index, row in enumerate(rows):
        offset, slope = _straight_line(row, block)
        for start in range(0, row.size, block):
            first, last = max(start - margin, 0), min(start + block + margin, row.size)
            piece = row[first:last] - (offset + slope * np.arange(first, last))
            extended = _faded(piece, margin, at_start=first == 0, at_end=last == row.size)
            shaped = _shape(extended, rate_hz=rate_hz, power=power, low_hz=low_hz, high_hz=high_hz)
            stop = min(start + block, row.size)
            out[index, start:stop] = shaped[margin : margin + stop - start]
    return out.reshape(np.shape(signals))


def band_velocity(signals: np.ndarray, *, rate_hz: float, quantity: str, low_hz: float, high_hz: float) -> np.ndarray:
    """Return the velocity waveform in m/s within the band; see ``band_signal``."""
    return band_signal(signals, rate_hz=rate_hz, quantity=quantity, target="velocity", low_hz=low_hz, high_hz=high_hz)


def band_displacement(
    signals: np.ndarray, *, rate_hz: float, quantity: str, low_hz: float, high_hz: float
) -> np.ndarray:
    """Return the displacement waveform in m within the band; see ``band_signal``."""
    return band_signal(
        signals, rate_hz=rate_hz, quantity=quantity, target="displacement", low_hz=low_hz, high_hz=high_hz
    )


def band_rms(
    signals: np.ndarray, *, rate_hz: float, quantity: str, target: str, low_hz: float, high_hz: float
) -> np.ndarray:
    """Return the rms of another quantity within the band, from the averaged Hann power spectrum.

    rms^2 = sum over bins of P(f) |H(f)|^2 (2 pi f)^(2k). Segments of 32 periods of the lower edge (or the
    whole record when that is shorter) overlap by half or more and cover every sample; mean and straight trend
    are removed from each, so an offset or a slow drift does not count. Extra memory: a few segments.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples) or (samples,)
        In SI units of ``quantity``. Segments that hold a non-finite sample are left out.
    rate_hz : float
        Sampling rate.
    quantity, target : str
        ``"acceleration"``, ``"velocity"`` or ``"displacement"``.
    low_hz, high_hz : float
        Band edges at -3 dB; ``math.inf`` leaves the upper edge open.

    Returns
    -------
    numpy.ndarray, shape (channels,)
        In SI units of ``target``; NaN for a channel without one finite segment.

    Raises
    ------
    InvalidValueError
        On a quantity, band, rate or length that is not allowed.

    Examples
    --------
    >>> time = np.arange(20_000) / 5000
    >>> velocity = 0.01 * np.sin(2 * np.pi * 52.3 * time) + 3.0
    >>> rms = band_rms(velocity, rate_hz=5000.0, quantity="velocity", target="velocity",
    ...                low_hz=10.0, high_hz=1000.0)
    >>> round(float(rms[0]) * 2**0.5, 4)
    0.01
    """
    _check(rate_hz=rate_hz, quantity=quantity, target=target, low_hz=low_hz, high_hz=high_hz)
    frequency, power = averaged_power(signals, rate_hz=rate_hz, low_hz=low_hz)
    return rms_from_power(frequency, power, quantity=quantity, target=target, low_hz=low_hz, high_hz=high_hz)


def averaged_power(signals: np.ndarray, *, rate_hz: float, low_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the averaged one-sided Hann power spectrum that ``band_rms`` weights.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples) or (samples,)
        Segments that hold a non-finite sample are left out.
    rate_hz : float
        Sampling rate.
    low_hz : float
        Lower edge of the bands to come; sets the length of the segments.

    Returns
    -------
    frequency_hz : numpy.ndarray, shape (bins,)
    power : numpy.ndarray, shape (channels, bins)
        Mean square of each bin, in the signal's unit squared; their sum is the mean square of the signal.

    Raises
    ------
    InvalidValueError
        On fewer than 8 samples.
    """
    rows = np.atleast_2d(signals)
    samples = rows.shape[1]
    _check_length(samples, low_hz=low_hz)
    length = min(samples, 1 << math.ceil(math.log2(max(_PERIODS_PER_SEGMENT * rate_hz / low_hz, 8))))
    window = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(length) + 0.5) / length)
    power = np.array([_mean_power(row, window) for row in rows]) / (length * np.sum(window**2))
    # Every bin but 0 Hz and an even length's last one stands for two.
    power[:, 1 : (length + 1) // 2] *= 2.0
    return np.fft.rfftfreq(length, 1 / rate_hz), power


def rms_from_power(
    frequency_hz: np.ndarray, power: np.ndarray, *, quantity: str, target: str, low_hz: float, high_hz: float
) -> np.ndarray:
    """Return the rms of another quantity within the band from what ``averaged_power`` returns.

    One spectrum serves several targets and bands. Shape (channels,), in SI units of ``target``.
    """
    exponent = DERIVATIVES[target] - DERIVATIVES[quantity]
    return np.sqrt(power @ _response(frequency_hz, power=exponent, low_hz=low_hz, high_hz=high_hz) ** 2)


def band_velocity_rms(
    signals: np.ndarray, *, rate_hz: float, quantity: str, low_hz: float, high_hz: float
) -> np.ndarray:
    """Return the rms velocity in m/s within the band, shape (channels,); see ``band_rms``."""
    return band_rms(signals, rate_hz=rate_hz, quantity=quantity, target="velocity", low_hz=low_hz, high_hz=high_hz)


def band_displacement_rms(
    signals: np.ndarray, *, rate_hz: float, quantity: str, low_hz: float, high_hz: float
) -> np.ndarray:
    """Return the rms displacement in m within the band, shape (channels,); see ``band_rms``."""
    return band_rms(signals, rate_hz=rate_hz, quantity=quantity, target="displacement", low_hz=low_hz, high_hz=high_hz)


def _check(*, rate_hz: float, quantity: str, target: str, low_hz: float, high_hz: float) -> None:
    for name in (quantity, target):
        if name not in DERIVATIVES:
            raise InvalidValueError(
                f"Quantity {name!r} cannot be integrated; allowed: {', '.join(DERIVATIVES)}. "
                "Declare the unit of the signal."
            )
    if not (math.isfinite(rate_hz) and rate_hz > 0):
        raise InvalidValueError(f"Sampling rate {rate_hz} Hz; allowed: a finite number above 0. Pass the true rate.")
    if not 0 < low_hz < high_hz:
        raise InvalidValueError(
            f"Band {low_hz} to {high_hz} Hz; allowed: 0 < lower edge < upper edge. Correct the band."
        )
    if low_hz >= rate_hz / 2:
        raise InvalidValueError(
            f"Lower band edge {low_hz} Hz at a sampling rate of {rate_hz} Hz; allowed: below half the rate, "
            f"{rate_hz / 2:g} Hz. Sample faster."
        )


def _check_length(samples: int, *, low_hz: float) -> None:
    if samples < 8:
        raise InvalidValueError(
            f"Record of {samples} samples; allowed: 8 or more, better {_PERIODS_PER_SEGMENT} periods "
            f"of {low_hz:g} Hz. Use a longer record."
        )


def _response(frequency: np.ndarray, *, power: int, low_hz: float, high_hz: float) -> np.ndarray:
    """Return |H(f)| (2 pi f)^power; 0 at 0 Hz, where the band passes nothing."""
    gain = band_gain(frequency, low_hz=low_hz, high_hz=high_hz)
    gain[1:] *= (2 * np.pi * frequency[1:]) ** power
    return gain


def _mean_power(row: np.ndarray, window: np.ndarray) -> np.ndarray:
    """Return the mean of |FFT|^2 over the finite segments, NaN when there are none."""
    ramp = np.arange(window.size) - (window.size - 1) / 2
    ramp /= np.sqrt(np.dot(ramp, ramp))
    total, count = np.zeros(window.size // 2 + 1), 0
    for segment in _segments(row, window.size):
        # A sample that is not finite makes the mean so.
        with np.errstate(invalid="ignore"):
            mean = segment.mean()
        if math.isfinite(mean):
            segment -= mean
            segment -= ramp * np.dot(ramp, segment)
            segment *= window
            spectrum = np.fft.rfft(segment)
            total += spectrum.real**2 + spectrum.imag**2
            count += 1
    return total / count if count else np.full_like(total, math.nan)


def _segments(row: np.ndarray, length: int) -> Iterator[np.ndarray]:
    """Yield copies of segments that overlap by half or a little more, the last ending on the last sample."""
    spare = row.size - length
    count = math.ceil(spare / (length // 2)) + 1
    for start in np.linspace(0, spare, count).round().astype(int):
        yield np.array(row[start : start + length], dtype=float)


def _straight_line(row: np.ndarray, block: int) -> tuple[float, float]:
    """Return offset and slope a sample of the least-squares line, reading the row in blocks."""
    middle = (row.size - 1) / 2
    mean = float(np.mean(row, dtype=float))
    tilt = 0.0
    for start in range(0, row.size, block):
        piece = np.asarray(row[start : start + block], dtype=float)
        tilt += float(np.dot(np.arange(start, start + piece.size) - middle, piece - mean))
    slope = tilt / (row.size * (row.size**2 - 1) / 12) if row.size > 1 else 0.0
    return mean - slope * middle, slope


def _faded(piece: np.ndarray, margin: int, *, at_start: bool, at_end: bool) -> np.ndarray:
    """Return the piece with ``margin`` samples of run-in and run-out.

    Inside a record the neighbouring samples in ``piece`` serve. Past its ends nothing is known: guessing
    there (reflections) makes steps that integration turns into many times the signal, so the record itself
    fades.
    """
    joined = np.concatenate((np.zeros(margin if at_start else 0), piece, np.zeros(margin if at_end else 0)))
    inside = min(math.ceil(margin * _PERIODS_OF_FADE / _PERIODS_OF_MARGIN), piece.size // 4)
    for values, at_edge in ((joined, at_start), (joined[::-1], at_end)):
        reach = inside if at_edge else margin
        first = margin if at_edge else 0
        values[first : first + reach] *= 0.5 - 0.5 * np.cos(np.pi * np.arange(reach) / max(reach, 1))
    return joined


def _shape(values: np.ndarray, *, rate_hz: float, power: int, low_hz: float, high_hz: float) -> np.ndarray:
    length = 1 << (values.size - 1).bit_length()
    frequency = np.fft.rfftfreq(length, 1 / rate_hz)
    response = _response(frequency, power=power, low_hz=low_hz, high_hz=high_hz) * 1j ** (power % 4)
    response *= -np.expm1(-((_ROUNDING * frequency / low_hz) ** 4))
    return np.fft.irfft(np.fft.rfft(values, length) * response, length)[: values.size]
