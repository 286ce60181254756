"""Channels that see the machine by another way than the healthy records did: what lies between their lines has fallen.

Most of what fails adds to a spectrum, or moves lines. Where what lies between the lines is weaker by 6 dB and more all
over an octave, at every speed, at one channel and not at the others, and not all over its band (the noise of a recorder
that was set anew), the way to the sensor is another one: it, or what it sits on, was mounted anew. Its lines there say
nothing of a fault.

The figures were chosen on the Analog Devices bench, which was taken apart between its classes: along the shaft 80 to
200 Hz fell by 7 to 22 dB whatever the fault, across it by less than 7.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...datasets.recording import Recording
from .line_sizes import HIGHEST_SHARE, line_power
from .lines import OrderLines

#: Bands in an octave, and neighbouring ones that have to fall: an octave, as a resonance that moved is narrower.
IN_AN_OCTAVE = 3
#: Lowest frequency, and lines of the spectrum that a band has to hold for its median to be known to 2 dB.
LOWEST_HZ, LEAST_LINES = 10.0, 9
#: By how much each of these bands falls in every record, and all together in the mean.
FALLS_DB, MEAN_FALL_DB = 6.0, 10.0
#: An octave of the same channel that falls by less than this in every record: not all of its band fell.
KEPT_DB = 3.0
#: The other channels fall by less than this share of it there.
OF_OTHERS = 0.5
#: Healthy records count within this factor of the speed.
ALIKE = 1.1


@dataclass(frozen=True)
class ChangedTransfer:
    """A channel and what lies between its lines now, over what the healthy records held.

    Attributes
    ----------
    channel : str
    fell : tuple of (float, float, float)
        Where it fell most: from, to (Hz) and by how much in the mean (dB, negative).
    bands_hz : tuple of (float, float)
        All bands that changed, with a neighbour, by `FALLS_DB` or more in every record, up or down.
    most_risen_db : float
        Largest mean rise of these bands; 0 where none rose.
    """

    channel: str
    fell: tuple[float, float, float]
    bands_hz: tuple[tuple[float, float], ...]
    most_risen_db: float


def changed_transfers(
    recordings: Sequence[Recording],
    speeds_rpm: Sequence[float],
    healthy: Sequence[Recording],
    healthy_rpm: Sequence[float],
    names: Sequence[str],
) -> tuple[ChangedTransfer, ...]:
    """Return the channels whose way to the machine has changed; none without healthy records near in speed.

    ``names`` are those of the channels that are looked at; of a single one nobody knows what the others hold.
    """
    pairs = _pairs(speeds_rpm, healthy_rpm)
    if not pairs or len(names) < 2:
        return ()
    rate_hz = min(one.rate_hz for one in (*recordings, *healthy))
    edges = _edges(HIGHEST_SHARE * rate_hz)
    now = {i: _levels_db(recordings[i], names, edges) for i, _ in pairs}
    before = {j: _levels_db(healthy[j], names, edges) for _, j in pairs}
    # Records, channels, bands; of a band that some record is too short for nothing is known.
    change = np.array([now[i] - before[j] for i, j in pairs])
    found = (_changed(change, names, channel, edges) for channel in range(len(names)))
    return tuple(one for one in found if one)


def without_changed(lines: OrderLines, changed: Sequence[ChangedTransfer]) -> OrderLines:
    """Return the lines, those left out that lie where their channel's transfer has changed; envelopes stay."""
    deviations = lines.deviations.copy()
    for one in changed:
        if one.channel not in lines.probes:
            continue
        probe = lines.probes.index(one.channel)
        for c, condition in enumerate(lines.conditions):
            for k, (order, kind) in enumerate(zip(lines.orders, lines.kinds, strict=True)):
                at_hz = abs(kind.order_at(order, condition.speed_rpm)) * condition.speed_rpm / 60
                if not kind.envelope and any(low <= at_hz < high for low, high in one.bands_hz):
                    deviations[c, probe, k] = np.inf
    return replace(lines, deviations=deviations)


def changed_words(changed: Sequence[ChangedTransfer]) -> tuple[str, ...]:
    """Return a remark on each channel whose transfer has changed."""
    return tuple(
        f"{one.channel}: between its lines the spectrum fell by {-one.fell[2]:.0f} dB at {one.fell[0]:.0f} to "
        f"{one.fell[1]:.0f} Hz since the healthy records{_risen(one)}, at every speed, and not so at "
        "the other channels. The sensor, or what it sits on, was mounted anew, or something else that shook there has "
        "gone: its lines there do not count. Record the healthy machine again as it is mounted now."
        for one in changed
    )


def _risen(one: ChangedTransfer) -> str:
    return f", and rose elsewhere by up to {one.most_risen_db:.0f} dB" if one.most_risen_db > 0 else ""


def _pairs(speeds_rpm: Sequence[float], healthy_rpm: Sequence[float]) -> list[tuple[int, int]]:
    """Return each record with the healthy one that is nearest in speed, where that is near."""
    found = []
    for i, speed in enumerate(speeds_rpm):
        away = [abs(math.log(own / speed)) for own in healthy_rpm]
        if away and min(away) < math.log(ALIKE):
            found.append((i, int(np.argmin(away))))
    return found


def _edges(highest_hz: float) -> np.ndarray:
    count = max(math.floor(IN_AN_OCTAVE * math.log2(highest_hz / LOWEST_HZ)), 0)
    return LOWEST_HZ * 2 ** (np.arange(count + 1) / IN_AN_OCTAVE)


def _levels_db(recording: Recording, names: Sequence[str], edges: np.ndarray) -> np.ndarray:
    """Return the level between the lines, dB, shape (channels, bands); NaN where a band holds too few lines."""
    own = [channel.name for channel in recording.channels]
    signals = np.nan_to_num(recording.signals[[own.index(name) for name in names]])
    power = line_power(signals - signals.mean(axis=1, keepdims=True))
    seconds = recording.samples / recording.rate_hz
    levels = np.full((len(names), edges.size - 1), np.nan)
    places = np.ceil(edges * seconds).astype(int)
    for band, (first, last) in enumerate(itertools.pairwise(places.tolist())):
        if last - first >= LEAST_LINES:
            middle = np.median(power[:, first:last], axis=1) * seconds
            levels[:, band] = 10 * np.log10(np.where(middle > 0, middle, np.nan))
    return levels


def _changed(change: np.ndarray, names: Sequence[str], channel: int, edges: np.ndarray) -> ChangedTransfer | None:
    """Return how one channel has changed; ``change`` is in dB, (records, channels, bands)."""
    own, others = change[:, channel], np.delete(change, channel, axis=1)
    fallen, risen, kept = (np.asarray(np.all(one, axis=0)) for one in (own < -FALLS_DB, own > FALLS_DB, own > -KEPT_DB))
    if not _octaves(kept):
        return None
    falls = [
        first
        for first in _octaves(fallen)
        if (fall := own[:, first : first + IN_AN_OCTAVE].mean()) < -MEAN_FALL_DB
        and (others[:, :, first : first + IN_AN_OCTAVE].mean(axis=(0, 2)) > OF_OTHERS * fall).all()
    ]
    if not falls:
        return None
    deepest = min(falls, key=lambda first: own[:, first : first + IN_AN_OCTAVE].mean())
    octave = slice(deepest, deepest + IN_AN_OCTAVE)
    moved = np.flatnonzero(_with_neighbour(fallen) | _with_neighbour(risen))
    return ChangedTransfer(
        channel=names[channel],
        fell=(float(edges[deepest]), float(edges[deepest + IN_AN_OCTAVE]), float(own[:, octave].mean())),
        bands_hz=tuple((float(edges[band]), float(edges[band + 1])) for band in moved),
        most_risen_db=max((float(own[:, band].mean()) for band in moved), default=0.0),
    )


def _octaves(holds: np.ndarray) -> list[int]:
    """Return where an octave begins in all bands of which something holds."""
    return [i for i in range(holds.size - IN_AN_OCTAVE + 1) if holds[i : i + IN_AN_OCTAVE].all()]


def _with_neighbour(holds: np.ndarray) -> np.ndarray:
    """Return the bands of which something holds, as of one beside them: a single one of few lines may be chance."""
    beside = np.zeros_like(holds)
    beside[1:] |= holds[:-1]
    beside[:-1] |= holds[1:]
    return holds & beside
