"""Compiled parts of the Vold-Kalman filter. Kept apart because importing numba takes half a second."""

from __future__ import annotations

import numpy as np

from ...simulators.compiled_code import njit


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"})
def normal_equations(
    signals: np.ndarray, phases: np.ndarray, orders: np.ndarray, distance: int, gram: np.ndarray, right: np.ndarray
) -> None:
    """Add up the least-squares equations of envelopes that are linear between knots.

    Parameters
    ----------
    signals : float64, shape (channels, samples)
    phases : float64, shape (1 or orders, samples)
        Shaft angle in turns; one for all orders, or one each.
    orders : float64, shape (orders,)
    distance : int
        Samples between knots.
    gram : complex128, shape (2, knots, orders, orders), zero
        Products of each knot with itself and with the next one.
    right : complex128, shape (channels, knots, orders), zero
    """
    channels, samples = signals.shape
    count = orders.size
    waves = np.zeros(count, dtype=np.complex128)
    for sample in range(samples):
        knot = sample // distance
        later = (sample - knot * distance) / distance
        for order in range(count):
            waves[order] = _wave(phases, orders, order, sample)
        for row in range(count):
            for column in range(count):
                product = np.conj(waves[row]) * waves[column]
                gram[0, knot, row, column] += (1 - later) ** 2 * product
                gram[1, knot, row, column] += later * (1 - later) * product
                gram[0, knot + 1, row, column] += later**2 * product
            for channel in range(channels):
                # A real signal is half the sum of the wave and its conjugate.
                part = 2.0 * signals[channel, sample] * np.conj(waves[row])
                right[channel, knot, row] += (1 - later) * part
                right[channel, knot + 1, row] += later * part


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"})
def envelopes_and_waves(
    knots: np.ndarray,
    phases: np.ndarray,
    orders: np.ndarray,
    distance: int,
    before: int,
    envelope: np.ndarray,
    wave: np.ndarray,
) -> None:
    """Fill the envelopes between the knots, and the real waves that they carry.

    Parameters
    ----------
    knots : complex128, shape (channels, knots, orders)
    phases : float64, shape (1 or orders, before + samples)
    before : int
        Samples of the angle ahead of the first knot.
    envelope : complex128, shape (channels, orders, samples)
    wave : float64, shape (channels, orders, samples)
    """
    channels, count, samples = envelope.shape
    for order in range(count):
        for sample in range(samples):
            knot = sample // distance
            later = (sample - knot * distance) / distance
            carrier = _wave(phases, orders, order, before + sample)
            for channel in range(channels):
                value = (1 - later) * knots[channel, knot, order] + later * knots[channel, knot + 1, order]
                envelope[channel, order, sample] = value
                wave[channel, order, sample] = (value * carrier).real


@njit(cache=True, error_model="numpy", inline="always")
def _wave(phases: np.ndarray, orders: np.ndarray, order: int, sample: int) -> complex:
    row = order if phases.shape[0] > 1 else 0
    before, after = max(sample - 1, 0), min(sample + 1, phases.shape[1] - 1)
    turn = orders[order] * phases[row, sample]
    # What turns by more than half a turn a sample was never in the signal.
    if abs(orders[order] * (phases[row, after] - phases[row, before])) >= 0.5 * (after - before):
        return 0.0 + 0.0j
    angle = 2 * np.pi * (turn - np.floor(turn))
    return complex(np.cos(angle), np.sin(angle))
