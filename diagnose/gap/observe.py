"""From a recording to complex order amplitudes with their noise: a Hann window over the shaft's angle.

Without a tacho the shaft's angle is that of a constant speed, refined until the phases of the record's own orders stand
still; where it is 0 is then unknown, and phases are those relative to one probe.

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
from .line_sizes import line_sizes
from .lines import Condition, LineKind, OrderLines, joined, strongest_probes, turned_to_reference

#: Segments for the noise, and the fewest turns in one: lines half an order apart are told apart in four.
SEGMENTS, LEAST_TURNS = 16, 4.0
FEWEST_SEGMENTS = 4
#: Noise power of a Hann-weighted mean over that of a plain mean.
HANN_NOISE = 1.5
#: Coefficients of 1, cos, cos 2, ... of windows: main lobes of 2 and 4 lines of the spectrum; the second one's side
#: lobes are 92 dB down (F. J. Harris, Proc. IEEE 66 (1978) 51-83).
HANN, BLACKMAN_HARRIS = (0.5, -0.5), (0.35875, -0.48829, 0.14128, -0.01168)
#: The scatter of one line weighs as many degrees of freedom as it has; the probe's typical scatter weighs this many.
TYPICAL_WEIGHT = 10.0
#: A line is clear from so many standard deviations on; fewer clear ones say nothing of how slowly lines change.
CLEAR, FEWEST_CLEAR = 3.0, 4
#: Deviation of the median of n exponential values over their mean, times the square root of n and 99 % of chance.
MEDIAN_SPREAD = 3.4
#: Lines above this share of the sampling rate are bent by the anti-alias filter.
HIGHEST_SHARE = 0.4
#: A line below this share of its probe's largest line is not trusted.
DYNAMIC_RANGE = 3e-4


#: Orders, pieces and rounds by which a constant speed is refined.
STILL_ORDERS, STILL_PIECES, STILL_ROUNDS = np.array([1.0, 2.0, 3.0]), 8, 3


#: A steady shaft's turns are a polynomial of time of this degree, fitted to at least so many pulses, when every pulse
#: lies within so many samples of it.
SMOOTH_DEGREE, SMOOTH_PULSES, EDGE_SAMPLES = 3, 12, 1.0


class UnusableRecordingError(InvalidValueError):
    """A recording from which no order amplitudes can be taken."""


def observe_orders(
    recordings: Sequence[Recording],
    *,
    orders: Sequence[float],
    channels: Mapping[str, str],
    kinds: Sequence[LineKind] = (),
) -> OrderLines:
    """Return the lines of recordings at steady speed, one condition each.

    Phases of recordings without tacho are as found; `with_reference` makes them comparable.

    Parameters
    ----------
    recordings : sequence of Recording
    orders : sequence of float
    channels : mapping of str to str
        Name of the machine's probe by name of the recording's channel; other channels are not looked at.
    kinds : sequence of LineKind, optional
        Of the orders; all with phase when not given.

    Raises
    ------
    UnusableRecordingError
        For a recording without speed, without one of the channels, or with too few turns.
    """
    wanted = tuple(kinds) or (LineKind(),) * len(orders)
    found = [_observe_one(recording, tuple(orders), wanted, dict(channels)) for recording in recordings]
    if not found:
        raise UnusableRecordingError("No recording; allowed: one or more. Give recordings of the machine.")
    result = found[0]
    for further in found[1:]:
        result = joined(result, further)
    return result


def with_reference(*lines: OrderLines) -> tuple[OrderLines, ...]:
    """Return lines with the same reference probe for each order: the one that shows it most clearly in all of them."""
    whole = lines[0]
    for further in lines[1:]:
        whole = joined(whole, further)
    reference = strongest_probes(whole.amplitudes, whole.deviations)
    return tuple(
        replace(one, amplitudes=turned_to_reference(one.amplitudes, one.conditions, reference), reference=reference)
        for one in lines
    )


def _observe_one(
    recording: Recording, orders: tuple[float, ...], kinds: tuple[LineKind, ...], channels: dict[str, str]
) -> OrderLines:
    names = [channel.name for channel in recording.channels]
    missing = [name for name in channels if name not in names]
    if missing:
        raise UnusableRecordingError(
            f"{_origin(recording)} has no channel {missing[0]!r}; it has {', '.join(names)}. Name its channels as in "
            "the other recordings."
        )
    turns = shaft_turns(recording)
    rows = [names.index(name) for name in channels]
    signals = recording.signals[rows]
    tied = has_tacho(recording)
    if not tied:
        turns = with_still_phases(signals, turns)
    with_phase = np.array([kind.phase for kind in kinds])
    locked = np.array(orders)[with_phase]
    found = order_amplitudes_with_noise(signals, turns=turns, orders=locked)
    speed_hz = float((turns[-1] - turns[0]) / (recording.samples - 1) * recording.rate_hz)
    found[1][:, locked * speed_hz > HIGHEST_SHARE * recording.rate_hz] = np.inf
    sizes = line_sizes(
        signals,
        rate_hz=recording.rate_hz,
        turns=turns,
        locked=(locked, found[0]),
        orders=np.array(orders)[~with_phase].tolist(),
        kinds=[kind for kind in kinds if not kind.phase],
        accelerations=[recording.channels[row].quantity == "acceleration" for row in rows],
    )
    amplitudes = np.zeros((len(rows), len(orders)), dtype=complex)
    deviations = np.zeros((len(rows), len(orders)))
    for values, own, other in ((amplitudes, found[0], sizes[0]), (deviations, found[1], sizes[1])):
        values[:, with_phase], values[:, ~with_phase] = own, other
    condition = Condition(60 * speed_hz, recording.condition.load, tied)
    return OrderLines((condition,), tuple(channels.values()), orders, amplitudes[None], deviations[None], kinds)


def with_still_phases(signals: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return the shaft's turns scaled so that the phases of the record's low orders stand still from end to end.

    Parameters
    ----------
    signals : ndarray (channels, samples)
    turns : ndarray (samples,)
        At a constant speed that is nearly right: its error over the record must stay well below a quarter of a turn
        over the number of pieces, `STILL_PIECES`.
    """
    centred = signals - signals.mean(axis=1, keepdims=True)
    parts = np.array_split(np.arange(turns.size), STILL_PIECES)
    for _ in range(STILL_ROUNDS):
        carriers = np.exp(-2j * np.pi * np.outer(STILL_ORDERS, turns))
        pieces = np.stack([_weighted_mean(centred[:, part], turns[part], carriers[:, part]) for part in parts])
        steps = pieces[1:] * pieces[:-1].conj()
        scale = np.median(np.abs(centred), axis=1)[:, None] ** 2 + 1e-300
        # Every order turns by its number times the shaft's error: the fundamental's own phase, weighted by clearness.
        turn = np.angle(steps.sum(axis=0) / scale)
        weight = np.abs(steps.sum(axis=0) / scale) * STILL_ORDERS**2
        error = float((weight * turn / STILL_ORDERS).sum() / (weight.sum() + 1e-300)) / (2 * np.pi)
        turns = turns * (1 + error * STILL_PIECES / (turns[-1] - turns[0]))
    return turns


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
            pulses = recording.pulses_per_revolution
            smooth = smooth_turns(
                found[1], samples=recording.samples, rate_hz=recording.rate_hz, pulses_per_revolution=pulses
            )
            if smooth is not None:
                return smooth
            return phase_from_pulses(
                found[1], samples=recording.samples, rate_hz=recording.rate_hz, pulses_per_revolution=pulses
            )
    speed = observe_recording(recording).speed
    if speed is None:
        raise UnusableRecordingError(
            f"{_origin(recording)}: no tacho and no comb of lines that shows the shaft's speed. Give --speed, or "
            "a recording of the turning machine."
        )
    return constant_speed_phase(samples=recording.samples, rate_hz=recording.rate_hz, speed_hz=speed.speed_hz)


def smooth_turns(
    times_s: np.ndarray, *, samples: int, rate_hz: float, pulses_per_revolution: float
) -> np.ndarray | None:
    """Return the shaft's turns at every sample as a cubic of time, where that passes every pulse within a sample.

    A pulse's edge is known to a part of a sample. Followed from pulse to pulse, that error repeats with the beat
    between shaft and sampling, and makes lines beside the shaft's orders which are not there. None where the speed
    wanders more.
    """
    turns = np.arange(times_s.size) / pulses_per_revolution
    end = samples / rate_hz
    law = np.polynomial.Polynomial.fit(times_s, turns, SMOOTH_DEGREE, domain=[0.0, end])
    speed_hz = (turns[-1] - turns[0]) / (times_s[-1] - times_s[0])
    away = np.abs(law(times_s) - turns) / speed_hz * rate_hz
    if times_s.size < SMOOTH_PULSES or away.max() > EDGE_SAMPLES:
        return None
    return law(np.arange(samples) / rate_hz)


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
    middle = np.searchsorted(turns, turns[0] + length / 2)
    halves = [_weighted_mean(centred[:, h], turns[h], carriers[:, h]) for h in (slice(middle), slice(middle, None))]
    clear = np.abs(whole) ** 2 > CLEAR**2 * shrunk
    slow = np.where(clear, _slowness((halves[1] - halves[0])[clear], shrunk[clear]), 1.0)
    return whole, np.sqrt(np.maximum(shrunk * slow, 1e-300))


def _slowness(change: np.ndarray, power: np.ndarray) -> float:
    """Return by how much the noise of clear lines exceeds what their scatter over segments says; 1 where it does not.

    Segments count as independent. A machine's lines also change slowly, from one half of the record to the other by
    more than that, and from one record to the next by at least as much.

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
    return _weighted_mean(centred, turns, np.exp(-2j * np.pi * np.outer(orders, turns)), window)


def _weighted_mean(
    signals: np.ndarray, turns: np.ndarray, carriers: np.ndarray, window: Sequence[float] = HANN
) -> np.ndarray:
    position = 2 * np.pi * (turns - turns[0]) / (turns[-1] - turns[0])
    weight = sum(own * np.cos(k * position) for k, own in enumerate(window)) * np.gradient(turns)
    return (signals * weight) @ carriers.T * (2.0 / weight.sum())


def with_floor(lines: OrderLines, relative: float) -> OrderLines:
    """Return the lines with a deviation of at least a share of their own amplitude, and of the probe's largest line.

    The first is how well a line repeats, the second (`DYNAMIC_RANGE`) what leaks into it from the largest one through
    errors of the tacho and of the sensor's linearity.
    """
    size = np.abs(lines.amplitudes)
    envelope = np.array([kind.envelope for kind in lines.kinds])
    largest = np.where(np.isfinite(lines.deviations) & ~envelope, size, 0.0).max(axis=2, keepdims=True)
    floor = np.hypot(relative * size, DYNAMIC_RANGE * largest * ~envelope)
    return replace(lines, deviations=np.hypot(lines.deviations, floor))


def _origin(recording: Recording) -> str:
    return recording.provenance.path or "A recording"
