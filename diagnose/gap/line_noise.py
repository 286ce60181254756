"""The noise of order amplitudes: their scatter over segments of a record, and how slowly the machine itself changes.

The scatter is taken after the record's own amplitude is taken off, so that it holds both the noise floor and what the
line itself does (wander of speed or load). That of a single line has few degrees of freedom; it is shrunk to the median
of its probe. Whether lines change slowly, from half to half of a record, few clear lines cannot tell: all recordings of
a machine in one state say it together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.errors import InvalidValueError

#: Segments for the noise, and the fewest turns in one: lines half an order apart are told apart in four.
SEGMENTS, LEAST_TURNS = 16, 4.0
FEWEST_SEGMENTS = 4
#: Coefficients of 1, cos, cos 2, ... of windows: main lobes of 2 and 4 lines of the spectrum; the second one's side
#: lobes are 92 dB down (F. J. Harris, Proc. IEEE 66 (1978) 51-83).
HANN, BLACKMAN_HARRIS = (0.5, -0.5), (0.35875, -0.48829, 0.14128, -0.01168)
#: The scatter of one line weighs as many degrees of freedom as it has; the probe's typical scatter weighs this many.
TYPICAL_WEIGHT = 10.0
#: A line is clear from so many standard deviations on; fewer clear ones say nothing of how slowly lines change.
CLEAR, FEWEST_CLEAR = 3.0, 4
#: Deviation of the median of n exponential values over their mean, times the square root of n and 99 % of chance.
MEDIAN_SPREAD = 3.4
#: What halves differ by beyond their noise, between two records: the means of neighbouring stretches of a random walk
#: differ in variance as the stretches are long, so records differ twice as much as their halves, one record by half of
#: that from what both have in common. The noise of halves is four times that of a record in their difference: 4.
BETWEEN_RECORDS = 4.0


class UnusableRecordingError(InvalidValueError):
    """A recording from which no order amplitudes can be taken."""


@dataclass(frozen=True, eq=False)
class Scatter:
    """Lines of a record, and how they scatter in it.

    Attributes
    ----------
    amplitudes : ndarray (channels, orders), complex
    power : ndarray (channels, orders)
        Of the noise of their real (or imaginary) part, by the segments.
    change : ndarray (channels, orders), complex
        From the first half to the second.
    """

    amplitudes: np.ndarray
    power: np.ndarray
    change: np.ndarray

    @property
    def clear(self) -> np.ndarray:
        """Where a line stands out of its noise."""
        return np.abs(self.amplitudes) ** 2 > CLEAR**2 * self.power


def scatter_of(signals: np.ndarray, *, turns: np.ndarray, orders: np.ndarray) -> Scatter:
    """Return the lines of a record with a Hann window over the shaft's angle.

    Parameters
    ----------
    signals : ndarray (channels, samples)
    turns : ndarray (samples,)
        Shaft angle in turns.
    orders : ndarray (orders,)

    Raises
    ------
    UnusableRecordingError
        For too few turns.
    """
    length = float(turns[-1] - turns[0])
    segments = min(SEGMENTS, math.floor(length / LEAST_TURNS))
    if segments < FEWEST_SEGMENTS:
        raise UnusableRecordingError(
            f"Record of {length:.1f} turns of the shaft; allowed: {FEWEST_SEGMENTS * LEAST_TURNS:g} or more. Record "
            "longer."
        )
    centred = signals - signals.mean(axis=1, keepdims=True)
    carriers = carriers_of(orders, turns)
    whole = weighted_mean(centred, turns, carriers)
    edges = np.searchsorted(turns, turns[0] + length * np.arange(1, segments) / segments)
    parts = [slice(a, b) for a, b in zip([0, *edges], [*edges, turns.size], strict=True)]
    scatter = np.stack([weighted_mean(centred[:, part], turns[part], carriers[:, part]) - whole for part in parts])
    # Two real numbers a segment; the record's own amplitude is close to the segments' mean: one segment is lost.
    power = (np.abs(scatter) ** 2).sum(axis=0) / (2 * (segments - 1)) / segments
    own = 2.0 * (segments - 1)
    typical = np.median(power, axis=1, keepdims=True)
    shrunk = (own * power + TYPICAL_WEIGHT * np.minimum(typical, 10 * power + 1e-300)) / (own + TYPICAL_WEIGHT)
    middle = np.searchsorted(turns, turns[0] + length / 2)
    halves = [weighted_mean(centred[:, h], turns[h], carriers[:, h]) for h in (slice(middle), slice(middle, None))]
    return Scatter(whole, shrunk, halves[1] - halves[0])


def deviations_of(records: Sequence[Scatter], every: Sequence[Scatter] = ()) -> list[np.ndarray]:
    """Return the standard deviation of the lines' real (or imaginary) part in each record of one machine's state.

    ``every`` are the records of all its states: slow changes that these show together count here too.
    """
    slowness = max(_slowness_of(records), _slowness_of(every or records))
    excess = BETWEEN_RECORDS * (slowness - 1.0)
    return [np.sqrt(np.maximum(one.power * np.where(one.clear, 1.0 + excess, 1.0), 1e-300)) for one in records]


def _slowness_of(records: Sequence[Scatter]) -> float:
    change = np.concatenate([one.change[one.clear] for one in records])
    return _slowness(change, np.concatenate([one.power[one.clear] for one in records]))


def order_amplitudes_with_noise(
    signals: np.ndarray, *, turns: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return complex amplitudes and the deviation of their real (or imaginary) part, both (channels, orders).

    Of a record by itself; parameters and errors as of `scatter_of`.
    """
    found = scatter_of(signals, turns=turns, orders=orders)
    return found.amplitudes, deviations_of([found])[0]


def _slowness(change: np.ndarray, power: np.ndarray) -> float:
    """Return by how much the noise of clear lines exceeds what their scatter over segments says; 1 where it does not.

    Segments count as independent. A machine's lines also change slowly, from one half of the record to the other by
    more than that.

    Parameters
    ----------
    change : ndarray (lines,), complex
        From the first half to the second.
    power : ndarray (lines,)
        Of the noise in the whole record, of the real part.
    """
    if change.size < FEWEST_CLEAR:
        return 1.0
    # Half as long: twice the noise power in each half, four times in their difference. The median of the power of
    # Gaussian noise is ln 2 of its mean.
    ratio = float(np.median(np.abs(change) ** 2 / (8 * power))) / math.log(2)
    return ratio if ratio > 1 + MEDIAN_SPREAD / math.sqrt(change.size) else 1.0


def weighted_amplitudes(
    signals: np.ndarray, *, turns: np.ndarray, orders: np.ndarray, window: Sequence[float] = HANN
) -> np.ndarray:
    """Return complex amplitudes by a window over the shaft's angle, shape (channels, orders).

    ``window`` are the coefficients of its cosines, `HANN` or `BLACKMAN_HARRIS`.
    """
    centred = signals - signals.mean(axis=1, keepdims=True)
    return weighted_mean(centred, turns, carriers_of(orders, turns), window)


def carriers_of(orders: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return exp(-2 pi i order turns), shape (orders, samples): half orders by products, which cost less than sines."""
    found = np.empty((len(orders), turns.size), dtype=complex)
    halves = 2 * np.asarray(orders, dtype=float)
    is_half = (halves == np.round(halves)) & (halves > 0)
    found[~is_half] = np.exp(-2j * np.pi * np.outer(np.asarray(orders)[~is_half], turns))
    if is_half.any():
        step, power, reached = np.exp(-1j * np.pi * turns), np.ones(turns.size, dtype=complex), 0
        for row in np.argsort(halves, kind="stable"):
            while is_half[row] and reached < halves[row]:
                power *= step
                reached += 1
            if is_half[row]:
                found[row] = power
    return found


def weighted_mean(
    signals: np.ndarray, turns: np.ndarray, carriers: np.ndarray, window: Sequence[float] = HANN
) -> np.ndarray:
    """Return the same for signals without their mean; ``carriers`` (orders, samples) turn each order to rest."""
    position = 2 * np.pi * (turns - turns[0]) / (turns[-1] - turns[0])
    weight = sum(own * np.cos(k * position) for k, own in enumerate(window)) * np.gradient(turns)
    return (signals * weight) @ carriers.T * (2.0 / weight.sum())
