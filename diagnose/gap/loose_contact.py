"""Spikes of a loose contact: a sample or a few, far out of one channel alone, that no machine makes.

A shock of the machine rings on, and every sensor hears it. What jumps for a few samples at one channel only, by far
more than that moves, and a few times in a record is a plug or a cable. It raises the whole spectrum of the record, and
is taken out: straight lines take its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...datasets.recording import Recording
from .phase_wander import OTHERS
from .words import joined_words

#: Records of a channel whose speeds a remark names.
MOST_NAMED = 4
#: Samples of the running median, and what a spike stands out of it at least, in standard deviations of what others do.
MEDIAN_OF, STANDS_OUT = 9, 12.0
#: And in those of the whole channel.
LARGE = 4.0
#: A share of the samples, percent, that spikes of a record never reach: it tells the deviation of the others.
COMMON_PERCENT = 99.0
#: Longest spike, samples; and what an anti-alias filter makes of its ends.
LONGEST, ENDS = 6, 3
#: So many samples around it the channel is quiet: below this share of the spike.
AROUND, QUIET = 40, 0.25
#: Spikes a record, at most: more are no accident.
MOST = 20
#: Samples from the beginning in which a recorder's filter may still settle: no contact is loose for that.
SETTLES = 10
#: Another channel that moves by so many of its own standard deviations at the time heard it, too.
HEARD = 5.0


@dataclass(frozen=True)
class Spikes:
    """A channel of a record, at its speed, and how many spikes were taken out."""

    channel: str
    speed_rpm: float | None
    count: int


def without_spikes(recordings: Sequence[Recording]) -> tuple[tuple[Recording, ...], tuple[Spikes, ...]]:
    """Return the recordings without the spikes of loose contacts, and what was taken out."""
    found, said = [], []
    for one in recordings:
        signals, rows = None, [i for i, channel in enumerate(one.channels) if channel.quantity not in OTHERS]
        jumps = _jumps(one.signals[rows]) if len(rows) > 1 else np.zeros((0, 0))
        for number, row in enumerate(rows[: len(jumps)]):
            spikes = _spikes(jumps, number)
            if not 0 < len(spikes) <= MOST:
                continue
            signals = one.signals.copy() if signals is None else signals
            signals[row] = _bridged(signals[row], spikes)
            count = sum(first >= SETTLES for first, _ in spikes)
            if count:
                said.append(Spikes(one.channels[row].name, one.condition.speed_rpm, count))
        found.append(one if signals is None else replace(one, signals=signals))
    return tuple(found), tuple(said)


def spikes_words(found: Sequence[Spikes]) -> tuple[str, ...]:
    """Return a remark on the spikes that were taken out; nothing without any."""
    if not found:
        return ()
    where = [
        _counted(name, [one for one in found if one.channel == name])
        for name in dict.fromkeys(one.channel for one in found)
    ]
    return (
        f"Spikes of a few samples that no other channel shows were taken out: {joined_words(where)}. Look for a loose "
        "plug or cable.",
    )


def _counted(name: str, found: Sequence[Spikes]) -> str:
    """Return how many a channel had, and where: "2 of path_1 at 1500 rpm", "12 of path_1 in 9 records"."""
    speeds = [f"{one.speed_rpm:.0f}" for one in found if one.speed_rpm]
    whole = f"{sum(one.count for one in found)} of {name}"
    if len(found) > MOST_NAMED:
        return f"{whole} in {len(found)} records"
    return f"{whole} at {joined_words(speeds)} rpm" if len(speeds) == len(found) else whole


def _jumps(signals: np.ndarray) -> np.ndarray:
    """Return by how many standard deviations each sample lies beside its surroundings, shape (channels, samples)."""
    from scipy.ndimage import median_filter

    finite = np.nan_to_num(signals)
    beside = np.abs(finite - median_filter(finite, size=(1, MEDIAN_OF), mode="nearest"))
    # A normal variable exceeds 2.58 deviations in 1 % of the samples; so does what rings or moves in coarse steps.
    usual = np.percentile(beside, COMMON_PERCENT, axis=1, keepdims=True) / 2.576
    least = LARGE * finite.std(axis=1, keepdims=True) / STANDS_OUT
    return beside / np.maximum(np.maximum(usual, least), 1e-300)


def _spikes(jumps: np.ndarray, row: int) -> list[tuple[int, int]]:
    """Return the first and last sample of each spike of one channel; none where something moves it more often."""
    out = np.flatnonzero(jumps[row] > STANDS_OUT)
    if not out.size:
        return []
    events = np.split(out, np.flatnonzero(np.diff(out) > LONGEST) + 1)
    found = [(int(event[0]), int(event[-1])) for event in events]
    if len(found) > MOST or any(last - first >= LONGEST for first, last in found):
        return []
    return [spike for spike in found if _is_alone(jumps, row, *spike)]


def _is_alone(jumps: np.ndarray, row: int, first: int, last: int) -> bool:
    """Return whether the channel is quiet before and after a spike, and every other one during it."""
    peak = jumps[row, first : last + 1].max()
    before, after = max(first - ENDS, 0), last + 1 + ENDS
    around = np.r_[jumps[row, max(before - AROUND, 0) : before], jumps[row, after : after + AROUND]]
    others = np.delete(jumps[:, before:after], row, axis=0)
    return bool(around.max(initial=0.0) < QUIET * peak and others.max(initial=0.0) < HEARD)


def _bridged(signal: np.ndarray, spikes: Sequence[tuple[int, int]]) -> np.ndarray:
    """Return a signal with straight lines in the place of spikes."""
    kept = np.ones(signal.size, dtype=bool)
    for first, last in spikes:
        kept[max(first - ENDS, 0) : last + 1 + ENDS] = False
    index = np.arange(signal.size)
    return np.where(kept, signal, np.interp(index, index[kept], signal[kept]))
