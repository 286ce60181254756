"""Lines that move with the shaft and meet a line at a fixed frequency: its phase against the shaft is any there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .lines import OrderLines

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
    fixed = [i for i, (order, kind) in enumerate(places) if not (kind.phase or kind.envelope or order)]
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


def _usual_size(lines: OrderLines, column: int, number: int) -> np.ndarray:
    """Return the median size (probes,) of a line in all conditions but one."""
    others = [i for i in range(len(lines.conditions)) if i != number]
    sizes, deviations = np.abs(lines.amplitudes[others, :, column]), lines.deviations[others, :, column]
    seen = np.isfinite(deviations)
    clear = np.where(seen & (sizes > CLEAR * np.where(seen, deviations, 0.0)), sizes, 0.0)
    return np.array([np.median(clear[own, i]) if (own := seen[:, i]).any() else 0.0 for i in range(seen.shape[1])])
