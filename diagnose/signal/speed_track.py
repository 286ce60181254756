"""Speed over time from the vibration alone: the ridge of the shaft's harmonics in a time-frequency map.

First a ridge, then its phase. For every frame a comb of harmonics is scored at each speed by likelihood: a line there
against noise there. The dearest path through all frames that moves no faster than a machine can (Viterbi) is the
ridge, the posterior near it the confidence. Along the ridge the harmonics are then turned to zero frequency; the phase
steps that are left between frames give the speed to a small part of a bin
(S. Schmidt, P. S. Heyns, J. P. de Villiers, MSSP 100 (2018) 158, for the ridge).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError
from .spectrum import fast_length, hann
from .speed_trust import decimated, slower_shaft, trust

_STEP = 0.01  # relative distance of neighbouring speeds
#: Chance that harmonic 1, 2, ... shows above the noise of one frame.
_SHOWS = np.array([0.85, 0.7, 0.6, 0.5, 0.4, 0.35, 0.3, 0.3])
#: Between the harmonics a shaft has few lines: they speak for half the speed, or another comb.
_BETWEEN = np.array([0.5, 1.5, 2.5])
_BETWEEN_SHOWS = 0.5
_TYPICAL_RATIO = 10.0  # power of a line over the noise of a frame
_MOST_EVIDENCE = 6.0  # of one line, in log likelihood: a strong line is one line all the same
_SKIRT = 0.02  # of a strong line's power: what stands beside it at this level is its own skirt
_FAR_SKIRT = 2e-5  # six bins away a Hann line is down to 2e-6; moving within the frame, a little more
_NEIGHBOURS = 6
_PERIODS_A_FRAME = 5.0
_LONGEST_FRAME_S, _SHORTEST_FRAME_S = 0.5, 0.1
_LEAST_TURNS_A_FRAME = 2.0
_FRAMES_OVERLAPPING = 4
_NEAR = 0.03
_BLOCKS_A_STEP = 4
_ROUNDS = 3
_CLEARLY_SLOWER = 2.0  # evidence of a slower shaft from which it is followed instead
_HARMONICS_REFINED = 8
_COHERENCE_OF_NOISE = 1.0  # over one less itself; noise alone has 0.4 in the median


@dataclass(frozen=True, eq=False)
class SpeedTrack:
    """Shaft speed over time.

    Attributes
    ----------
    time_s, speed_hz : numpy.ndarray, shape (frames,)
    confidence : numpy.ndarray, shape (frames,)
        Probability that the shaft's speed is within 3 % of the one given, 0 to 1.
    phase_turns : numpy.ndarray, shape (samples,)
        Shaft angle from an arbitrary zero: good for orders and their sizes, not for phases to a mark.
    """

    time_s: np.ndarray
    speed_hz: np.ndarray
    confidence: np.ndarray
    phase_turns: np.ndarray


def track_speed(
    signals: np.ndarray,
    *,
    rate_hz: float,
    lowest_hz: float = 4.0,
    highest_hz: float = 500.0,
    fastest_change: float = 1.0,
) -> SpeedTrack:
    """Return the speed of a shaft over a run-up, a coast-down or a wandering run, without a tacho.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
        Finite vibration signals of one machine.
    rate_hz : float
    lowest_hz, highest_hz : float
        Speeds looked for. The narrower, the surer.
    fastest_change : float
        Of the speed, relative and a second: 1 follows a doubling in 0.7 s or slower.

    Raises
    ------
    InvalidValueError
        When the range is empty or the record holds fewer than four overlapping frames (0.5 s each, or five periods of
        the lowest speed where that is less, or two where that is more).

    Notes
    -----
    What is tracked is the strongest comb, and a slower shaft instead where all of the record speaks clearly for it: a
    damaged bearing's comb may be stronger than the shaft's. Half or twice the speed cannot always be told apart.
    ``confidence`` says so: it is the less of what the ridge gives within the range and of what all lines of the record
    say of the comb once the angle is known (`speed_trust`).

    Examples
    --------
    >>> t = np.arange(60000) / 10000
    >>> phase = 15 * t + 2 * t**2
    >>> x = sum(np.cos(2 * np.pi * n * phase) / n for n in (1, 2, 3)) + np.random.default_rng(0).normal(0, 1, t.size)
    >>> found = track_speed(x, rate_hz=10000)
    >>> bool(np.median(np.abs(found.speed_hz / (15 + 4 * found.time_s) - 1)) < 1e-3)
    True
    """
    block = np.ascontiguousarray(np.atleast_2d(np.asarray(signals, dtype=float)))
    block = block - block.mean(axis=1, keepdims=True)
    highest_hz = min(highest_hz, 0.4 * rate_hz)
    if not 0 < lowest_hz < highest_hz:
        raise InvalidValueError(f"Speeds {lowest_hz} to {highest_hz} Hz; allowed: 0 < lowest < highest.")
    frame_s = min(max(_PERIODS_A_FRAME / lowest_hz, _SHORTEST_FRAME_S), _LONGEST_FRAME_S)
    # Below 4 Hz half a second would hold too little of a turn to tell its harmonics apart.
    frame_s = max(frame_s, _LEAST_TURNS_A_FRAME / lowest_hz)
    length = round(frame_s * rate_hz)
    hop = max(length // _FRAMES_OVERLAPPING, 1)
    if block.shape[1] < length + 3 * hop:
        raise InvalidValueError(
            f"Record of {block.shape[1] / rate_hz:.3g} s; allowed: {(length + 3 * hop) / rate_hz:.3g} s or more. Give "
            "a longer record or a higher lowest speed."
        )
    samples, full = block.shape[1], block
    # Nothing above the highest harmonic is looked at.
    block, factor = decimated(block, rate_hz, 1.05 * _SHOWS.size * highest_hz)
    slow_hz = rate_hz / factor
    length = round(frame_s * slow_hz)
    hop = max(length // _FRAMES_OVERLAPPING, 1)
    starts = np.arange(0, block.shape[1] - length + 1, hop)
    speeds = lowest_hz * np.exp(_STEP * np.arange(int(np.log(highest_hz / lowest_hz) / _STEP) + 1))
    scores = _comb_scores(block, slow_hz, length, starts, speeds)
    place, confidence = _ridge(scores, fastest_change * hop / slow_hz)
    middle = (starts + 0.5 * length) / slow_hz
    coarse = lowest_hz * np.exp(_STEP * place)
    phase = _phase_along(middle, coarse, block.shape[1], slow_hz)
    for _ in range(_ROUNDS):
        phase = _refined(block, phase, slow_hz, hop, float(coarse.max()))
    whole = _at_every_sample(phase, factor, samples)
    look = {"rate_hz": rate_hz, "range_hz": (lowest_hz, highest_hz)}
    pieces = trust(full, phase_turns=whole, **look)
    order, evidence = slower_shaft(pieces)
    if evidence > _CLEARLY_SLOWER:
        # The comb that was followed belongs to a bearing or a gear; what is known of the ridge is about that one.
        phase = _refined(block, order * phase, slow_hz, hop, float(order * coarse.max()))
        whole = _at_every_sample(phase, factor, samples)
        pieces = trust(full, phase_turns=whole, **look)
        confidence = np.full(confidence.size, 1 / (1 + np.exp(-0.5 * evidence)))
    speed = np.interp(middle * slow_hz, np.arange(phase.size), np.gradient(phase)) * slow_hz
    # Both weigh half and twice the speed: the more doubtful counts, not both.
    chance = np.interp(middle * rate_hz, [one.middle for one in pieces], [one.chance for one in pieces])
    confidence = np.minimum(confidence, chance)
    return SpeedTrack(middle, speed, confidence, whole)


def _at_every_sample(phase: np.ndarray, factor: int, samples: int) -> np.ndarray:
    """Return an angle known at every so many samples at all of them; it runs on at its last speed."""
    if factor == 1:
        return phase
    ends = np.append(phase, 2 * phase[-1] - phase[-2])
    # As rows between two known angles: the same as numpy's interp, in a fifth of its time.
    rows = ends[:-1, None] + np.diff(ends)[:, None] * (np.arange(factor) / factor)
    return rows.ravel()[:samples]


def _comb_scores(
    block: np.ndarray, rate_hz: float, length: int, starts: np.ndarray, speeds_hz: np.ndarray
) -> np.ndarray:
    """Return the log likelihood ratio of a comb against noise, shape (frames, speeds).

    On a logarithmic axis a harmonic is a shift, so that the comb is a sum of shifted slices.
    """
    padded = fast_length(2 * length)
    orders = np.concatenate([np.arange(1.0, _SHOWS.size + 1), _BETWEEN])
    shifts = np.rint(np.log(orders) / _STEP).astype(int)
    lowest = int(shifts.min())
    count = speeds_hz.size
    axis = speeds_hz[0] * np.exp(_STEP * np.arange(lowest, count + int(shifts.max())))
    resolution = rate_hz / padded
    first = np.rint(axis * np.exp(-0.5 * _STEP) / resolution).astype(int)
    after = np.maximum(np.rint(axis * np.exp(0.5 * _STEP) / resolution).astype(int), first + 1)
    bins = min(int(after[-1]) + 1, padded // 2 + 1)
    inside = after < bins
    cells = np.stack([first[inside], after[inside]], axis=1).ravel()
    window = hann(length)
    total = np.zeros((starts.size, count))
    half_width = max(round(1.5 * speeds_hz[0] / resolution), 40)
    middle = np.minimum(0.5 * (first + after - 1)[inside], bins - 1)
    # The highest of several noise values is higher, by the logarithm of their number (half of the bins are padding).
    excess = np.log(np.maximum(0.5 * (after - first)[inside], 1.0))
    for row in block:
        frames = np.lib.stride_tricks.sliding_window_view(row, length)[starts]
        power = np.abs(fft.rfft(frames * window, n=padded, axis=1)[:, :bins]) ** 2
        noise = _floor_at(power, 2 * half_width, middle) + _SKIRT * _highest_near(power, middle)
        noise += _FAR_SKIRT * power.max(axis=1, keepdims=True)
        pooled = np.maximum.reduceat(_peaks_only(power), cells, axis=1)[:, ::2] / noise
        gain = np.zeros((starts.size, axis.size))
        gain[:, inside] = np.maximum(pooled - excess, 0.0)
        total += _shifted_sum(gain, shifts - lowest, count)
    return total / np.sqrt(block.shape[0])


def _peaks_only(power: np.ndarray) -> np.ndarray:
    """Return the spectra without their slopes: local maxima and the bin on each side of them stay.

    The main lobe of a strong line would else be a line for every comb of which a harmonic falls into it.
    """
    is_peak = np.zeros(power.shape, dtype=bool)
    is_peak[:, 1:-1] = (power[:, 1:-1] >= power[:, :-2]) & (power[:, 1:-1] > power[:, 2:])
    kept = is_peak.copy()
    kept[:, 1:] |= is_peak[:, :-1]
    kept[:, :-1] |= is_peak[:, 1:]
    return np.where(kept, power, 0.0)


def _floor_at(power: np.ndarray, width: int, places: np.ndarray) -> np.ndarray:
    """Return the mean noise power of each frame at places (in bins), from medians of pieces, shape (frames, places)."""
    pieces = max(power.shape[1] // width, 1)
    width = power.shape[1] // pieces
    # Every second bin: the others are padding and say the same.
    cut = power[:, : pieces * width].reshape(power.shape[0], pieces, width)[:, :, ::2]
    level = np.log(np.maximum(np.median(cut, axis=2) / np.log(2.0), np.finfo(float).tiny))
    at = np.clip(places / width - 0.5, 0.0, pieces - 1.0)
    left = np.minimum(at.astype(int), max(pieces - 2, 0))
    share = at - left
    right = np.minimum(left + 1, pieces - 1)
    return np.exp(level[:, left] * (1 - share) + level[:, right] * share)


def _highest_near(power: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the highest power within about four bins of each place (eight, as the frames are padded)."""
    pieces = power.shape[1] // _NEIGHBOURS
    top = power[:, : pieces * _NEIGHBOURS].reshape(power.shape[0], pieces, _NEIGHBOURS).max(axis=2)
    wide = np.pad(top, ((0, 0), (1, 1)), mode="edge")
    wide = np.maximum(np.maximum(wide[:, 2:], wide[:, :-2]), top)
    return wide[:, np.minimum((places / _NEIGHBOURS).astype(int), pieces - 1)]


def _shifted_sum(ratio: np.ndarray, shifts: np.ndarray, count: int) -> np.ndarray:
    """Return the sum of the evidence at all orders of the comb, less what lies between them."""
    # A line of unknown strength has power over noise R with density a / (a + R)^2, noise exp(-R).
    line_over_noise = np.exp(np.minimum(ratio - 2 * np.log(_TYPICAL_RATIO + ratio), 50.0)) * _TYPICAL_RATIO
    total = np.zeros((ratio.shape[0], count))
    for number, shift in enumerate(shifts):
        part = line_over_noise[:, shift : shift + count]
        if number < _SHOWS.size:
            total += np.minimum(np.log(1 - _SHOWS[number] + _SHOWS[number] * part), _MOST_EVIDENCE)
        else:
            total -= np.clip(np.log(1 - _BETWEEN_SHOWS + _BETWEEN_SHOWS * part), 0.0, _MOST_EVIDENCE)
    return total


def _ridge(scores: np.ndarray, change_a_step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean column near the best path, and the posterior within 3 % of the path, at every step."""
    from .track_kernel import best_path, path_chances

    reach = max(round(change_a_step / _STEP), 1)
    price = 0.5 * (2.0 * np.arange(-reach, reach + 1) / reach) ** 2
    # Overlapping frames tell the same story several times.
    evidence = scores * (2.0 / _FRAMES_OVERLAPPING)
    path = np.empty(scores.shape[0], dtype=np.int64)
    best_path(evidence, price, path)
    chances = np.empty(scores.shape)
    weight = np.exp(-price)
    path_chances(evidence, weight / weight.sum(), chances)
    near = round(_NEAR / _STEP)
    columns = path[:, None] + np.arange(-near, near + 1)
    inside = (columns >= 0) & (columns < scores.shape[1])
    share = np.take_along_axis(chances, np.clip(columns, 0, scores.shape[1] - 1), axis=1) * inside
    mass = share.sum(axis=1)
    # Strong lines are as wide as the window: the path lies anywhere in them, their mean in the middle.
    return np.where(mass > 0, (share * columns).sum(axis=1) / np.maximum(mass, 1e-300), path), mass


def _phase_along(time_s: np.ndarray, speed_hz: np.ndarray, samples: int, rate_hz: float) -> np.ndarray:
    """Return the angle of a speed that is known at a few times, shape (samples,)."""
    # The ridge comes in steps; a quadratic through every few frames is what a machine can follow.
    smooth = _smoothed(speed_hz, np.ones(speed_hz.size), 4.0)
    speed = np.interp(np.arange(samples) / rate_hz, time_s, smooth)
    return np.cumsum(np.maximum(speed, 0.2 * speed_hz.min())) / rate_hz


def _smoothed(values: np.ndarray, weight: np.ndarray, stiffness: float) -> np.ndarray:
    """Return the sequence that minimises weighted squares plus stiffness times squared second differences."""
    from scipy.linalg import solveh_banded

    count = values.size
    if count < 4:
        return np.full(count, np.average(values, weights=weight))
    scale = stiffness * float(weight.mean())
    bands = np.zeros((3, count))
    bands[2] = weight
    for offset, one in ((0, 1.0), (1, -2.0), (2, 1.0)):
        bands[2, offset : count - 2 + offset] += scale * one * one
    bands[1, 1 : count - 1] += -2.0 * scale
    bands[1, 2:count] += -2.0 * scale
    bands[0, 2:] += scale
    return solveh_banded(bands, weight * values)


def _refined(block: np.ndarray, phase: np.ndarray, rate_hz: float, hop: int, highest_hz: float) -> np.ndarray:
    """Return the angle with what the harmonics' phases still turn from frame to frame taken in."""
    from .track_kernel import demodulate

    size = max(hop // _BLOCKS_A_STEP, 1)
    blocks = block.shape[1] // size
    harmonics = int(np.clip(0.45 * rate_hz / highest_hz, 1, _HARMONICS_REFINED))
    sums = np.empty((block.shape[0], blocks, harmonics), dtype=complex)
    demodulate(block, phase, size, sums)
    width = 2 * _BLOCKS_A_STEP
    window = hann(width + 1)[1:]
    views = np.lib.stride_tricks.sliding_window_view(sums, width, axis=1)[:, ::_BLOCKS_A_STEP]
    lines = views @ window
    steps = lines[:, 1:] * lines[:, :-1].conj()
    # How alike a harmonic's steps are over five neighbours says how far noise lets its phase be trusted.
    alike = _mean_of_neighbours(steps)
    size_of = np.maximum(_mean_of_neighbours(np.abs(steps)), 1e-300)
    coherence = np.minimum(np.abs(alike) / size_of, 0.999) ** 2
    # Squared, so that many harmonics of noise do not outweigh one that is there.
    trust = np.maximum(coherence / (1.0 - coherence) - _COHERENCE_OF_NOISE, 0.0) ** 2
    steps = alike / np.maximum(np.abs(alike), 1e-300) * trust
    order = np.arange(1, harmonics + 1)
    turn = np.linspace(-0.5 / harmonics, 0.5 / harmonics, 8 * harmonics + 1)
    fit = np.tensordot(steps, np.exp(-2j * np.pi * order[:, None] * turn), axes=(2, 0)).real.sum(axis=0)
    delta = turn[fit.argmax(axis=1)]
    # One Newton step from the best of the grid.
    turned = steps * np.exp(-2j * np.pi * order * delta[:, None])
    slope = (turned.imag * order).sum(axis=(0, 2))
    bend = np.maximum((np.abs(turned) * order**2).sum(axis=(0, 2)), 1e-300)
    limit = 1 / (16 * harmonics)
    delta = delta + np.clip(slope / bend / (2 * np.pi), -limit, limit)
    delta = _smoothed(delta, np.minimum(bend / np.median(bend), 10.0) + 1e-3, 1.0)
    # A step runs from the middle of one window to that of the next.
    ends = (np.arange(lines.shape[1]) * _BLOCKS_A_STEP + width / 2) * size
    speed = np.interp(np.arange(phase.size), 0.5 * (ends[1:] + ends[:-1]), delta / np.diff(ends))
    return phase + np.cumsum(speed)


def _mean_of_neighbours(steps: np.ndarray) -> np.ndarray:
    """Return means over five frames, fewer at the ends, along axis 1."""
    padded = np.pad(steps, ((0, 0), (3, 2), (0, 0)))
    padded[:, 0] = 0.0
    summed = np.cumsum(padded, axis=1)
    count = steps.shape[1]
    first, last = np.maximum(np.arange(count) - 2, 0), np.minimum(np.arange(count) + 2, count - 1)
    return (summed[:, 5:] - summed[:, :-5]) / (last - first + 1)[None, :, None]
