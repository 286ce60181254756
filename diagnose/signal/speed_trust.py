"""Whether the comb that was followed is the shaft's: a second look, at all lines of the record.

A ridge says that something turns, not what. Once the angle along the ridge is known the record is resampled at equal
angles of it, and its lines become sharp, whatever the speed did. There the rivals compete openly: half and twice the
speed, a speed outside the range that was searched, and a slower shaft beside the comb of a bearing or of a gear, which
explains the strong comb just as well and the lines below it besides.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy import fft

from .envelope import envelope_from_transform
from .order_tracking import angular_resample
from .spectrum import Spectrum, fast_length, fast_length_within, spectrum_with_floor
from .speed_comb import (
    HARMONIC_SHOWS,
    best_of_clusters,
    candidate_speeds,
    comb_gains,
    lines_below,
    place_gains,
)
from .speed_peaks import Peaks, find_peaks

_TURNS_A_PIECE, _FEW_TURNS, _PIECES = 150, 20, 4
_LEAST_TURNS = 4  # in fewer nothing can be told apart
_PER_TURN = 40  # samples: sixteen orders stay
_ORDERS = np.arange(1.0, HARMONIC_SHOWS.size + 1)
_SLOWEST_HZ, _FASTEST = 3.0, 8.0  # rivals; the fastest as order of the speed followed
_APART = 0.01  # of groups of rivals
_NOT_ONE = 0.03  # nearer, the speed is right
_SKIRT_WIDTH, _SKIRT, _WEAK = 0.15, 0.05, 0.005  # in orders, and of the power of the line at order 1
_BELOW = 0.93  # what turns slower than this is another shaft
#: In log likelihood. What a comb that is not the shaft's costs; a shaft outside the range that somebody gave; nothing
#: at all that turns, where one line among fifteen harmonics scores -2.
_FOREIGN, _OUTSIDE, _NOTHING = 4.0, 3.0, -5.0
_SIDEBAND_SHOWS = 0.4
_FRACTIONS = 6
_BLUR = 6.0  # over the place of the sharpest line, a 25th of a bin
#: Odds of a slower shaft that does not show at all, at a usual speed; fast machines are rare.
_HIDDEN, _USUAL_HZ = 0.03, 40.0
#: Bursts of the envelope once a turn, by depth, and short ones, by harmonics over the first: a race's. An unbalanced
#: shaft moves smoothly and teeth modulate as a sine does; a loose or a rubbing shaft strikes too, hence the chance.
_BURSTS, _HARMONICS_OVER_FIRST = 0.25, (0.5, 0.3)
_SHAFT_STRIKES = 0.4
_BEATEN = 3.0  # so much likelier is a hidden shaft where the envelope beats at the speed followed
_BURST_RATIO = 25.0  # power of a line of the envelope over its noise
_WINDOWS_OF_ENVELOPE, _ENVELOPE_ORDERS = 3, 7.0


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of the record along the angle: its middle sample, the chance that the angle is the shaft's, its lines.

    All limits are orders: ``slowest`` is what can be told apart at all, ``lowest`` and ``highest`` were looked for.
    """

    middle: float
    chance: float
    lines: list[Peaks]
    slowest: float
    lowest: float
    highest: float


def trust(
    signals: np.ndarray, *, rate_hz: float, phase_turns: np.ndarray, range_hz: tuple[float, float]
) -> list[Piece]:
    """Return how far the angle can be taken for the shaft's, piece by piece.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    rate_hz : float
    phase_turns : numpy.ndarray, shape (samples,)
        Rising angle along the ridge.
    range_hz : (float, float)
        Speeds that were looked for; rivals outside it count less, not nothing.

    Returns
    -------
    list of Piece
        Of at most 150 turns each.
    """
    turns = phase_turns[-1] - phase_turns[0]
    # Several, as a ridge may change over from one comb to another; together the two might pass for a third.
    pieces = max(int(np.ceil(turns / _TURNS_A_PIECE)), min(_PIECES, int(turns / _FEW_TURNS)), 1)
    edges = np.linspace(phase_turns[0], phase_turns[-1], pieces + 1)
    cuts = np.searchsorted(phase_turns, edges[1:-1])
    bounds = np.concatenate([[0], cuts, [phase_turns.size]])
    return [
        _of_piece(signals[:, first:last], rate_hz, phase_turns[first:last], range_hz, 0.5 * (first + last))
        for first, last in pairwise(bounds)
    ]


def decimated(block: np.ndarray, rate_hz: float, highest_hz: float) -> tuple[np.ndarray, int]:
    """Return the channels at a lower rate that still holds a frequency, and the whole factor between the rates."""
    factor = _factor(rate_hz, highest_hz)
    if factor == 1:
        return block, 1
    samples = block.shape[1]
    return _at_lower_rate(fft.rfft(block, n=_padded(samples, factor), axis=1), samples, factor), factor


def _factor(rate_hz: float, highest_hz: float) -> int:
    """Return the whole factor by which a rate can be lowered so that it still holds a frequency, of small factors."""
    return fast_length_within(max(int(0.45 * rate_hz / highest_hz), 1))


def _padded(samples: int, factor: int) -> int:
    """Return the length of a transform that is fast at the old and at the lower rate."""
    return fast_length(-(-samples // factor)) * factor


def _at_lower_rate(transform: np.ndarray, samples: int, factor: int) -> np.ndarray:
    """Return the signals of so many samples, from the transform of their padded length, at a rate lower by a factor."""
    kept = -(-samples // factor)
    fewer = fast_length(kept)
    slow = fft.irfft(transform[:, : fewer // 2 + 1], n=fewer, axis=1)[:, :kept]
    return np.ascontiguousarray(slow / factor)


def _of_piece(
    signals: np.ndarray, rate_hz: float, phase: np.ndarray, range_hz: tuple[float, float], middle: float
) -> Piece:
    """Return a piece of the record; ``middle`` is its sample in the whole."""
    steps = np.diff(phase)
    if steps.min() <= 0 or int(np.floor(phase[-1]) - np.ceil(phase[0])) < _LEAST_TURNS:
        return Piece(middle, 0.0, [], 0.0, 0.0, 0.0)
    mean_hz = float(phase[-1] - phase[0]) * rate_hz / (phase.size - 1)
    fastest_hz = float(steps.max()) * rate_hz
    factor = _factor(rate_hz, float(_ORDERS[-1] + 2) * fastest_hz)
    # One transform serves the lines and the bands of the envelopes: it is most of the cost.
    length = _padded(phase.size, factor)
    transform = fft.rfft(signals - signals.mean(axis=1, keepdims=True), n=length, axis=1)
    slow = signals if factor == 1 else _at_lower_rate(transform, phase.size, factor)
    even = angular_resample(slow, phase_turns=_angle_at(phase, slow.shape[1], factor), samples_per_turn=_PER_TURN)
    spectrum = spectrum_with_floor(even, rate_hz=_PER_TURN, floor_width_hz=1.0)
    # Beyond half the sampling rate a harmonic is not missing but unknown.
    span = min(0.45 * rate_hz / fastest_hz, 0.5 * _PER_TURN)
    # What drifts slower than any shaft is no rival.
    slowest = max(min(_SLOWEST_HZ, 0.75 * range_hz[0]) / mean_hz, 3 * spectrum.resolution_hz)
    lines = [_lines(spectrum, index, (slowest, float(_ORDERS[-1] + 2)), span) for index in range(signals.shape[0])]
    bursts = _envelopes(transform, length, rate_hz, phase, fastest_hz)
    beats = [_lines(one, 0, (slowest, 4.5), span) for one in bursts]
    depths = np.array([_depths(one) for one in bursts]).reshape(-1, 3)
    lowest, highest = range_hz[0] / mean_hz, range_hz[1] / mean_hz
    share = _share(lines, beats, slowest, lowest, highest)
    hidden = _HIDDEN * (1 + (mean_hz / _USUAL_HZ) ** 2) * (1.0 if lowest < 0.5 else np.exp(-0.5 * _OUTSIDE))
    is_beaten = depths[:, 0] > _BURSTS
    is_short = is_beaten & (depths[:, 1:] > np.multiply(_HARMONICS_OVER_FIRST, depths[:, :1])).all(axis=1)
    share = share / (1 + (_BEATEN if is_beaten.any() else 1.0) * hidden * share)
    share *= _SHAFT_STRIKES if is_short.any() else 1.0
    return Piece(middle, share, [one for one in lines if one.frequency_hz.size], slowest, lowest, highest)


def _angle_at(phase: np.ndarray, samples: int, factor: float) -> np.ndarray:
    """Return the angle at samples of a rate that is lower by a factor."""
    at = np.minimum(np.arange(samples) * factor, phase.size - 1.0)
    left = np.minimum(at.astype(int), phase.size - 2)
    angle = phase[left] + (at - left) * (phase[left + 1] - phase[left])
    return angle + np.arange(samples) * 1e-12  # past the end of the record it would stand still


def _lines(spectrum: Spectrum, channel: int, limits: tuple[float, float], span: float) -> Peaks:
    """Return the lines of a channel between two orders."""
    found = find_peaks(spectrum, channel, highest_hz=limits[1])
    kept = found.frequency_hz > limits[0]
    return Peaks(found.frequency_hz[kept], found.deviation_hz[kept], found.power_ratio[kept], span)


def _without_weak(peaks: Peaks) -> Peaks:
    """Return the lines without those that are weak beside the one at order 1: no shaft would be named after them.

    Close to it the limit is higher: a speed and a size that swing leave lines there.
    """
    near = np.abs(peaks.frequency_hz - 1)
    strongest = peaks.power_ratio[near < _NOT_ONE].max(initial=0.0)
    limit = np.where(near < _SKIRT_WIDTH, _SKIRT, _WEAK) * strongest
    kept = (near < _NOT_ONE) | (peaks.power_ratio > limit)
    return Peaks(peaks.frequency_hz[kept], peaks.deviation_hz[kept], peaks.power_ratio[kept], peaks.span_hz)


def _share(lines: list[Peaks], beats: list[Peaks], slowest: float, lowest: float, highest: float) -> float:
    """Return the share of the evidence that order 1 has, against its rivals and against nothing.

    ``lines`` are those of the signals, ``beats`` those of their envelopes; limits are orders of the speed followed.
    """
    lines = [one for one in lines if one.frequency_hz.size]
    if not lines:
        return 0.0
    speeds = np.unique(np.append(candidate_speeds([_without_weak(one) for one in lines], slowest, _FASTEST), 1.0))
    is_own = np.abs(speeds - 1) < _NOT_ONE
    gains = comb_gains(lines, speeds, orders=_ORDERS, shows=HARMONIC_SHOWS)
    below = np.max([lines_below(one, speeds) for one in lines], axis=0)
    own = float((gains - below)[is_own].max())
    outside = (speeds < 0.98 * lowest) | (speeds > 1.02 * highest)
    scores = (gains - below - _OUTSIDE * outside)[~is_own]
    against = _weight(speeds[~is_own], scores - own) + float(np.exp(0.5 * min(_NOTHING - own, 50.0)))
    beats = [one for one in beats if one.frequency_hz.size]
    against += max(_slower_shafts(peaks, slowest, lowest) for peaks in (lines, beats) if peaks)
    return 1.0 / (1.0 + against)


def _weight(speeds: np.ndarray, scores: np.ndarray) -> float:
    """Return the sum over groups of rivals; scores are halved, as lines are not independent evidence."""
    best = best_of_clusters(speeds, scores, _APART)
    return float(np.exp(0.5 * np.minimum(best, 50.0)).sum())


def _slower_shafts(lines: list[Peaks], slowest: float, lowest: float) -> float:
    """Return the odds of shafts below the speed, to which its whole comb is foreign.

    The comb is explained either way; what decides are the lines that only the slower shaft explains.
    """
    speeds = _slower_speeds(lines, slowest)
    if not speeds.size:
        return 0.0
    gains = _slower_gains(lines, speeds)
    # The speed was placed on one of these lines: that one says nothing.
    evidence = gains.sum(axis=1) - gains.max(axis=1) - _FOREIGN
    outside = speeds < 0.98 * lowest
    best = float((evidence - _OUTSIDE * outside).max())
    # One shaft of unknown speed is the rival, not one at every line: the best stands for all.
    return float(np.exp(0.5 * min(best, 50.0)))


def slower_shaft(pieces: list[Piece]) -> tuple[float, float]:
    """Return the order of the likeliest slower shaft within the speeds looked for, and its evidence.

    What one piece of a record hardly shows, a line that stays at one order does in all of them together. The evidence
    is in log likelihood, as elsewhere here; it is minus infinity where there is no such shaft.
    """
    pieces = [one for one in pieces if one.lines]
    found = [_slower_speeds(one.lines, one.slowest) for one in pieces]
    found = [speeds[(speeds > one.lowest) & (speeds < one.highest)] for speeds, one in zip(found, pieces, strict=True)]
    speeds = np.unique(np.concatenate(found)) if found else np.empty(0)
    if not speeds.size:
        return 1.0, -np.inf
    gains = np.sum([_slower_gains(one.lines, speeds) for one in pieces], axis=0)
    evidence = gains.sum(axis=1) - gains.max(axis=1) - _FOREIGN
    best = int(np.argmax(evidence))
    return float(speeds[best]), float(evidence[best])


def _slower_speeds(lines: list[Peaks], slowest: float) -> np.ndarray:
    """Return the orders below 1 at which another shaft may turn, sorted."""
    beside = np.concatenate([np.abs(one.frequency_hz - 1) for one in lines])
    beside = beside[(beside > slowest) & (beside < 0.45)]
    speeds = np.unique(np.append(candidate_speeds(lines, slowest, _BELOW), beside))
    # Of a half, a third, ... of the speed the comb is no foreign one: those have competed already.
    whole = np.rint(1 / speeds)
    return speeds[(np.abs(1 / speeds - whole) > 0.03) | (whole > _FRACTIONS)]


def _slower_gains(lines: list[Peaks], speeds: np.ndarray) -> np.ndarray:
    """Return what four harmonics and two sidebands of order 1 gain by the lines, shape (speeds, 6)."""
    harmonics = speeds[:, None] * _ORDERS[None, :4]
    sidebands = np.stack([1 - speeds, 1 + speeds], axis=1)
    wanted = np.concatenate([harmonics, sidebands], axis=1)
    shows = np.append(HARMONIC_SHOWS[:4], [_SIDEBAND_SHOWS] * 2)
    gains = np.max([place_gains(_blurred(one), wanted, speeds, shows) for one in lines], axis=0)
    is_apart = np.concatenate([harmonics < _BELOW, np.repeat(speeds[:, None] < 0.45, 2, axis=1)], axis=1)
    return np.where(is_apart, gains, 0.0)


def _blurred(peaks: Peaks) -> Peaks:
    """Return the lines with places less sure: along the angle of a bearing that slips a shaft's line is not sharp."""
    deviation = np.hypot(peaks.deviation_hz, _BLUR * float(peaks.deviation_hz.min(initial=np.inf)))
    return Peaks(peaks.frequency_hz, deviation, peaks.power_ratio, peaks.span_hz)


def _envelopes(transform: np.ndarray, length: int, rate_hz: float, phase: np.ndarray, fastest: float) -> list[Spectrum]:
    """Return the spectra over order of the squared envelopes in three bands above the harmonics, by channel.

    ``transform`` is that of the signals, padded to a length in samples; ``fastest`` the highest speed in Hz.
    """
    highest = 0.49 * rate_hz
    lowest = 8 * fastest
    if highest - lowest < 12 * fastest:
        return []
    edges = np.exp(np.linspace(np.log(lowest), np.log(highest), _WINDOWS_OF_ENVELOPE + 1))
    found = []
    for row in transform:
        for low, high in pairwise(edges):
            if high - low < 10 * fastest:
                continue
            envelope, slow_hz = envelope_from_transform(row, length, rate_hz=rate_hz, low_hz=low, high_hz=high)
            inside = envelope[None, : int(envelope.size * (phase.size / length))]
            beat, factor = decimated(inside**2, slow_hz, _ENVELOPE_ORDERS * fastest)
            angle = _angle_at(phase, beat.shape[1], factor * rate_hz / slow_hz)
            power = angular_resample(beat, phase_turns=angle, samples_per_turn=16)
            scale = max(float(power.mean()), np.finfo(float).tiny)
            found.append(spectrum_with_floor(power / scale, rate_hz=16.0, floor_width_hz=1.0))
    return found


def _depths(envelope: Spectrum) -> list[float]:
    """Return how deep the envelope beats once, twice and three times a turn, 0 where that is not above its noise."""
    depths = []
    for order in (1.0, 2.0, 3.0):
        near = np.abs(envelope.frequency_hz - order) < max(0.01 * order, 1.5 * envelope.resolution_hz)
        held = near & (envelope.power_ratio[0] > _BURST_RATIO)
        depths.append(float(envelope.amplitude[0, held].max(initial=0.0)))
    return depths
