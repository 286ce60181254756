"""From a recording to complex order amplitudes with their noise: a Hann window over the shaft's angle.

Without a tacho the shaft's angle is that of a constant speed, refined until the phases of the record's own orders stand
still; where it is 0 is then unknown, and phases are those relative to one probe.

Their noise is that of `line_noise`.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...datasets.recording import Recording
from ..observe import observe as observe_recording
from ..result import SpeedEstimate
from ..signal.order_tracking import constant_speed_phase, phase_from_pulses
from ..signal.speed import speed_from_tacho
from .line_noise import Scatter, UnusableRecordingError, deviations_of, scatter_of, weighted_mean
from .line_sizes import line_sizes
from .lines import Condition, LineKind, OrderLines, joined, strongest_probes, turned_to_reference
from .pulse_edges import are_steps, between_edges

#: Lines above this share of the sampling rate are bent by the anti-alias filter.
HIGHEST_SHARE = 0.4
#: A line below this share of its probe's largest line is not trusted.
DYNAMIC_RANGE = 3e-4


#: Orders, pieces and rounds by which a constant speed is refined.
STILL_ORDERS, STILL_PIECES, STILL_ROUNDS = np.array([1.0, 2.0, 3.0]), 8, 3


#: A steady shaft's turns are a polynomial of time of this degree, fitted to at least so many pulses, when every pulse
#: lies within so many samples of it.
SMOOTH_DEGREE, SMOOTH_PULSES, EDGE_SAMPLES = 3, 12, 1.0
#: An edge between two samples is known better than that: what goes beyond this (standard deviation, samples) and
#: follows a course is the shaft's own wander. By chance von Neumann's ratio is 2; the beat with the sampling stays
#: below 0.07 samples.
WANDER_SAMPLES, FOLLOWS = 0.15, 0.5


def observe_orders(
    *states: Sequence[Recording],
    orders: Sequence[float],
    channels: Mapping[str, str],
    kinds: Sequence[LineKind] = (),
) -> tuple[OrderLines, ...]:
    """Return the lines of a machine's recordings at steady speed, for each of its states; one condition a recording.

    Phases of recordings without tacho are as found; `with_reference` makes them comparable.

    Parameters
    ----------
    *states : sequence of Recording
        The machine as it is, say, and when it was healthy.
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
    if not all(states):
        raise UnusableRecordingError("No recording; allowed: one or more. Give recordings of the machine.")
    wanted = tuple(kinds) or (LineKind(),) * len(orders)
    locked = np.array([order for order, kind in zip(orders, wanted, strict=True) if kind.phase])
    read = [[_read(recording, list(channels), locked) for recording in state] for state in states]
    every = [one.scatter for state in read for one in state]
    result = []
    for state in read:
        deviations = deviations_of([one.scatter for one in state], every)
        found = [
            _with_sizes(one, own, tuple(orders), wanted, tuple(channels.values()))
            for one, own in zip(state, deviations, strict=True)
        ]
        result.append(functools.reduce(joined, found))
    return tuple(result)


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


@dataclass(frozen=True, eq=False)
class _Read:
    """Channels (rows) of a recording, the shaft's turns, and the lines that keep their phase."""

    recording: Recording
    rows: list[int]
    turns: np.ndarray
    #: Standard deviation of the angle of the whole record.
    doubt_turns: float
    locked: np.ndarray
    scatter: Scatter


def _read(recording: Recording, channels: list[str], locked: np.ndarray) -> _Read:
    names = [channel.name for channel in recording.channels]
    missing = [name for name in channels if name not in names]
    if missing:
        raise UnusableRecordingError(
            f"{_origin(recording)} has no channel {missing[0]!r}; it has {', '.join(names)}. Name its channels as in "
            "the other recordings."
        )
    rows = [names.index(name) for name in channels]
    signals = recording.signals[rows]
    turns, doubt = _angle_of(recording, signals)
    return _Read(recording, rows, turns, doubt, locked, scatter_of(signals, turns=turns, orders=locked))


def _with_sizes(
    read: _Read,
    deviations: np.ndarray,
    orders: tuple[float, ...],
    kinds: tuple[LineKind, ...],
    probes: tuple[str, ...],
) -> OrderLines:
    """Return the lines with phase, of these deviations, and the sizes of those without."""
    recording, turns, locked = read.recording, read.turns, read.locked
    with_phase = np.array([kind.phase for kind in kinds])
    speed_hz = float((turns[-1] - turns[0]) / (recording.samples - 1) * recording.rate_hz)
    sizes = line_sizes(
        recording.signals[read.rows],
        rate_hz=recording.rate_hz,
        turns=turns,
        locked=(locked, read.scatter.amplitudes),
        orders=np.array(orders)[~with_phase].tolist(),
        kinds=[kind for kind in kinds if not kind.phase],
        accelerations=[recording.channels[row].quantity == "acceleration" for row in read.rows],
    )
    too_high = locked * speed_hz > HIGHEST_SHARE * recording.rate_hz
    amplitudes = np.zeros((len(probes), len(orders)), dtype=complex)
    whole = np.zeros((len(probes), len(orders)))
    amplitudes[:, with_phase], amplitudes[:, ~with_phase] = read.scatter.amplitudes, sizes[0]
    turned = 2 * np.pi * read.doubt_turns * locked * np.abs(read.scatter.amplitudes)
    whole[:, with_phase] = np.where(too_high, np.inf, np.hypot(deviations, turned))
    whole[:, ~with_phase] = sizes[1]
    condition = Condition(60 * speed_hz, recording.condition.load, has_tacho(recording))
    return OrderLines((condition,), probes, orders, amplitudes[None], whole[None], kinds)


def turns_of(recording: Recording, signals: np.ndarray) -> np.ndarray:
    """Return the shaft's angle in turns at every sample: from the tacho, else at the speed that keeps phases still.

    Parameters
    ----------
    recording : Recording
    signals : ndarray (channels, samples)
        Channels whose phases are to stand still.

    Raises
    ------
    UnusableRecordingError
        As `shaft_turns`.
    """
    return _angle_of(recording, signals)[0]


def _angle_of(recording: Recording, signals: np.ndarray) -> tuple[np.ndarray, float]:
    found = _turns_by_tacho(recording)
    if found is not None:
        return found
    speed = _speed_of_lines(recording)
    turns = constant_speed_phase(samples=recording.samples, rate_hz=recording.rate_hz, speed_hz=speed.speed_hz)
    slack = max(speed.high_hz / speed.speed_hz - 1, 1 - speed.low_hz / speed.speed_hz)
    return with_still_phases(signals, turns, slack=slack), 0.0


def with_still_phases(signals: np.ndarray, turns: np.ndarray, *, slack: float) -> np.ndarray:
    """Return the shaft's turns scaled so that the phases of the record's low orders stand still from end to end.

    Parameters
    ----------
    signals : ndarray (channels, samples)
    turns : ndarray (samples,)
        At a constant speed that is nearly right: its error over the record must stay well below a quarter of a turn
        over the number of pieces, `STILL_PIECES`.
    slack : float
        Largest relative error of that speed. A line that stands still only beyond it is none of the shaft's: an outer
        race, at order 3.05, may be far stronger than 3X.
    """
    centred = signals - signals.mean(axis=1, keepdims=True)
    given = turns[-1] - turns[0]
    parts = np.array_split(np.arange(turns.size), STILL_PIECES)
    for _ in range(STILL_ROUNDS):
        carriers = np.exp(-2j * np.pi * np.outer(STILL_ORDERS, turns))
        pieces = np.stack([weighted_mean(centred[:, part], turns[part], carriers[:, part]) for part in parts])
        steps = pieces[1:] * pieces[:-1].conj()
        scale = np.median(np.abs(centred), axis=1)[:, None] ** 2 + 1e-300
        # Every order turns by its number times the shaft's error: the fundamental's own phase, weighted by clearness.
        turn = np.angle(steps.sum(axis=0) / scale)
        now = turns[-1] - turns[0]
        error = turn / STILL_ORDERS / (2 * np.pi) * STILL_PIECES / now
        own = np.abs(now / given * (1 + error) - 1) <= slack
        weight = own * np.abs(steps.sum(axis=0) / scale) * STILL_ORDERS**2
        turns = turns * (1 + float((weight * error).sum() / (weight.sum() + 1e-300)))
    return turns


def shaft_turns(recording: Recording) -> np.ndarray:
    """Return the shaft's angle in turns at every sample: from the tacho, else constant at the speed that is found.

    Raises
    ------
    UnusableRecordingError
        When the recording has neither tacho pulses nor a speed that its lines show.
    """
    found = _turns_by_tacho(recording)
    if found is not None:
        return found[0]
    speed = _speed_of_lines(recording)
    return constant_speed_phase(samples=recording.samples, rate_hz=recording.rate_hz, speed_hz=speed.speed_hz)


def shaft_speed_rpm(recording: Recording) -> float:
    """Return the mean speed in rpm, as `shaft_turns` finds it."""
    turns = shaft_turns(recording)
    return 60 * recording.rate_hz * float(turns[-1] - turns[0]) / (recording.samples - 1)


def _turns_by_tacho(recording: Recording) -> tuple[np.ndarray, float] | None:
    """Return the shaft's turns at every sample, and how far all of them may be shifted, by the first tacho that pulses.

    None where there is none.
    """
    how = {"rate_hz": recording.rate_hz, "pulses_per_revolution": recording.pulses_per_revolution}
    for signal, channel in zip(recording.signals, recording.channels, strict=True):
        found = speed_from_tacho(signal, **how) if channel.quantity == "tacho" else None
        if not found:
            continue
        steps = are_steps(signal, found[1] * recording.rate_hz)
        smooth = smooth_turns(found[1], samples=recording.samples, steps=steps, **how)
        return (phase_from_pulses(found[1], samples=recording.samples, **how), 0.0) if smooth is None else smooth
    return None


def _speed_of_lines(recording: Recording) -> SpeedEstimate:
    speed = observe_recording(recording).speed
    if speed is None:
        raise UnusableRecordingError(
            f"{_origin(recording)}: no tacho and no comb of lines that shows the shaft's speed. Give --speed, or "
            "a recording of the turning machine."
        )
    return speed


def smooth_turns(
    times_s: np.ndarray, *, samples: int, rate_hz: float, pulses_per_revolution: float, steps: bool
) -> tuple[np.ndarray, float] | None:
    """Return the shaft's turns at every sample as a cubic of time, where that passes every pulse within a sample.

    A pulse's edge is known to a part of a sample. Followed from pulse to pulse, that error repeats with the beat
    between shaft and sampling, and makes lines beside the shaft's orders which are not there. None where the speed
    wanders more, or so that the pulses follow a course which their edges do not explain.

    With the standard deviation of the angle of the whole record, in turns: of edges that are ``steps`` see
    `pulse_edges`; of others 0.
    """
    turns = np.arange(times_s.size) / pulses_per_revolution
    law = np.polynomial.Polynomial.fit(times_s, turns, SMOOTH_DEGREE, domain=[0.0, samples / rate_hz])
    turns_per_sample = (turns[-1] - turns[0]) / (times_s[-1] - times_s[0]) / rate_hz
    away = (law(times_s) - turns) / turns_per_sample
    if times_s.size < SMOOTH_PULSES or np.abs(away).max() > EDGE_SAMPLES or (not steps and _wanders(away)):
        return None
    middle, doubt = between_edges(away) if steps else (0.0, 0.0)
    return law(np.arange(samples) / rate_hz) - turns_per_sample * middle, turns_per_sample * doubt


def _wanders(away_samples: np.ndarray) -> bool:
    """Return whether pulses leave a smooth course as a shaft does that hunts, not as edges that are read wrongly."""
    changes = float((np.diff(away_samples) ** 2).mean())
    return bool(away_samples.std() > WANDER_SAMPLES and changes < FOLLOWS * away_samples.var())


def has_tacho(recording: Recording) -> bool:
    """Whether the recording has a channel with one tacho pulse a turn, so that phases mean something."""
    return recording.pulses_per_revolution == 1 and any(c.quantity == "tacho" for c in recording.channels)


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
