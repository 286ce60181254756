"""Lines of a spectrum, at orders of the shaft or anywhere else, that are new or rose since the baseline."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from .compare import repeatability_db
from .observe import Observation, order_name
from .result import Line

_FALSE_ALARM = 1e-3  # chance of a wrong line in a whole recording, once for noise and once for scatter
_LEAST_SHARE = 0.10  # of the energy of its channel that a line must carry to be told
_SHARE_OF_LEVEL = 0.25  # where the level rose: lines below that did not do it
_DOUBLED_DB = 6.0
_MOVES = 0.01  # a line beside the orders moves by this share with load and slip
_COMBINED = 3  # highest order of the shaft with which a line makes sums and differences


@dataclass(frozen=True)
class RisenLine:
    """A line that rose; its baseline amplitude is the highest near its place, noise included."""

    line: Line
    rise_db: float
    channel: int
    displacement: float

    @property
    def at_an_order(self) -> bool:
        """Whether it stands at a whole order of the shaft."""
        return self.line.expected_order is not None


def risen_lines(now: Observation, baseline: Observation, *, louder: Collection[str] = ()) -> list[RisenLine]:
    """Return the lines that rose clearly, the largest first, each on the channel where it is largest.

    A line counts that noise does not make, that carries a tenth of the energy of its channel, and that rose by more
    than scatter makes in any of the lines looked at; where the level of a channel rose too, one that carries a quarter
    of it and doubled. Sums and differences of a stronger line beside the orders and the shaft's orders are left out.

    Parameters
    ----------
    now, baseline : Observation
        Comparable ones.
    louder : names of channels
        Those whose level rose significantly.
    """
    peaks = [(channel, index) for channel in range(now.channel_count) for index in _peaks(now, channel)]
    if not peaks:
        return []
    scatter = repeatability_db(now, baseline)
    least_db = scatter * NormalDist().inv_cdf(1 - _FALSE_ALARM / len(peaks))
    found: list[RisenLine] = []
    totals = {channel: _energy(now, channel) for channel in range(now.channel_count)}
    for channel, index in peaks:
        share = min(1.0, _weighted(now, channel, index) ** 2 / max(totals[channel], 1e-300))
        if share < _LEAST_SHARE:
            continue
        one = _risen(now, baseline, channel, index)
        level = now.recording.channels[channel].name in louder and share >= _SHARE_OF_LEVEL
        if one.rise_db >= (min(least_db, _DOUBLED_DB) if level else least_db):
            found.append(one)
    return _distinct(now, sorted(found, key=lambda one: -one.displacement))


def _inside(now: Observation) -> np.ndarray:
    frequency = now.spectrum.frequency_hz
    low = max(0.1 * now.speed_hz, 3 * now.spectrum.resolution_hz)
    inside = (frequency >= low) & (frequency <= max(1000.0, 10 * now.speed_hz))
    inside[-1] = False
    return inside


def _weight(now: Observation, channel: int, frequency_hz: np.ndarray | float) -> np.ndarray | float:
    """Return what makes lines comparable: displacement of shaft probes as it is, velocity of all else."""
    if now.recording.channels[channel].quantity == "displacement":
        return 1.0
    return now.velocity_factor(channel, frequency_hz)


def _weighted(now: Observation, channel: int, index: int) -> float:
    frequency = float(now.spectrum.frequency_hz[index])
    return float(now.spectrum.amplitude[channel, index] * _weight(now, channel, frequency))


def _energy(now: Observation, channel: int) -> float:
    inside = _inside(now)
    weighted = now.spectrum.amplitude[channel, inside] * _weight(now, channel, now.spectrum.frequency_hz[inside])
    return float((weighted**2).sum()) / 1.5  # a Hann line spreads over 1.5 bins of power


def _peaks(now: Observation, channel: int) -> np.ndarray:
    """Return the bins of local maxima that noise makes anywhere in the record in one of a thousand records."""
    inside = _inside(now)
    row = now.spectrum.amplitude[channel]
    least = np.log(max(int(inside.sum()), 1) * now.channel_count / _FALSE_ALARM)
    inside[1:-1] &= (row[1:-1] > row[:-2]) & (row[1:-1] >= row[2:])
    return np.flatnonzero(inside & (now.spectrum.power_ratio[channel] > least))


def _risen(now: Observation, baseline: Observation, channel: int, index: int) -> RisenLine:
    frequency = float(now.spectrum.frequency_hz[index])
    order = round(frequency / now.speed_hz)
    away = abs(frequency - order * now.speed_hz)
    at_order = order > 0 and away <= 1.5 * now.spectrum.resolution_hz + now.speed_doubt_hz(order)
    name = order_name(float(order)) if at_order else "line beside the orders"
    line = now.line_at(frequency, channel=channel, name=name, tolerance_hz=0.5 * now.spectrum.resolution_hz)
    # Lines of the shaft move with its speed, others need not.
    places = sorted((frequency, frequency * baseline.speed_hz / now.speed_hz))
    margin = max(3 * baseline.spectrum.resolution_hz, _MOVES * frequency)
    there = (baseline.spectrum.frequency_hz >= places[0] - margin) & (
        baseline.spectrum.frequency_hz <= places[1] + margin
    )
    before = max(
        float(np.max(baseline.spectrum.amplitude[channel, there], initial=0.0)),
        float(np.max(baseline.spectrum.floor[channel, there], initial=1e-300)),
    )
    line = replace(line, baseline_amplitude=before, expected_order=float(order) if at_order else None)
    rise = 20 * float(np.log10(max(line.amplitude, 1e-300) / before))
    displacement = line.amplitude * float(now.velocity_factor(channel, frequency)) / frequency
    return RisenLine(line, rise, channel, displacement)


def _distinct(now: Observation, found: list[RisenLine]) -> list[RisenLine]:
    """Return one a place, without sums and differences of a stronger line and the shaft's orders."""
    kept: list[RisenLine] = []
    tolerance = 2 * now.spectrum.resolution_hz
    for one in found:
        frequency = one.line.frequency_hz
        stronger = [other.line.frequency_hz for other in kept if not other.at_an_order]
        taken = [other.line.frequency_hz for other in kept] + [
            abs(order * now.speed_hz + sign * other)
            for other in stronger
            for order in range(1, _COMBINED + 1)
            for sign in (-1, 1)
            if not one.at_an_order
        ]
        if all(abs(frequency - other) > tolerance for other in taken):
            kept.append(one)
    return kept
