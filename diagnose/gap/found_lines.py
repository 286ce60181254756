"""Lines that the recordings show and that neither the shaft's low orders nor any effect of the catalogue states.

Without them, what is outside the catalogue would be looked for only where the catalogue looks. A line is found where
the spectrum of a whole record stands above its surroundings by more than noise does, at the same order or at the same
frequency in half of the recordings, or far more so in one: what excites itself begins at some speed, and a resonance
lifts a line at another. What the healthy records show as well is left alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...datasets.recording import Recording
from .line_sizes import FEWEST_PERIODS, HALVES_TO, HIGHEST_SHARE, LEAST_BINS, WANDER, least_seconds, line_power
from .lines import LineKind
from .observe import shaft_turns

#: Chance that noise alone makes a line anywhere in a record.
CHANCE = 1e-3
#: Surroundings of a line on each side, in lines of the spectrum from it: from and to.
AROUND = (5, 25)
#: Lines that are added at most, the clearest first; the share of recordings that show each, or how many times the power
#: that noise reaches it has in one of them.
MOST_FOUND, IN_RECORDINGS, ALONE = 3, 0.5, 4.0
#: The latter where no healthy record has a line that is in it alone: the machine's surroundings then make none.
ALONE_AMONG_QUIET = 1.5
#: A line is new when its amplitude is so many times that of the healthy records.
GROWN = 2.0
#: Lines at so small a part of a record's mean square are no cause of anything: rounding, leakage.
LEAST_SHARE = 1e-5
#: Half orders, where they are locked, and whole orders are kept clear by this part of an order, below the first of
#: this part of themselves: wander widens them.
CLEAR = 0.04
#: Whole orders above the halves are lines that may be found.
WHOLE = 0.004

Line = tuple[float, LineKind]
Stated = tuple[Sequence[float], Sequence[LineKind]]


@dataclass(frozen=True)
class FoundLine:
    """A further line: its order and kind, and where it lies by the other law if the recordings tell no law.

    Attributes
    ----------
    order : float
    kind : LineKind
        With the frequency in Hz, where the line stays there.
    places : tuple of tuple of float
        Order and added frequency in Hz: of one law, or of both, as in a line of a single recording.
    """

    order: float
    kind: LineKind
    places: tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """A record's spectrum: power (channels, lines), its floor, where lines may be looked for, and those that stand out.

    ``peaks`` holds the places of the lines that stand out, between lines of the spectrum; ``excess`` how many times the
    power is that noise reaches.
    """

    power: np.ndarray
    resolution_hz: float
    speed_hz: float
    peaks: np.ndarray
    excess: np.ndarray

    def place(self, order: float, kind: LineKind) -> float:
        return abs(order * self.speed_hz + kind.frequency_hz)

    def near(self, frequency_hz: float) -> float:
        """Return how far from a frequency a line counts as the same."""
        return max(LEAST_BINS * self.resolution_hz, WANDER * frequency_hz)

    def seen_at(self, frequency_hz: float) -> float:
        """Return the frequency of the line that stands out there; NaN where none does."""
        places = self.peaks * self.resolution_hz
        away = np.abs(places - frequency_hz)
        if not away.size or away.min() > self.near(frequency_hz):
            return math.nan
        return float(places[np.argmin(away)])

    def amplitudes(self, frequency_hz: float) -> np.ndarray:
        """Return the largest amplitude near a frequency at each channel."""
        half = self.near(frequency_hz) / self.resolution_hz
        middle = frequency_hz / self.resolution_hz
        band = slice(max(int(middle - half), 0), int(middle + half) + 2)
        return 2 * np.sqrt(self.power[:, band].max(axis=1, initial=0.0))


def found_lines(
    recordings: Sequence[Recording], healthy: Sequence[Recording], channels: Sequence[str], stated: Stated
) -> list[FoundLine]:
    """Return the further lines, the clearest first.

    Parameters
    ----------
    recordings, healthy : sequence of Recording
        At steady speed; ``healthy`` may be empty.
    channels : sequence of str
        That are looked at.
    stated : orders, kinds
        Lines that are looked at anyway.
    """
    stated = _readable(stated, recordings)
    spectra = [_spectrum(one, channels, stated) for one in recordings]
    usual = [_spectrum(one, channels, stated) for one in healthy]
    found: list[FoundLine] = []
    alone = _least_alone(usual)
    for excess, peak, own in sorted(_peaks(spectra), key=lambda item: -item[0]):
        laws = _laws(peak * own.resolution_hz, own, spectra)
        line = laws[0]
        if any(_is_same(line, (other.order, other.kind), spectra) for other in found):
            continue
        # A whole order may lie too far beside the peak that was rounded to it.
        count = _count(line, spectra)
        is_shown = count > 0 and (excess >= alone or count >= IN_RECORDINGS * len(spectra))
        if is_shown and _has_grown(line, spectra, usual):
            exact = [_refined(one, spectra) for one in laws]
            found.append(FoundLine(*exact[0], tuple((order, kind.frequency_hz) for order, kind in exact)))
        if len(found) == MOST_FOUND:
            break
    return found


def _readable(stated: Stated, recordings: Sequence[Recording]) -> Stated:
    """Return those of the lines that some recording is long enough for: others would hide what lies near them."""
    lengths = [(_speed_hz(one), one.samples / one.rate_hz) for one in recordings]
    kept = [
        (order, kind)
        for order, kind in zip(*stated, strict=True)
        if kind.phase or any(least_seconds(order, kind, speed_hz) <= seconds for speed_hz, seconds in lengths)
    ]
    return [order for order, _ in kept], [kind for _, kind in kept]


def _speed_hz(recording: Recording) -> float:
    turns = shaft_turns(recording)
    return float((turns[-1] - turns[0]) / (recording.samples - 1) * recording.rate_hz)


def _peaks(spectra: Sequence[_Spectrum]) -> list[tuple[float, float, _Spectrum]]:
    return [(float(e), float(p), own) for own in spectra for p, e in zip(own.peaks, own.excess, strict=True)]


def _least_alone(usual: Sequence[_Spectrum]) -> float:
    """Return the excess from which a line that is in one recording only counts."""
    lines = [_laws(peak * own.resolution_hz, own, usual)[0] for _, peak, own in _peaks(usual)]
    has_lone = any(_count(line, usual) == 1 for line in lines)
    return ALONE_AMONG_QUIET if usual and not has_lone else ALONE


def _spectrum(recording: Recording, channels: Sequence[str], stated: Stated) -> _Spectrum:
    from scipy.ndimage import maximum_filter1d

    names = [channel.name for channel in recording.channels]
    signals = recording.signals[[names.index(name) for name in channels]]
    speed_hz = _speed_hz(recording)
    power = line_power(signals - signals.mean(axis=1, keepdims=True))
    resolution = recording.rate_hz / recording.samples
    frequency = np.arange(power.shape[1]) * resolution
    ratio = power / (_surroundings(power) + 1e-300)
    # The power of noise is exponential: its median is ln 2 of its mean.
    least = math.log(power.size / CHANCE) / math.log(2)
    strong = power > LEAST_SHARE * power.sum(axis=1, keepdims=True)
    excess = np.where((ratio > least) & strong, ratio / least, 0.0).max(axis=0)
    free = _free(frequency, speed_hz, resolution, stated)
    is_top = excess == maximum_filter1d(excess, 2 * AROUND[0] + 1)
    tops = np.flatnonzero(free & is_top & (excess > 0))
    peaks = tops + _beside_top(power[np.argmax(ratio[:, tops], axis=0)[:, None], tops[:, None] + [-1, 0, 1]])
    return _Spectrum(power, resolution, speed_hz, peaks, excess[tops])


def _beside_top(power: np.ndarray) -> np.ndarray:
    """Return where the parabola through the logarithms of three powers is highest, from the middle one; (lines, 3)."""
    left, middle, right = np.log(power + 1e-300).T
    return 0.5 * (left - right) / np.minimum(left - 2 * middle + right, -1e-12)


def _surroundings(power: np.ndarray) -> np.ndarray:
    """Return the larger of the medians on both sides of each line, so that a slope or a foot is no line."""
    from scipy.ndimage import median_filter

    near, far = AROUND
    middle = (near + far) // 2
    medians = median_filter(power, size=(1, far - near + 1))
    result = np.full(power.shape, np.inf)
    result[:, :-middle] = medians[:, middle:]
    # Below, there is no room for the lower side.
    result[:, far:-middle] = np.maximum(result[:, far:-middle], medians[:, far - middle : -2 * middle])
    return result


def _free(frequency: np.ndarray, speed_hz: float, resolution_hz: float, stated: Stated) -> np.ndarray:
    """Return where a line would be none that is looked at anyway, nor the foot of one."""
    order = frequency / speed_hz
    half = np.abs(order - np.maximum(np.round(2 * order), 1.0) / 2)
    # The feet of a line that stands out itself are no peaks of `_spectrum`.
    clear = np.maximum(CLEAR * np.minimum(order, 1.0), LEAST_BINS * resolution_hz / speed_hz)
    free = (order > HALVES_TO) | (half > clear)
    whole = np.abs(order - np.maximum(np.round(order), 1.0))
    free &= (whole > clear) | (whole < _about_whole(resolution_hz, speed_hz))
    highest = HIGHEST_SHARE * (frequency[-1] * 2)
    free &= (frequency > FEWEST_PERIODS * resolution_hz) & (frequency < highest)
    for stated_order, kind in zip(*stated, strict=True):
        if not kind.envelope:
            place = abs(stated_order * speed_hz + kind.frequency_hz)
            free &= np.abs(frequency - place) > np.maximum(3 * WANDER * place, (LEAST_BINS + 0.5) * resolution_hz)
    return free


def _about_whole(resolution_hz: float, speed_hz: float) -> float:
    """Return how far from a whole order a line counts as one."""
    return max(WHOLE, LEAST_BINS * resolution_hz / speed_hz)


def _laws(frequency_hz: float, own: _Spectrum, spectra: Sequence[_Spectrum]) -> list[Line]:
    """Return the line as an order or as a frequency: the one at which more recordings show it, or both."""
    order = frequency_hz / own.speed_hz
    whole = abs(order - round(order)) < _about_whole(own.resolution_hz, own.speed_hz)
    at_order = (round(order) if whole else order), LineKind(phase=False)
    at_frequency = 0.0, LineKind(phase=False, frequency_hz=frequency_hz)
    counts = [_count(line, spectra) for line in (at_order, at_frequency)]
    if counts[0] == counts[1]:
        is_whole = at_order[0] == round(order)
        return [at_order] if is_whole else [at_frequency, at_order]
    return [at_order if counts[0] > counts[1] else at_frequency]


def _count(line: Line, spectra: Sequence[_Spectrum]) -> int:
    return sum(math.isfinite(one.seen_at(one.place(*line))) for one in spectra)


def _refined(line: Line, spectra: Sequence[_Spectrum]) -> Line:
    """Return the line at the median of what the recordings show."""
    order, kind = line
    if kind.frequency_hz:
        seen = [one.seen_at(kind.frequency_hz) for one in spectra]
        return order, replace(kind, frequency_hz=float(np.nanmedian(seen)))
    seen = [one.seen_at(one.place(*line)) / one.speed_hz for one in spectra]
    return order if order == round(order) else float(np.nanmedian(seen)), kind


def _is_same(line: Line, other: Line, spectra: Sequence[_Spectrum]) -> bool:
    return any(abs(one.place(*line) - one.place(*other)) <= 2 * one.near(one.place(*line)) for one in spectra)


def _has_grown(line: Line, spectra: Sequence[_Spectrum], usual: Sequence[_Spectrum]) -> bool:
    """Return whether a line is larger than in every healthy record that shows it, and than in the nearest in speed.

    Noise at other speeds may be larger than the line and says nothing about it.
    """
    if not usual:
        return True
    showing = [one for one in spectra if math.isfinite(one.seen_at(one.place(*line)))]
    nearest = [min(usual, key=lambda one: abs(one.speed_hz - own.speed_hz)) for own in showing]
    compared = [one for one in usual if one in nearest or math.isfinite(one.seen_at(one.place(*line)))]
    now = np.median([one.amplitudes(one.place(*line)) for one in showing], axis=0)
    before = np.max([one.amplitudes(one.place(*line)) for one in compared], axis=0)
    return bool((now > GROWN * before).any())
