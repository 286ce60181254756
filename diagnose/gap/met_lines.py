"""Lines that move with the shaft and meet a line at a fixed frequency.

Its phase against the shaft is any there. And what stands at a fixed frequency in one recording may be no more than a
line of the machine that passes: a gearbox has so many that some lie anywhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...datasets.recording import Recording
from .line_sizes import LEAST_BINS, WANDER
from .lines import LineKind, OrderLines
from .observe import observe_orders

#: Half width of a Hann window's main lobe in lines of the spectrum.
MAIN_LOBE = 2.0
#: A fixed line counts in a condition where it is so many deviations large.
CLEAR = 3.0


def with_met_lines(lines: OrderLines, durations_s: Sequence[float]) -> OrderLines:
    """Return the lines, one less certain by the size of the line at a fixed frequency that it meets in a record.

    Orders, and lines beside them (1X + 1 Hz). That size is the median of those in the other conditions, 0 where the
    line is not clear in most of them: hum keeps its size, its phase at the tacho's pulse is any.

    Parameters
    ----------
    lines : OrderLines
    durations_s : sequence of float (conditions,)
        Of the records, which say how close two lines may lie.
    """
    places = [*zip(lines.orders, lines.kinds, strict=True)]
    fixed = _fixed(lines)
    moves = np.array([bool(order) and not kind.envelope for order, kind in places])
    beside_hz = np.array([kind.frequency_hz for _, kind in places])
    deviations = lines.deviations.copy()
    for number, (condition, duration_s) in enumerate(zip(lines.conditions, durations_s, strict=True)):
        frequencies_hz = np.abs(np.array(lines.orders) * condition.speed_rpm / 60 + beside_hz)
        for column in fixed:
            near = np.abs(frequencies_hz - places[column][1].frequency_hz) < MAIN_LOBE / duration_s
            met = np.flatnonzero(near & moves)
            if met.size:
                usual = _usual_size(lines, column, number)[:, None]
                deviations[number][:, met] = np.hypot(deviations[number][:, met], usual)
    return replace(lines, deviations=deviations)


def with_own_lines(
    lines: OrderLines, healthy: Sequence[Recording], before: OrderLines | None, channels: Mapping[str, str]
) -> OrderLines:
    """Return the lines, those at fixed frequencies less certain by what the healthy machine shows at that order.

    Of the nearest in speed of those healthy recordings in which that order lies elsewhere.

    Parameters
    ----------
    lines : OrderLines
    healthy : sequence of Recording
        At steady speed; may be empty.
    before : OrderLines or None
        Their lines, if any: their conditions tell the speeds.
    channels : mapping of str to str
        As of `observe_orders`.
    """
    fixed, deviations = _fixed(lines), lines.deviations.copy()
    speeds_rpm = [one.speed_rpm for one in before.conditions] if before else []
    locked = [(order, kind) for order, kind in zip(lines.orders, lines.kinds, strict=True) if kind.phase]
    places: dict[int, list[tuple[int, int, float]]] = {}
    for number, condition in enumerate(lines.conditions if before else ()):
        for column in fixed:
            frequency_hz = lines.kinds[column].frequency_hz
            order = 60 * frequency_hz / condition.speed_rpm
            elsewhere = [i for i, one in enumerate(healthy) if _lies_apart(one, speeds_rpm[i], order, frequency_hz)]
            if elsewhere:
                nearest = min(elsewhere, key=lambda i: abs(speeds_rpm[i] - condition.speed_rpm))
                places.setdefault(nearest, []).append((number, column, order))
    for nearest, own in places.items():
        orders, kinds = [order for order, _ in locked], [kind for _, kind in locked]
        orders, kinds = [*orders, *(order for *_, order in own)], [*kinds, *[LineKind(phase=False)] * len(own)]
        (seen,) = observe_orders(healthy[nearest : nearest + 1], orders=orders, kinds=kinds, channels=channels)
        sizes = np.where(seen.seen, np.abs(seen.amplitudes), 0.0)[0, :, len(locked) :]
        for (number, column, _), usual in zip(own, sizes.T, strict=True):
            deviations[number, :, column] = np.hypot(deviations[number, :, column], usual)
    return replace(lines, deviations=deviations)


def with_made_lines(lines: OrderLines, made: np.ndarray, when_healthy: np.ndarray) -> OrderLines:
    """Return the lines, those at fixed frequencies less certain by what the machine makes there without any effect.

    One of its orders that passes, at which no healthy recording has checked it; what the machine makes there in all of
    these (the hum of a machine that is given with it) is none.

    Parameters
    ----------
    lines : OrderLines
    made : ndarray, complex
        What the machine makes, of the shape of the lines.
    when_healthy : ndarray (healthy conditions, probes, orders), complex
        What it makes in the healthy conditions.
    """
    deviations, fixed = lines.deviations.copy(), _fixed(lines)
    passing = np.maximum(np.abs(made) - np.abs(when_healthy).min(axis=0), 0.0)
    deviations[:, :, fixed] = np.hypot(deviations, passing)[:, :, fixed]
    return replace(lines, deviations=deviations)


def _lies_apart(recording: Recording, speed_rpm: float, order: float, frequency_hz: float) -> bool:
    """Return whether the bands of an order and of a frequency do not meet in a recording."""
    width_hz = max(LEAST_BINS * recording.rate_hz / recording.samples, WANDER * frequency_hz)
    return abs(order * speed_rpm / 60 - frequency_hz) > 2 * width_hz


def _fixed(lines: OrderLines) -> list[int]:
    """Return the numbers of the lines of the spectrum that stay at a frequency."""
    places = zip(lines.orders, lines.kinds, strict=True)
    return [i for i, (order, kind) in enumerate(places) if not (kind.phase or kind.envelope or order)]


def _usual_size(lines: OrderLines, column: int, number: int) -> np.ndarray:
    """Return the median size (probes,) of a line in all conditions but one."""
    others = [i for i in range(len(lines.conditions)) if i != number]
    sizes, deviations = np.abs(lines.amplitudes[others, :, column]), lines.deviations[others, :, column]
    seen = np.isfinite(deviations)
    clear = np.where(seen & (sizes > CLEAR * np.where(seen, deviations, 0.0)), sizes, 0.0)
    return np.array([np.median(clear[own, i]) if (own := seen[:, i]).any() else 0.0 for i in range(seen.shape[1])])
