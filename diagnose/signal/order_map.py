"""Order maps and waterfalls: lines over the run of a machine, against shaft order or against frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError
from .order_tracking import angular_resample
from .spectrum import fast_length, hann

_KEPT = 0.4  # of the samples a turn: the orders that angular resampling leaves untouched
_LEAST_PER_TURN = 16


@dataclass(frozen=True, eq=False)
class OrderMap:
    """Complex amplitudes over shaft order and time.

    Attributes
    ----------
    time_s, turns, speed_hz : numpy.ndarray, shape (frames,)
        Middle of each frame: time and shaft angle from the record's start and zero, and the speed there.
    orders : numpy.ndarray, shape (orders,)
        In steps of one over the turns of a frame.
    amplitude : numpy.ndarray, complex, shape (channels, frames, orders)
        Its modulus is the peak amplitude of a sine (Hann window); its argument the lead over angle zero, which is a
        tacho pulse where the angle comes from one.
    """

    time_s: np.ndarray
    turns: np.ndarray
    speed_hz: np.ndarray
    orders: np.ndarray
    amplitude: np.ndarray


@dataclass(frozen=True, eq=False)
class Waterfall:
    """Amplitudes over frequency and time, with the speed: the data of waterfall and Campbell diagrams.

    Attributes
    ----------
    time_s, speed_hz : numpy.ndarray, shape (frames,)
        Middle of each frame, and the mean speed in it.
    frequency_hz : numpy.ndarray, shape (bins,)
    amplitude : numpy.ndarray, shape (channels, frames, bins)
        Peak amplitude of a sine.
    """

    time_s: np.ndarray
    speed_hz: np.ndarray
    frequency_hz: np.ndarray
    amplitude: np.ndarray


def order_map(
    signals: np.ndarray,
    *,
    rate_hz: float,
    phase_turns: np.ndarray,
    highest_order: float,
    turns_a_frame: int = 16,
    turns_a_step: int = 4,
) -> OrderMap:
    """Return the order map of a record: Hann-windowed frames of whole turns, resampled at equal shaft angles.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    rate_hz : float
    phase_turns : numpy.ndarray, shape (samples,)
        Rising shaft angle.
    highest_order : float
        Orders that exceed half the sampling rate at the lowest speed are empty there.
    turns_a_frame, turns_a_step : int
        The resolution is one over ``turns_a_frame``; lines two steps of it apart do not touch.

    Raises
    ------
    InvalidValueError
        On a record shorter than a frame, or a frame or step below one turn.

    Examples
    --------
    >>> phase = np.cumsum(np.linspace(10, 30, 20000)) / 5000
    >>> found = order_map(2 * np.cos(2 * np.pi * 3 * phase), rate_hz=5000, phase_turns=phase, highest_order=8)
    >>> bool(np.abs(np.abs(found.amplitude[0, :, found.orders == 3]) - 2).max() < 0.01)
    True
    """
    if turns_a_frame < 1 or turns_a_step < 1 or not highest_order > 0:
        raise InvalidValueError(
            f"Frames of {turns_a_frame} turns in steps of {turns_a_step} up to order {highest_order}; allowed: whole "
            "turns of at least 1 and an order above 0."
        )
    per_turn = _for_whole_frames(highest_order, turns_a_frame)
    even = angular_resample(signals, phase_turns=phase_turns, samples_per_turn=per_turn)
    length = per_turn * turns_a_frame
    if even.shape[1] < length:
        raise InvalidValueError(
            f"Record of {even.shape[1] // per_turn} whole turns; allowed: {turns_a_frame} (one frame) or more. Give a "
            "longer record or shorter frames."
        )
    window = hann(length)
    frames = np.lib.stride_tricks.sliding_window_view(even, length, axis=1)[:, :: per_turn * turns_a_step]
    kept = math.floor(highest_order * turns_a_frame) + 1
    amplitude = fft.rfft(frames * (window * (2.0 / window.sum())), axis=2)[:, :, :kept]
    orders = np.arange(kept) / turns_a_frame
    first = math.ceil(phase_turns[0]) + turns_a_step * np.arange(frames.shape[1])
    # A frame begins at a whole turn: only fractional orders have turned on since angle zero.
    amplitude = amplitude * np.exp(-2j * np.pi * ((first[:, None] * orders[None, :]) % 1.0))
    middle = first + turns_a_frame / 2
    position = np.interp(middle, phase_turns, np.arange(phase_turns.size))
    return OrderMap(position / rate_hz, middle, _slope_at(phase_turns, position) * rate_hz, orders, amplitude)


def _for_whole_frames(highest_order: float, turns_a_frame: int) -> int:
    """Return a few more samples a turn than needed, so that the length of a frame has small factors only.

    But those of its turns: no number of samples takes a 7 or an 11 out of them.
    """
    per_turn = samples_a_turn(highest_order)
    if fast_length(turns_a_frame) != turns_a_frame:
        return fast_length(per_turn)
    while fast_length(per_turn * turns_a_frame) != per_turn * turns_a_frame:
        per_turn += 1
    return per_turn


def _slope_at(values: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the gradient of a sequence at fractional places, without making it everywhere."""
    left = np.minimum(position.astype(int), values.size - 2)

    def slope(at: np.ndarray) -> np.ndarray:
        before, after = np.maximum(at - 1, 0), np.minimum(at + 1, values.size - 1)
        return (values[after] - values[before]) / (after - before)

    later = position - left
    return (1 - later) * slope(left) + later * slope(left + 1)


def samples_a_turn(highest_order: float) -> int:
    """Return how many samples a turn leave all orders up to one untouched by angular resampling."""
    return max(math.ceil(highest_order / _KEPT), _LEAST_PER_TURN)


def waterfall(
    signals: np.ndarray,
    *,
    rate_hz: float,
    phase_turns: np.ndarray | None = None,
    highest_hz: float,
    resolution_hz: float,
    frames: int = 120,
) -> Waterfall:
    """Return spectra over time, with the speed where the shaft angle is known.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    rate_hz : float
    phase_turns : numpy.ndarray, shape (samples,), or None
        None gives speeds of NaN.
    highest_hz, resolution_hz : float
        Frames last 1 / resolution_hz, padded by up to an eighth; lines two steps apart do not touch.
    frames : int
        How many, evenly over the record.
    """
    block = np.atleast_2d(np.asarray(signals, dtype=float))
    length = int(min(round(rate_hz / resolution_hz), block.shape[1])) if resolution_hz > 0 else 0
    if length < 16:
        raise InvalidValueError(
            f"Resolution {resolution_hz} Hz at {rate_hz} Hz; allowed: above 0 and up to {rate_hz / 16:.3g} Hz."
        )
    starts = np.unique(np.linspace(0, block.shape[1] - length, max(frames, 1)).astype(int))
    window = hann(length)
    padded = fast_length(length)
    pieces = np.lib.stride_tricks.sliding_window_view(block, length, axis=1)[:, starts]
    pieces = pieces - pieces.mean(axis=2, keepdims=True)
    frequency = fft.rfftfreq(padded, 1 / rate_hz)
    kept = int(np.searchsorted(frequency, highest_hz, side="right"))
    amplitude = np.abs(fft.rfft(pieces * (window * (2.0 / window.sum())), n=padded, axis=2)[:, :, :kept])
    if phase_turns is None:
        speed = np.full(starts.size, np.nan)
    else:
        speed = (phase_turns[starts + length - 1] - phase_turns[starts]) * (rate_hz / (length - 1))
    return Waterfall((starts + length / 2) / rate_hz, speed, frequency[:kept], amplitude)
