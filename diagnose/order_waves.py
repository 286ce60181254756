"""What the first orders of a shaft do within a turn: their waveforms against its angle, for the report of ``analyse``.

Together they are the shape of the shaft's own motion without bearings, gears and noise: flattened where something
stops it, pointed where something strikes. A single order is a sine and shows nothing that its line does not say.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .observe import TRUSTED_SPEED, Observation, order_name
from .result import OrderPart

_ORDERS = (1.0, 2.0, 3.0)
_LEAST_SHARE = 0.1  # of the largest order: less does not change its sine visibly
_TURNS, _LEAST_TURNS, _TURNS_SHOWN = 60, 16, 3
_BANDWIDTH = 0.15  # over the speed, as `rotorwise orders` has it


@dataclass(frozen=True, eq=False)
class OrderWaves:
    """Waveforms against the shaft's angle.

    Attributes
    ----------
    turns : numpy.ndarray, shape (samples,)
        Angle from the first whole turn shown.
    signal : numpy.ndarray, shape (samples,)
    waves : tuple of (name, numpy.ndarray)
        Each order alone, and their sum first.
    """

    turns: np.ndarray
    signal: np.ndarray
    waves: tuple[tuple[str, np.ndarray], ...]


def order_part(now: Observation) -> OrderPart | None:
    """Return the part of a record from which the waveforms come; None where there is no trusted speed or one order."""
    speed = now.speed
    if speed is None or not now.turning or speed.confidence < TRUSTED_SPEED or speed.method == "hint only":
        return None
    best = max((_telling(now, channel), -channel) for channel in range(now.channel_count))
    (orders, _), channel = best[0], -best[1]
    turns = min(int(now.turns), _TURNS)
    if len(orders) < 2 or turns < _LEAST_TURNS:
        return None
    turn = now.recording.rate_hz / now.speed_hz
    # From a whole turn on, in the middle of the record.
    first = int(np.ceil(int((now.turns - turns) / 2) * turn))
    last = min(first + int(turns * turn), now.recording.samples)
    about = now.recording.channels[channel]
    return OrderPart(
        signal=now.recording.signals[channel, first:last].copy(),
        rate_hz=now.recording.rate_hz,
        turns=np.arange(first, last) / turn,
        orders=orders,
        unit=about.unit,
        channel=about.name,
        has_mark=now.order_tracked and now.recording.pulses_per_revolution == 1,
    )


def _telling(now: Observation, channel: int) -> tuple[tuple[float, ...], float]:
    """Return the orders of a channel that stand out of the noise and beside the largest, and their share of power.

    More orders compare as more.
    """
    lines = {order: now.line(order, channel=channel) for order in _ORDERS}
    largest = max(line.amplitude for line in lines.values())
    kept = tuple(
        order for order, line in lines.items() if now.is_significant(line) and line.amplitude >= _LEAST_SHARE * largest
    )
    power = float((now.recording.signals[channel] ** 2).mean())
    share = sum(lines[order].amplitude ** 2 for order in kept) / max(2 * power, 1e-300)
    return kept, share


def order_waves(part: OrderPart) -> OrderWaves:
    """Return three turns of the orders' waveforms from the middle of a part (Vold-Kalman filter, all at once)."""
    from .signal.vold_kalman import order_waveforms

    speed_hz = float(part.turns[-1] - part.turns[0]) * part.rate_hz / (part.turns.size - 1)
    found = order_waveforms(
        part.signal,
        rate_hz=part.rate_hz,
        phase_turns=part.turns,
        orders=part.orders,
        bandwidth_hz=_BANDWIDTH * speed_hz,
    )
    begin = np.floor(0.5 * (part.turns[0] + part.turns[-1] - _TURNS_SHOWN))
    shown = (part.turns >= begin) & (part.turns <= begin + _TURNS_SHOWN)
    waves = found.waveform[0][:, shown]
    names = [order_name(order) for order in part.orders]
    together = (" + ".join(names), waves.sum(axis=0))
    return OrderWaves(part.turns[shown] - begin, part.signal[shown], (together, *zip(names, waves, strict=True)))
