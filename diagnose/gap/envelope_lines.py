"""What stands out of the envelopes of recordings, and did not of the healthy machine's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...datasets.recording import Recording
from .line_sizes import MEAN_OVER_MEDIAN, high_envelope, line_power

#: Half width of a line as a share of its order, and in lines of the spectrum.
NARROW, NARROW_BINS = 0.002, 1.5
#: Width, in orders, of what the floor is the median of; highest order that is looked at.
FLOOR_ORDERS, HIGHEST_ORDER = 2.0, 25.0
#: Power over the floor from which on something stands out, far above what noise does anywhere; so many lines at most.
STANDS_OUT, MOST_LINES = 20.0, 500
#: What had the power of a line over this within this share of its order, in the healthy records so many nearest in
#: speed, is no news: slips drift, and what beats with such a line stands beside it.
GROWN, BESIDE, NEAREST = 4.0, 0.01, 2
#: A healthy record tells what is news where its speed is off by this share at most: what beats changes with speed.
SAME_SPEED = 0.1
#: Whole orders are the shaft's: so near to one nothing counts, in lines of the spectrum.
SHAFT_BINS = 2.5


@dataclass(frozen=True, eq=False)
class Spectrum:
    """What stands out of an envelope's spectrum: orders, power over the floor, and the width of a line in orders.

    ``news`` says that a healthy record of nearly the same speed does not hold it.
    """

    orders: np.ndarray
    power: np.ndarray
    resolution: float
    news: bool = False

    def taken(self, lines: np.ndarray) -> Spectrum:
        """Return it with some of its lines, bool, at no order (NaN): their power still counts as standing out."""
        return replace(self, orders=np.where(lines, np.nan, self.orders))


def envelopes_of(
    recordings: Sequence[Recording],
    speeds_rpm: Sequence[float],
    healthy: Sequence[Recording] = (),
    healthy_rpm: Sequence[float] = (),
) -> tuple[Spectrum, ...]:
    """Return what stands out of the envelopes of recordings, those without an acceleration left out.

    What stands out of the healthy ones that are nearest in speed as well, at the same order or frequency, is left out:
    balls that pass a sound race, a mesh, a belt, the supply.
    """
    with_speeds = zip(recordings, speeds_rpm, strict=True)
    faulty = [one for one in (_envelope(*of) for of in with_speeds) if one is not None]
    # One with samples missing says nothing of what is news.
    sound = map(_envelope, healthy, healthy_rpm)
    before = [one for one in sound if one is not None and np.isfinite(one.power).all()]
    return tuple(_standing_out(one, sorted(before, key=one.away)[:NEAREST]) for one in faulty)


@dataclass(frozen=True, eq=False)
class _Envelope:
    """Power of the lines of the envelopes of the named channels up to an order, the width of a line, and the speed."""

    channels: tuple[str, ...]
    power: np.ndarray
    resolution: float
    speed_rpm: float

    def away(self, other: _Envelope) -> float:
        """Return how far another's speed is away, as a logarithm."""
        return abs(math.log(other.speed_rpm / self.speed_rpm))

    def about(self, orders: np.ndarray, half_widths: np.ndarray) -> np.ndarray:
        """Return the power within half widths of orders, shape (channels, orders)."""
        summed = np.concatenate([np.zeros((len(self.power), 1)), np.cumsum(self.power, axis=1)], axis=1)
        ends = np.rint(np.stack([orders - half_widths, orders + half_widths]) / self.resolution).astype(int)
        low, high = np.clip(ends + np.array([[0], [1]]), 0, self.power.shape[1])
        return summed[:, high] - summed[:, low]


def _envelope(recording: Recording, speed_rpm: float) -> _Envelope | None:
    """Return the envelopes of a recording; None without any acceleration, or where they hold too few orders."""
    rows = [i for i, one in enumerate(recording.channels) if one.quantity == "acceleration"]
    if not rows:
        return None
    speed_hz = speed_rpm / 60
    magnitude = high_envelope(recording.signals[rows], rate_hz=recording.rate_hz, speed_hz=speed_hz)
    power = line_power(magnitude - magnitude.mean(axis=1, keepdims=True))
    resolution = recording.rate_hz / recording.samples / speed_hz
    kept = min(power.shape[1], int(HIGHEST_ORDER / resolution))
    if kept * resolution < FLOOR_ORDERS:
        return None
    names = tuple(recording.channels[i].name for i in rows)
    return _Envelope(names, power[:, :kept], resolution, speed_rpm)


def _standing_out(envelope: _Envelope, healthy: Sequence[_Envelope]) -> Spectrum:
    """Return what stands out of the envelopes of all channels together, and did not in healthy ones."""
    pieces = int(envelope.power.shape[1] * envelope.resolution / FLOOR_ORDERS)
    parts = np.array_split(envelope.power, pieces, axis=1)
    medians = [np.broadcast_to(np.median(one, axis=1, keepdims=True), one.shape) for one in parts]
    floors = np.maximum(MEAN_OVER_MEDIAN * np.concatenate(medians, axis=1), 1e-300)
    ratio = (envelope.power / floors).mean(axis=0)
    orders = np.arange(ratio.size) * envelope.resolution
    chosen = np.flatnonzero(
        (ratio > STANDS_OUT) & (np.abs(orders - np.rint(orders)) > SHAFT_BINS * envelope.resolution)
    )
    for before in healthy:
        chosen = chosen[_has_grown(envelope, before, orders[chosen], floors[:, chosen])]
    chosen = np.sort(chosen[np.argsort(ratio[chosen])[-MOST_LINES:]])
    news = any(envelope.away(one) <= math.log1p(SAME_SPEED) for one in healthy)
    return Spectrum(orders[chosen], ratio[chosen], envelope.resolution, news)


def _has_grown(envelope: _Envelope, before: _Envelope, orders: np.ndarray, floors: np.ndarray) -> np.ndarray:
    """Return at which orders the envelopes hold clearly more than before, in the channels of both."""
    both = [name for name in envelope.channels if name in before.channels]
    if not both:
        return np.ones(orders.size, dtype=bool)
    bins = NARROW_BINS * max(envelope.resolution, before.resolution)
    own, other = [envelope.channels.index(name) for name in both], [before.channels.index(name) for name in both]
    now = envelope.about(orders, np.maximum(NARROW * orders, bins))[own]
    # At the same order, or the same frequency: so is a line of the supply, and a speed without tacho may be 1 % wrong.
    places = (orders, orders * envelope.speed_rpm / before.speed_rpm)
    then = np.maximum(*(before.about(place, np.maximum(BESIDE * place, bins))[other] for place in places))
    return (now / floors[own]).mean(axis=0) > GROWN * (then / floors[own]).mean(axis=0)
