"""From a recording to complex order amplitudes with their noise: a Hann window over the shaft's angle.

The noise of an amplitude comes from its scatter over segments of the record, after the record's own amplitude is taken
off, so that it holds both the noise floor and what the line itself does (wander of speed or load). The scatter of a
single line has few degrees of freedom; it is shrunk to the median of its probe.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...datasets.recording import Recording
from ...simulators.errors import InvalidValueError
from ..observe import observe as observe_recording
from ..signal.order_tracking import constant_speed_phase, phase_from_pulses
from ..signal.speed import speed_from_tacho
from .lines import Condition, OrderLines, joined

#: Segments for the noise, and the fewest turns in one: lines half an order apart are told apart in four.
SEGMENTS, LEAST_TURNS = 16, 4.0
FEWEST_SEGMENTS = 4
#: Noise power of a Hann-weighted mean over that of a plain mean.
HANN_NOISE = 1.5
#: The scatter of one line weighs as many degrees of freedom as it has; the probe's typical scatter weighs this many.
TYPICAL_WEIGHT = 10.0
#: Lines above this share of the sampling rate are bent by the anti-alias filter.
HIGHEST_SHARE = 0.4
#: A line below this share of its probe's largest line is not trusted.
DYNAMIC_RANGE = 3e-4


class UnusableRecordingError(InvalidValueError):
    """A recording from which no order amplitudes can be taken."""


def observe_orders(
    recordings: Sequence[Recording], *, orders: Sequence[float], channels: Mapping[str, str]
) -> OrderLines:
    """Return the order amplitudes of recordings at steady speed, one condition each.

    Parameters
    ----------
    recordings : sequence of Recording
    orders : sequence of float
    channels : mapping of str to str
        Name of the machine's probe by name of the recording's channel; other channels are not looked at.

    Raises
    ------
    UnusableRecordingError
        For a recording without speed, without one of the channels, or with too few turns.
    """
    found = [_observe_one(recording, tuple(orders), dict(channels)) for recording in recordings]
    if not found:
        raise UnusableRecordingError("No recording; allowed: one or more. Give recordings of the machine.")
    result = found[0]
    for further in found[1:]:
        result = joined(result, further)
    return result


def _observe_one(recording: Recording, orders: tuple[float, ...], channels: dict[str, str]) -> OrderLines:
    names = [channel.name for channel in recording.channels]
    missing = [name for name in channels if name not in names]
    if missing:
        raise UnusableRecordingError(
            f"{_origin(recording)} has no channel {missing[0]!r}; it has {', '.join(names)}. Name its channels as in "
            "the other recordings."
        )
    if not has_tacho(recording):
        raise UnusableRecordingError(
            f"{_origin(recording)} has no tacho channel with one pulse a turn, so that the phases of its lines say "
            "nothing; allowed: recordings with such a tacho. Name it with --tacho, or record again with one."
        )
    turns = shaft_turns(recording)
    signals = recording.signals[[names.index(name) for name in channels]]
    amplitudes, deviations = order_amplitudes_with_noise(signals, turns=turns, orders=np.array(orders))
    length = turns[-1] - turns[0]
    speed_hz = float(length / (recording.samples - 1) * recording.rate_hz)
    unseen = np.array(orders) * speed_hz > HIGHEST_SHARE * recording.rate_hz
    deviations[:, unseen] = np.inf
    condition = Condition(60 * speed_hz, recording.condition.load)
    return OrderLines((condition,), tuple(channels.values()), orders, amplitudes[None], deviations[None])


def shaft_turns(recording: Recording) -> np.ndarray:
    """Return the shaft's angle in turns at every sample: from the tacho, else constant at the speed that is found.

    Raises
    ------
    UnusableRecordingError
        When the recording has neither tacho pulses nor a speed that its lines show.
    """
    for index, channel in enumerate(recording.channels):
        found = channel.quantity == "tacho" and speed_from_tacho(
            recording.signals[index],
            rate_hz=recording.rate_hz,
            pulses_per_revolution=recording.pulses_per_revolution,
        )
        if found:
            return phase_from_pulses(
                found[1],
                samples=recording.samples,
                rate_hz=recording.rate_hz,
                pulses_per_revolution=recording.pulses_per_revolution,
            )
    speed = observe_recording(recording).speed
    if speed is None:
        raise UnusableRecordingError(
            f"{_origin(recording)}: no tacho and no comb of lines that shows the shaft's speed. Give --speed, or "
            "a recording of the turning machine."
        )
    return constant_speed_phase(samples=recording.samples, rate_hz=recording.rate_hz, speed_hz=speed.speed_hz)


def has_tacho(recording: Recording) -> bool:
    """Whether the recording has a channel with one tacho pulse a turn, so that phases mean something."""
    return recording.pulses_per_revolution == 1 and any(c.quantity == "tacho" for c in recording.channels)


def order_amplitudes_with_noise(
    signals: np.ndarray, *, turns: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return complex amplitudes and the standard deviation of their real (or imaginary) part, both (channels, orders).

    Parameters
    ----------
    signals : ndarray (channels, samples)
    turns : ndarray (samples,)
        Shaft angle in turns.
    orders : ndarray (orders,)
    """
    length = float(turns[-1] - turns[0])
    segments = min(SEGMENTS, math.floor(length / LEAST_TURNS))
    if segments < FEWEST_SEGMENTS:
        raise UnusableRecordingError(
            f"Record of {length:.1f} turns of the shaft; allowed: {FEWEST_SEGMENTS * LEAST_TURNS:g} or more. Record "
            "longer."
        )
    centred = signals - signals.mean(axis=1, keepdims=True)
    carriers = np.exp(-2j * np.pi * np.outer(orders, turns))
    whole = _weighted_mean(centred, turns, carriers)
    edges = np.searchsorted(turns, turns[0] + length * np.arange(1, segments) / segments)
    parts = [slice(a, b) for a, b in zip([0, *edges], [*edges, turns.size], strict=True)]
    scatter = np.stack([_weighted_mean(centred[:, part], turns[part], carriers[:, part]) - whole for part in parts])
    # Two real numbers a segment; the record's own amplitude is close to the segments' mean: one segment is lost.
    power = (np.abs(scatter) ** 2).sum(axis=0) / (2 * (segments - 1)) / segments
    own = 2.0 * (segments - 1)
    typical = np.median(power, axis=1, keepdims=True)
    shrunk = (own * power + TYPICAL_WEIGHT * np.minimum(typical, 10 * power + 1e-300)) / (own + TYPICAL_WEIGHT)
    return whole, np.sqrt(np.maximum(shrunk, 1e-300))


def weighted_amplitudes(signals: np.ndarray, *, turns: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """Return complex amplitudes by a Hann window over the shaft's angle, shape (channels, orders)."""
    centred = signals - signals.mean(axis=1, keepdims=True)
    return _weighted_mean(centred, turns, np.exp(-2j * np.pi * np.outer(orders, turns)))


def _weighted_mean(signals: np.ndarray, turns: np.ndarray, carriers: np.ndarray) -> np.ndarray:
    position = (turns - turns[0]) / (turns[-1] - turns[0])
    weight = (0.5 - 0.5 * np.cos(2 * np.pi * position)) * np.gradient(turns)
    return (signals * weight) @ carriers.T * (2.0 / weight.sum())


def with_floor(lines: OrderLines, relative: float) -> OrderLines:
    """Return the lines with a deviation of at least a share of their own amplitude, and of the probe's largest line.

    The first is how well a line repeats, the second (`DYNAMIC_RANGE`) what leaks into it from the largest one through
    errors of the tacho and of the sensor's linearity.
    """
    size = np.abs(lines.amplitudes)
    largest = size.max(axis=2, keepdims=True)
    floor = np.hypot(relative * size, DYNAMIC_RANGE * largest)
    return replace(lines, deviations=np.hypot(lines.deviations, floor))


def _origin(recording: Recording) -> str:
    return recording.provenance.path or "A recording"
