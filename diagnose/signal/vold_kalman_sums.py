"""Sums of the Vold-Kalman filter over samples, in parts that fit the cache.

In numpy, not compiled: loading compiled code costs 0.7 s, the sums of a record take a hundredth of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_SAMPLES_AT_ONCE = 1 << 14


def normal_equations(
    signals: np.ndarray, phases: np.ndarray, orders: np.ndarray, distance: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the least-squares equations of envelopes that are linear between knots.

    Parameters
    ----------
    signals : float64, shape (channels, samples)
    phases : float64, shape (1 or orders, samples)
        Shaft angle in turns; one for all orders, or one each.
    orders : float64, shape (orders,)
    distance : int
        Samples between knots.

    Returns
    -------
    gram : complex128, shape (2, knots, orders, orders)
        Products of each knot with itself and with the next one, Hermitian in the orders.
    right : complex128, shape (channels, knots, orders)
    """
    channels, samples = signals.shape
    spans = (samples - 1) // distance + 1
    gram = np.zeros((2, spans + 1, orders.size, orders.size), dtype=complex)
    right = np.zeros((channels, spans + 1, orders.size), dtype=complex)
    later = np.arange(distance) / distance
    linear = np.column_stack([1 - later, later]).astype(complex)
    square = np.column_stack([(1 - later) ** 2, later * (1 - later), later**2]).astype(complex)
    at_once = max(_SAMPLES_AT_ONCE // distance, 1)
    for first in range(0, spans, at_once):
        here, after = slice(first, min(first + at_once, spans)), slice(first + 1, min(first + at_once, spans) + 1)
        begin, end = first * distance, min(here.stop * distance, samples)
        against = [_spans(wave, distance) for wave in carriers(phases, orders, begin, end)]
        values = [_spans(2.0 * signal[begin:end], distance) for signal in signals]
        for row, one in enumerate(against):
            for column in range(row + 1):
                own, across, following = (one * against[column].conj() @ square).T
                gram[0, here, row, column] += own
                gram[1, here, row, column] += across
                gram[0, after, row, column] += following
            for channel, value in enumerate(values):
                # A real signal is half the sum of the wave and its conjugate.
                own, following = (one * value @ linear).T
                right[channel, here, row] += own
                right[channel, after, row] += following
    for row in range(orders.size):
        for column in range(row):
            gram[:, :, column, row] = gram[:, :, row, column].conj()
    return gram, right


def envelopes_and_waves(
    knots: np.ndarray, phases: np.ndarray, orders: np.ndarray, distance: int, *, first: int, last: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the envelopes between the knots, and the real waves that they carry.

    Parameters
    ----------
    knots : complex128, shape (channels, knots, orders)
    phases : float64, shape (1 or orders, samples)
    first, last : int
        Samples wanted: ``first`` to ``last`` - 1.

    Returns
    -------
    envelope, wave : complex128 and float64, shape (channels, orders, last - first)
    """
    shape = (knots.shape[0], orders.size, last - first)
    envelope, wave = np.empty(shape, dtype=complex), np.empty(shape)
    for begin in range(first, last, _SAMPLES_AT_ONCE):
        end = min(begin + _SAMPLES_AT_ONCE, last)
        knot, place = np.divmod(np.arange(begin, end), distance)
        later, kept = place / distance, slice(begin - first, end - first)
        for order, against in enumerate(carriers(phases, orders, begin, end)):
            for channel, values in enumerate(knots[:, :, order]):
                value = (1 - later) * values[knot] + later * values[knot + 1]
                envelope[channel, order, kept] = value
                wave[channel, order, kept] = value.real * against.real + value.imag * against.imag
    return envelope, wave


def carriers(phases: np.ndarray, orders: np.ndarray, begin: int, end: int) -> list[NDArray[np.complex128]]:
    """Return exp(-2 pi i order angle) of samples ``begin`` to ``end`` - 1, an array for each order.

    What turns by more than half a turn a sample was never in the signal: nothing is there.
    """
    at = np.arange(begin, end)
    low, high = np.maximum(at - 1, 0), np.minimum(at + 1, phases.shape[1] - 1)
    turned = abs(phases[:, high] - phases[:, low])
    found = []
    for number, order in enumerate(orders):
        row = number if len(phases) > 1 else 0
        turn = order * phases[row, begin:end]
        angle = (turn - np.floor(turn)) * (-2 * np.pi)
        wave = np.empty(end - begin, dtype=np.complex128)
        wave.real, wave.imag = np.cos(angle), np.sin(angle)
        beyond = abs(order) * turned[row] >= 0.5 * (high - low)
        if beyond.any():
            wave[beyond] = 0
        found.append(wave)
    return found


def _spans(values: np.ndarray, distance: int) -> np.ndarray:
    """Return samples a knot a row; the last row is filled with nothing."""
    rows = -(-values.size // distance)
    if rows * distance == values.size:
        return values.reshape(rows, distance)
    padded = np.zeros(rows * distance, dtype=values.dtype)
    padded[: values.size] = values
    return padded.reshape(rows, distance)
