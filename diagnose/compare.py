"""What changed between a baseline recording and this one."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from .observe import Observation

_SAME_SPEED = 0.05


def comparable(now: Observation, baseline: Observation | None) -> bool:
    """Return whether both turned at the same speed (within 5 %), with the same channels in the same quantities.

    A speed that the vibration does not confirm puts the lines in the wrong place: then nothing is compared.
    """
    if baseline is None or now.speed is None or baseline.speed is None:
        return False
    if "hint only" in (now.speed.method, baseline.speed.method):
        return False
    mine, theirs = ([(c.name, c.quantity) for c in one.recording.channels] for one in (now, baseline))
    return mine == theirs and abs(now.speed.speed_hz / baseline.speed.speed_hz - 1.0) < _SAME_SPEED


def order_change_db(now: Observation, baseline: Observation, order: float) -> np.ndarray:
    """Return the change of an order line in dB, shape (channels,).

    Amplitudes below their noise floor count as the floor, and a line that is not significant has not risen, so that
    noise never looks like a change.
    """
    changes = []
    for channel in range(now.channel_count):
        after, before = now.line(order, channel=channel), baseline.line(order, channel=channel)
        high = max(after.amplitude, after.noise_floor, 1e-300)
        low = max(before.amplitude, before.noise_floor, 1e-300)
        change = 20 * np.log10(high / low)
        changes.append(change if now.is_significant(after) else min(change, 0.0))
    return np.array(changes)


def risen_db(change_db: np.ndarray, scatter_db: float) -> tuple[float, np.ndarray]:
    """Return how much a line rose, in dB, and the channels that say so, shape (some,).

    A force that acts at one place may raise a line at some probes and lower it at others. So besides the median of all
    channels the mean of the k that rose most counts, for each k, less what choosing k of n brings where nothing rose:
    0.7 s sqrt(2 ln C(n, k) / k), somewhat above the expected mean of the k largest of n that scatter by s.

    Examples
    --------
    >>> rise, channels = risen_db(np.array([20.0, 19.0, -5.0, -6.0]), 4.0)
    >>> round(rise, 1), channels.tolist()
    (15.8, [0, 1])
    """
    count = change_db.size
    best, chosen = float(np.median(change_db)), np.arange(count)
    order = np.argsort(-change_db)
    for several in range(1, count):
        price = 0.7 * scatter_db * math.sqrt(2 * math.log(math.comb(count, several)) / several)
        rise = float(change_db[order[:several]].mean()) - price
        if rise > best:
            best, chosen = rise, np.sort(order[:several])
    return best, chosen


def floor_change_db(now: Observation, baseline: Observation) -> tuple[np.ndarray, np.ndarray]:
    """Return octave-band centres and the change of the noise floor in dB, shape (channels, bands).

    Floors are medians, so lines do not enter.
    """
    top = 0.45 * min(now.recording.rate_hz, baseline.recording.rate_hz)
    edges = [16.0]
    while edges[-1] * 2 <= top:
        edges.append(edges[-1] * 2)
    centres = np.array([np.sqrt(low * high) for low, high in pairwise(edges)])
    return centres, 10 * np.log10(_band_floor(now, edges) / _band_floor(baseline, edges))


def _band_floor(observation: Observation, edges: list[float]) -> np.ndarray:
    frequency = observation.spectrum.frequency_hz
    density = observation.spectrum.floor**2 / observation.spectrum.resolution_hz
    columns = []
    for low, high in pairwise(edges):
        inside = (frequency >= low) & (frequency < high)
        columns.append(density[:, inside].mean(axis=1) if inside.any() else np.ones(density.shape[0]))
    return np.maximum(np.array(columns).T, 1e-300)


def floor_rise_near(now: Observation, baseline: Observation, order: float) -> float:
    """Return how much more the noise beside an order rose than the noise elsewhere, in dB, median of the channels.

    A force raises a line; a resonance that moved to the line raises the noise beside it too.
    """
    speed = now.speed_hz
    centres, change = floor_change_db(now, baseline)
    if not centres.size:
        return 0.0
    near = [one.spectrum.frequency_hz for one in (now, baseline)]
    levels = [
        10
        * np.log10(
            np.maximum((one.spectrum.floor[:, (f > 0.6 * order * speed) & (f < 1.6 * order * speed)] ** 2), 1e-300)
        )
        for one, f in zip((now, baseline), near, strict=True)
    ]
    if not levels[0].size or not levels[1].size:
        return 0.0
    beside = levels[0].mean(axis=1) - levels[1].mean(axis=1)
    # Densities, so that records of different length compare.
    beside -= 10 * np.log10(now.spectrum.resolution_hz / baseline.spectrum.resolution_hz)
    return float(np.median(beside - np.median(change, axis=1)))


def path_changed(now: Observation, baseline: Observation) -> list[str]:
    """Return the channels whose transfer path changed: re-assembled machine or re-mounted sensor.

    A fault adds noise; it does not take it away. A floor that fell by 6 dB in one octave band while it rose by 6 dB in
    another on the same channel means that the way from the machine to the sensor is another one.
    """
    _, change = floor_change_db(now, baseline)
    names = [channel.name for channel in now.recording.channels]
    return [name for name, row in zip(names, change, strict=True) if row.size and row.min() < -6 and row.max() > 6]


def repeatability_db(now: Observation, baseline: Observation) -> float:
    """Return the standard deviation of a line's change that means nothing, in dB.

    4 dB between records of one assembly; 7 dB where the transfer path changed: order lines of healthy re-assembled rigs
    move by up to 9 dB without a pattern.
    """
    return 7.0 if path_changed(now, baseline) else 4.0


def odds_of_rise(change_db: float, *, repeatability: float, typical_db: float, spread_db: float) -> float:
    """Return the Bayes factor of "this line really rose" over "it only scattered".

    Gaussian in dB under both: N(typical, spread) against N(0, repeatability).
    """
    rose = np.exp(-0.5 * ((min(change_db, typical_db) - typical_db) / spread_db) ** 2) / spread_db
    scattered = np.exp(-0.5 * (max(change_db, 0.0) / repeatability) ** 2) / repeatability
    return float(rose / max(scattered, 1e-30))
