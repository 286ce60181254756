"""Tacho pulses: their times, and the repair of trains with missing and false pulses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Share of its range that a tacho moves from sample to sample and is still no noise for that.
QUIET = 1 / 20
#: An encoder behind an anti-alias filter rings from pulse to pulse and is never at rest: where so many pulses come as
#: evenly as this, nearly all of them, what moves is no noise. Crossings of noise lie as they please.
FEWEST_EVEN, EVENLY, NEARLY_ALL = 8, 0.2, 0.98
#: Turns that tell whether marks are unevenly spaced.
FEWEST_TURNS = 4
#: Part of a period after which the next pulse may come.
TOO_EARLY = 0.6
#: Share of periods that are near those nearby in a train of pulses; and in one that no bounces are looked for in.
REGULAR, CLEARLY_REGULAR = 0.5, 0.9
#: Turns that one period may last where pulses are missing.
MOST_MISSING = 6
#: Share of the periods nearby that are as long as one turn.
COMMON = 0.25
#: A bounce follows after less than this share of the longest distances (this percentile of all), and takes away so much
#: of the edges that this share is left at most: a few false ones are left to `repaired_pulses`.
BOUNCE, LONGEST_PERCENT, MOST_LEFT = 0.3, 95.0, 0.75


@dataclass(frozen=True, eq=False)
class PulseRepair:
    """A pulse train put right.

    Attributes
    ----------
    times_s : numpy.ndarray, shape (pulses,)
    missing : int
        Pulses filled in at equal distances.
    false : int
        Pulses left out, the second of a double pulse among them.
    """

    times_s: np.ndarray
    missing: int
    false: int


def repaired_pulses(times_s: np.ndarray) -> PulseRepair:
    """Return pulse times without false pulses and with missing ones filled in, judged by the periods nearby.

    One wrong pulse would turn the shaft angle of everything after it.

    Parameters
    ----------
    times_s : numpy.ndarray, shape (pulses,)
        Rising; three or more.

    Examples
    --------
    >>> repair = repaired_pulses(np.array([0.0, 1.0, 2.0, 2.1, 3.0, 5.0, 6.0, 7.0]))
    >>> repair.times_s.tolist(), repair.missing, repair.false
    ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 1, 1)
    """
    nearby = _nearby_period(np.diff(times_s))
    first = _first_of_train(np.diff(times_s) / nearby)
    times_s, nearby = times_s[first:], nearby[first:]
    kept = [float(times_s[0])]
    missing, false = 0, first
    for time, period, following in zip(times_s[1:], nearby, np.append(times_s[2:], np.inf), strict=True):
        gap = time - kept[-1]
        next_fits_better = abs(following - kept[-1] - period) < abs(gap - period)
        if gap > TOO_EARLY * period and not next_fits_better:
            steps = round(gap / period)
            kept.extend(np.linspace(kept[-1], time, steps + 1)[1:])
            missing += steps - 1
        else:
            false += 1
    return PulseRepair(np.array(kept), missing, false)


def _first_of_train(periods: np.ndarray) -> int:
    """Return the first pulse that the others are counted from; ``periods`` are in those nearby.

    A record may begin with an edge that is none: its filter starts from rest in the middle of a pulse. The next pulse
    comes too early then, and the one after that fits it better than the first.
    """
    first = 0
    while first + 1 < periods.size and periods[first] < TOO_EARLY:
        if _beside_whole(periods[first + 1]) >= _beside_whole(periods[first] + periods[first + 1]):
            break
        first += 1
    return first


def _beside_whole(periods: float) -> float:
    return abs(periods - max(round(periods), 1))


def regular_share(times_s: np.ndarray) -> float:
    """Return the share of periods within half of the median of those nearby, so that a run-up is regular too.

    Parameters
    ----------
    times_s : numpy.ndarray, shape (pulses,)
        Rising; three or more.
    """
    periods = np.diff(times_s)
    return float((np.abs(periods / _nearby_period(periods) - 1.0) < 0.5).mean())


def _nearby_period(periods: np.ndarray) -> np.ndarray:
    """Return the middle one of the periods about each; that of one turn, where half of them may be of several."""
    windows = _windows(periods, 15)
    middle = np.median(windows, axis=1)
    if (np.abs(periods / middle - 1.0) < 0.5).mean() >= CLEARLY_REGULAR:
        return middle
    windows = _windows(periods, 30)
    apart = max(windows.shape[1] // 2, 1)
    some = windows[np.minimum(np.arange(0, periods.size, apart) + apart // 2, periods.size - 1)]
    return np.repeat([_turn_among(one) for one in some], apart)[: periods.size]


def _turn_among(periods: np.ndarray) -> float:
    """Return the length of one turn: of the common periods that of which most others are whole multiples."""
    turns = periods / np.maximum(periods[:, None], 1e-300)
    whole = np.abs(turns - np.clip(np.round(turns), 1.0, MOST_MISSING)) < EVENLY / 2
    alike = np.abs(turns - 1.0) < EVENLY / 2
    best = np.argmax(whole.sum(axis=1) * (alike.mean(axis=1) >= COMMON))
    return float(periods[alike[best]].mean())


def _windows(periods: np.ndarray, half: int) -> np.ndarray:
    """Return the periods about each, up to so many on both sides; shape (periods, about)."""
    half = min(half, (periods.size - 1) // 2)
    return np.lib.stride_tricks.sliding_window_view(np.pad(periods, half, "reflect"), 2 * half + 1)


def without_bounces(times_s: np.ndarray) -> np.ndarray:
    """Return the first edges of clusters where a contact bounces, or noise crosses the middle of a slow edge.

    Unchanged where the train is regular as it is, and where that leaves no regular one.

    Parameters
    ----------
    times_s : numpy.ndarray, shape (pulses,)
        Rising; any number.
    """
    if times_s.size < 3 or regular_share(times_s) >= CLEARLY_REGULAR:
        return times_s
    # Before the first edge the record itself says how long there was none.
    gaps = np.diff(times_s, prepend=0.0)
    first = times_s[gaps > BOUNCE * np.percentile(gaps[1:], LONGEST_PERCENT)]
    fewer = FEWEST_EVEN < first.size < MOST_LEFT * times_s.size
    return first if fewer and regular_share(first) >= CLEARLY_REGULAR else times_s


def comes_unevenly_each_turn(times_s: np.ndarray, pulses_per_revolution: float) -> bool:
    """Return whether pulses are spaced unevenly, and alike in every turn: marks of their own, none false or missing."""
    step = round(pulses_per_revolution)
    if step < 2 or step != pulses_per_revolution or times_s.size < FEWEST_TURNS * step:
        return False
    return not _are_even(np.diff(times_s)) and _are_even(times_s[step:] - times_s[:-step])


def pulse_times(signal: np.ndarray, *, rate_hz: float, several_a_turn: bool = False) -> np.ndarray:
    """Return interpolated rising-edge times in seconds, shape (pulses,); empty where there is no pulse train.

    Of edges that bounce the first of each, unless there are ``several_a_turn``: marks may stand close together.
    """
    if signal.size < 3:
        return np.empty(0)
    low, high = np.percentile(signal, [0.1, 99.9])
    if high == low:
        return np.empty(0)
    noise = float(np.median(np.abs(np.diff(signal)))) / 0.954  # median |difference| of white noise is 0.954 sigma
    times = _rising_edges(signal, low, high) / rate_hz
    times = times if several_a_turn else without_bounces(times)
    return times if noise < QUIET * (high - low) or _come_evenly(times) else np.empty(0)


def _come_evenly(times_s: np.ndarray) -> bool:
    return times_s.size >= FEWEST_EVEN and _are_even(np.diff(times_s))


def _are_even(periods: np.ndarray) -> bool:
    return float((np.abs(periods / _nearby_period(periods) - 1.0) < EVENLY).mean()) >= NEARLY_ALL


def _rising_edges(signal: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return where a signal passes the middle of its range upwards, in samples, interpolated."""
    state = np.zeros(signal.size, dtype=np.int8)
    state[signal > low + 0.65 * (high - low)] = 1
    state[signal < low + 0.35 * (high - low)] = -1
    marks = np.flatnonzero(state)
    rises = marks[1:][(state[marks[1:]] == 1) & (state[marks[:-1]] == -1)]
    middle = 0.5 * (low + high)
    edges = []
    for rise in rises:
        before = rise
        while before > 0 and signal[before - 1] >= middle:
            before -= 1
        step = signal[before] - signal[before - 1] if before > 0 else 0.0
        fraction = (middle - signal[before - 1]) / step if step > 0 else 1.0
        edges.append(before - 1 + fraction)
    return np.array(edges)
