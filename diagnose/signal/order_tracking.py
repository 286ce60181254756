"""Computed order tracking: resampling at equal shaft angles, and complex order amplitudes.

Reference: K. R. Fyfe and E. D. S. Munck, "Analysis of computed order tracking", MSSP 11 (1997) 187.
"""

from __future__ import annotations

import numpy as np

from ...simulators.errors import InvalidValueError

_BLOCK = 1 << 20


def phase_from_pulses(
    times_s: np.ndarray, *, samples: int, rate_hz: float, pulses_per_revolution: float = 1.0
) -> np.ndarray:
    """Return the shaft angle in turns at every sample, shape (samples,), from tacho pulse times.

    The angle is 0 at the first pulse, a monotone cubic between pulses, and runs on at the end speeds outside.
    """
    from scipy.interpolate import PchipInterpolator

    if times_s.size < 3:
        raise InvalidValueError(f"{times_s.size} tacho pulses; allowed: 3 or more. Analyse without the tacho channel.")
    turns = np.arange(times_s.size) / pulses_per_revolution
    curve = PchipInterpolator(times_s, turns)
    first_speed = (turns[1] - turns[0]) / (times_s[1] - times_s[0])
    last_speed = (turns[-1] - turns[-2]) / (times_s[-1] - times_s[-2])
    phase = np.empty(samples)
    # In blocks: a long record has many samples, and each step needs an array of them.
    for start in range(0, samples, _BLOCK):
        part = slice(start, min(start + _BLOCK, samples))
        time = np.arange(part.start, part.stop) / rate_hz
        inside = curve(np.clip(time, times_s[0], times_s[-1]))
        inside = np.where(time < times_s[0], (time - times_s[0]) * first_speed, inside)
        phase[part] = np.where(time > times_s[-1], turns[-1] + (time - times_s[-1]) * last_speed, inside)
    return phase


def constant_speed_phase(*, samples: int, rate_hz: float, speed_hz: float) -> np.ndarray:
    """Return the shaft angle in turns at every sample of a machine at constant speed, shape (samples,)."""
    return np.arange(samples) * (speed_hz / rate_hz)


def angular_resample(signals: np.ndarray, *, phase_turns: np.ndarray, samples_per_turn: int) -> np.ndarray:
    """Return the signals at equal shaft angles.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    phase_turns : numpy.ndarray, shape (samples,)
        Rising shaft angle in turns.
    samples_per_turn : int
        Orders up to 0.4 of it are kept within 1e-3; those above 0.6 of it are gone, and what of 0.5 to 0.6 is left
        folds above 0.4 only. The filter follows the speed: where the shaft turns slowly and the new grid is coarser
        than the samples, it is as much lower.

    Returns
    -------
    numpy.ndarray, shape (channels, whole turns * samples_per_turn)
        The first value stands at the first whole turn of the angle.

    Notes
    -----
    Interpolation by a Kaiser-windowed sinc of 32 zero crossings (table of 512 values between two of them, linear),
    stretched by new over old distance where that is above 1 (J. O. Smith and P. Gossett, Proc. ICASSP 9 (1984) 112).
    """
    block = np.ascontiguousarray(np.atleast_2d(np.asarray(signals, dtype=float)))
    if np.any(phase_turns[1:] <= phase_turns[:-1]):
        raise InvalidValueError("The shaft angle does not rise everywhere. Check the tacho channel for false pulses.")
    turns = int(np.floor(phase_turns[-1]) - np.ceil(phase_turns[0]))
    if turns < 1:
        raise InvalidValueError(f"{turns} whole turns in the record; allowed: 1 or more. Give a longer record.")
    from .resample_kernel import interpolate, kernel_table

    wanted = np.ceil(phase_turns[0]) + np.arange(turns * samples_per_turn) / samples_per_turn
    positions = np.interp(wanted, phase_turns, np.arange(phase_turns.size, dtype=float))
    stretch = np.maximum(np.gradient(positions), 1.0) if positions.size > 1 else np.ones(1)
    result = np.empty((block.shape[0], positions.size))
    interpolate(block, positions, stretch, kernel_table(), result)
    return result


def order_amplitudes(
    signals: np.ndarray, *, phase_turns: np.ndarray, orders: np.ndarray | list[float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the complex amplitudes of orders, and their standard deviations.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    phase_turns : numpy.ndarray, shape (samples,)
        Shaft angle in turns; amplitudes are referred to its zero.
    orders : array of float, shape (k,)

    Returns
    -------
    amplitude : numpy.ndarray, complex, shape (channels, k)
        x ~ Re sum_k A_k exp(2 pi i order_k angle): |A| is the peak amplitude, arg A the lead of a cosine on angle 0.
    deviation : numpy.ndarray, shape (channels, k)
        Standard deviation of |A| from the scatter of A over eight Hann segments; NaN with fewer than 16 turns.

    Examples
    --------
    >>> turns = np.arange(8000) / 100
    >>> amplitude, _ = order_amplitudes(2 * np.cos(2 * np.pi * (3 * turns + 0.25))[None], phase_turns=turns, orders=[3])
    >>> round(float(abs(amplitude[0, 0])), 6), round(float(np.angle(amplitude[0, 0]) / 2 / np.pi), 6)
    (2.0, 0.25)
    """
    block = np.atleast_2d(np.asarray(signals, dtype=float))
    orders = np.asarray(orders, dtype=float)
    whole = _demodulated_mean(block, phase_turns, orders, slice(0, block.shape[1]))
    turns = phase_turns[-1] - phase_turns[0]
    if turns < 16:
        return whole, np.full(whole.shape, np.nan)
    edges = np.linspace(0, block.shape[1], 9).astype(int)
    parts = np.stack([_demodulated_mean(block, phase_turns, orders, slice(edges[i], edges[i + 1])) for i in range(8)])
    return whole, np.sqrt((np.abs(parts - parts.mean(axis=0)) ** 2).sum(axis=0) / 7 / 8 / 2)


def _demodulated_mean(block: np.ndarray, phase_turns: np.ndarray, orders: np.ndarray, part: slice) -> np.ndarray:
    signal = block[:, part] - block[:, part].mean(axis=1, keepdims=True)
    angle = phase_turns[part]
    samples = np.arange(signal.shape[1])
    # The window is a Hann in angle, so that neighbouring orders vanish whatever the speed does.
    position = (angle - angle[0]) / (angle[-1] - angle[0])
    window = (0.5 - 0.5 * np.cos(2 * np.pi * position)) * np.gradient(angle, samples)
    weighted = signal * window
    amplitude = np.empty((signal.shape[0], orders.size), dtype=complex)
    for index, order in enumerate(orders):
        amplitude[:, index] = weighted @ np.exp(-2j * np.pi * order * angle)
    return amplitude * (2.0 / window.sum())
