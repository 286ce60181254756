"""Vold-Kalman order waveforms, second generation: complex envelopes of orders, all at once.

The signal is the sum of orders x_k(t) exp(2 pi i order_k angle(t)) and a rest. The envelopes x_k minimise the power of
the rest plus a price on their p-th differences, which sets the bandwidth. Orders that come near each other or cross
share the signal between them, which filters that work one by one cannot
(H. Vold, M. Mains, J. Blough, SAE paper 972007 (1997); J. Tuma, Int. J. Acoust. Vib. 10 (2005), for the bandwidth).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.errors import InvalidValueError
from .vold_kalman_sums import envelopes_and_waves, normal_equations

_KNOTS_A_BANDWIDTH = 48.0
_MOST_POLES = 3
#: Of one over the record's length: the knots then lie two lengths apart, and the equations are still sound.
_NARROWEST = 0.1


@dataclass(frozen=True, eq=False)
class OrderWaveforms:
    """Orders of a record, sample by sample.

    Attributes
    ----------
    orders : numpy.ndarray, shape (orders,)
    envelope : numpy.ndarray, complex, shape (channels, orders, samples)
        Its modulus is the peak amplitude, its argument the lead of a cosine on angle zero.
    waveform : numpy.ndarray, shape (channels, orders, samples)
        Re(envelope exp(2 pi i order angle)).
    residual : numpy.ndarray, shape (channels, samples)
        The signal without all of them.
    """

    orders: np.ndarray
    envelope: np.ndarray
    waveform: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True, eq=False)
class OrderKnots:
    """Orders of a record at knots, from which any part of them is made: an hour of it would fill the memory.

    Attributes
    ----------
    orders : numpy.ndarray, shape (orders,)
    values : numpy.ndarray, complex, shape (channels, knots, orders)
        Envelopes; between knots they are linear.
    distance : int
        Samples between knots.
    phases : numpy.ndarray, shape (1 or orders, samples)
    """

    orders: np.ndarray
    values: np.ndarray
    distance: int
    phases: np.ndarray

    def envelope_at(self, samples: np.ndarray) -> np.ndarray:
        """Return the complex envelopes at samples, shape (channels, orders, samples)."""
        knot = np.asarray(samples) // self.distance
        later = ((samples - knot * self.distance) / self.distance)[None, :, None]
        between = (1 - later) * self.values[:, knot] + later * self.values[:, knot + 1]
        return between.transpose(0, 2, 1)

    def part(self, first: int, last: int) -> tuple[np.ndarray, np.ndarray]:
        """Return envelopes and waveforms of samples ``first`` to ``last`` - 1, shape (channels, orders, samples)."""
        return envelopes_and_waves(self.values, self.phases, self.orders, self.distance, first=first, last=last)


def order_waveforms(
    signals: np.ndarray,
    *,
    rate_hz: float,
    phase_turns: np.ndarray,
    orders: Sequence[float] | np.ndarray,
    bandwidth_hz: float,
    poles: int = 2,
) -> OrderWaveforms:
    """Return the waveforms and envelopes of orders, and what is left without them.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    rate_hz : float
    phase_turns : numpy.ndarray, shape (samples,) or (orders, samples)
        Shaft angle; one a component where they belong to different shafts, a fixed frequency among them.
    orders : sequence of float
        Orders of that angle.
    bandwidth_hz : float
        Full width at -3 dB, from a tenth of one over the record's length. A wider band lets more noise in; in a
        narrower one a resonance comes out too low: 0.6 dB with 1.6 over the seconds in which the run crosses its
        half-power width, 2 dB with 0.8.
    poles : int
        1 to 3: order of the differences, steepness of the filter's flanks.

    Returns
    -------
    OrderWaveforms

    Raises
    ------
    InvalidValueError
        On orders, a bandwidth or poles that are not allowed, or when two orders are the same throughout.

    Notes
    -----
    One lone order is filtered by |H(f)| = 1 / (1 + (sqrt 2 - 1) (2 f / bandwidth)^(2 poles)) at a distance f. The
    envelopes are linear between knots, 48 to a bandwidth, or samples where those are fewer; the equations are Hermitian
    with a band of poles times orders. Where an order exceeds half the sampling rate it is taken as absent.

    Examples
    --------
    >>> angle = np.cumsum(np.linspace(10, 40, 50000)) / 10000
    >>> x = 2 * np.cos(2 * np.pi * angle) + np.cos(2 * np.pi * 3 * angle)
    >>> found = order_waveforms(x, rate_hz=10000, phase_turns=angle, orders=[1, 3], bandwidth_hz=1.0)
    >>> np.abs(found.envelope[0, :, 25000]).round(3).tolist()
    [2.0, 1.0]
    """
    block = np.ascontiguousarray(np.atleast_2d(np.asarray(signals, dtype=float)))
    found = order_knots(
        block, rate_hz=rate_hz, phase_turns=phase_turns, orders=orders, bandwidth_hz=bandwidth_hz, poles=poles
    )
    envelope, wave = found.part(0, block.shape[1])
    return OrderWaveforms(found.orders, envelope, wave, block - wave.sum(axis=1))


def order_knots(
    signals: np.ndarray,
    *,
    rate_hz: float,
    phase_turns: np.ndarray,
    orders: Sequence[float] | np.ndarray,
    bandwidth_hz: float,
    poles: int = 2,
) -> OrderKnots:
    """Return what `order_waveforms` finds at its knots only: the same equations, a small part of the memory."""
    block = np.ascontiguousarray(np.atleast_2d(np.asarray(signals, dtype=float)))
    lines = np.asarray(orders, dtype=float)
    phases = np.ascontiguousarray(np.atleast_2d(np.asarray(phase_turns, dtype=float)))
    _check(block, phases, lines, rate_hz, bandwidth_hz, poles)
    distance = max(int(rate_hz / (_KNOTS_A_BANDWIDTH * bandwidth_hz)), 1)
    gram, right = normal_equations(block, phases, lines, distance)
    gram /= distance
    right /= distance
    values = _solve(gram, right, bandwidth_hz * distance / rate_hz, poles)
    return OrderKnots(lines, values, distance, phases)


def _check(
    block: np.ndarray, phases: np.ndarray, orders: np.ndarray, rate_hz: float, bandwidth_hz: float, poles: int
) -> None:
    if orders.ndim != 1 or not orders.size or not np.isfinite(orders).all() or (orders <= 0).any():
        raise InvalidValueError(f"Orders {orders.tolist()}; allowed: one or more, all above 0.")
    if phases.shape not in ((1, block.shape[1]), (orders.size, block.shape[1])):
        raise InvalidValueError(
            f"Angle of shape {phases.shape} for {orders.size} orders and {block.shape[1]} samples; allowed: one row, "
            "or one an order, as long as the signal."
        )
    narrowest = _NARROWEST * rate_hz / block.shape[1]
    if not narrowest <= bandwidth_hz < 0.25 * rate_hz:
        raise InvalidValueError(
            f"Bandwidth {bandwidth_hz} Hz; allowed: {narrowest:.3g} Hz, a tenth of one over the record's length, and "
            f"more, below {0.25 * rate_hz:g} Hz."
        )
    if not 1 <= poles <= _MOST_POLES:
        raise InvalidValueError(f"{poles} poles; allowed: 1 to {_MOST_POLES}.")
    if block.shape[1] <= poles:
        raise InvalidValueError(f"Signal of {block.shape[1]} samples; allowed: {poles + 1} or more.")
    for one in range(1, orders.size):
        for other in range(one):
            if len(phases) == 1:
                apart = abs(orders[one] - orders[other]) * np.ptp(phases)
            else:
                apart = np.ptp(orders[one] * phases[one] - orders[other] * phases[other])
            if apart < 0.5:
                raise InvalidValueError(
                    f"Orders {orders[other]:g} and {orders[one]:g} are the same over this record; allowed: apart by "
                    "half a turn or more somewhere. Leave one out."
                )


def _solve(gram: np.ndarray, right: np.ndarray, bandwidth: float, poles: int) -> np.ndarray:
    """Return the envelopes at the knots, shape (channels, knots, orders).

    ``bandwidth`` is in cycles a knot. The unknowns stand knot by knot, so that the matrix is banded.
    """
    from scipy.linalg import solveh_banded

    channels, knots, count = right.shape
    price = (math.sqrt(2) - 1) / (2 * math.sin(0.5 * math.pi * bandwidth)) ** (2 * poles)
    bands = np.zeros(((poles + 1) * count, knots * count), dtype=complex)
    for row in range(count):
        for column in range(count):
            # Lower form: bands[i - j, j] = a[i, j].
            if row >= column:
                bands[row - column, column::count] += gram[0, :, row, column]
            bands[count + row - column, column : (knots - 1) * count : count] += gram[1, :-1, row, column]
    differences = np.array([(-1.0) ** (poles - i) * math.comb(poles, i) for i in range(poles + 1)])
    for first in range(poles + 1):
        for second in range(first + 1):
            # Difference number s touches knots s + first and s + second, s = 0 ... knots - poles - 1.
            start, stop = second * count, (knots - poles + second) * count
            bands[(first - second) * count, start:stop] += price * differences[first] * differences[second]
    # Knots without any signal near them, of an order beyond half the sampling rate, hang on the differences alone,
    # whose matrix is singular: enough is added to keep rounding from making it indefinite.
    bands[0] += 1e-12 + 1e-14 * price * 4**poles
    flat = right.reshape(channels, -1).T
    return solveh_banded(bands, flat, lower=True, overwrite_ab=True).T.reshape(channels, knots, count)
