"""Shaft speed: from a tacho, from the vibration alone, or from the vibration near a hint.

Without a tacho the shaft shows as a comb of lines at its multiples. Every candidate speed is scored by how much
better a comb there explains the positions of the lines than chance does; the posterior over all candidates is the
confidence, so that half or twice the speed, and a bearing's own comb, compete openly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...simulators.errors import InvalidValueError
from ..result import SpeedEstimate
from .spectrum import PlainSpectrum, plain_spectrum
from .speed_comb import (
    HARMONIC_SHOWS,
    best_of_clusters,
    candidate_speeds,
    comb_gains,
    comb_scores,
    lost_to_neighbour,
    order_gains,
    refine_speed,
)
from .speed_peaks import Peaks, find_peaks
from .supply_lines import SUPPLY_TOLERANCE, follows_supply, of_supply, without_supply
from .tacho import REGULAR, comes_unevenly_each_turn, pulse_times, regular_share, repaired_pulses

#: Samples by which lengths of turns differ where the speed does: thrice what edges known to half a sample make of them.
EDGES = 4.0
NEAR_HINT = "vibration near the hint"  # how a speed was found
_HINT_SPREAD = 0.035  # standard deviation of true over nominal speed; real files are off by up to 7 %
_CLEARLY_WORSE = 8.0  # log Bayes factor
_SHOWN = 0.7  # log Bayes factor of an order with a line
_CLEAR = 3.0  # of an order with a line that is no chance peak of the noise
_SAID = 0.01  # a hint so near a synchronous speed means it
_FEW = 0.2  # chance of harmonics beside 1X where a machine shows few, as a share of the usual one
_HUM_TRUST = 0.3  # in a speed that only lines of the supply show
_FASTEST_USUAL_HZ = 61.0  # a two-pole motor on a 60 Hz supply
_BEARING_SLIP = 0.016  # rolling elements slip 1-2 % against pure rolling
# Log-normal prior without a hint: most machines turn at 500-5000 rpm.
_TYPICAL_SPEED_HZ, _SPEED_SPREAD = 27.0, 0.6


def speed_from_tacho(
    pulses: np.ndarray, *, rate_hz: float, pulses_per_revolution: float = 1.0
) -> tuple[SpeedEstimate, np.ndarray] | None:
    """Return the speed and the pulse times of a tacho channel, or None when it holds no pulse train.

    Parameters
    ----------
    pulses : numpy.ndarray, shape (samples,)
        Voltage (or any unit) of the tacho.
    rate_hz : float
    pulses_per_revolution : float

    Returns
    -------
    estimate : SpeedEstimate
    times_s : numpy.ndarray, shape (pulses,)
        Rising-edge times from the record's start, interpolated between samples; false pulses left out, missing ones
        filled in.

    Notes
    -----
    Edges are counted where the signal crosses from below 35 % to above 65 % of its 0.1-99.9 % range, so that pulses
    of either sign are found where they last longer than 1/1000 of the time; pulses that go down give the times of
    their ends. A train counts as pulses when there are three or more, and the range is above 20 times the
    sample-to-sample noise, or eight or more come evenly (an encoder that rings behind its filter). Of edges that
    bounce the first of each counts.
    """
    if pulses_per_revolution <= 0:
        raise InvalidValueError(
            f"Pulses per revolution {pulses_per_revolution}; allowed: above 0. Check --pulses-per-revolution."
        )
    signal = np.asarray(pulses, dtype=float)
    times = pulse_times(signal, rate_hz=rate_hz, several_a_turn=pulses_per_revolution > 1)
    if times.size < 3:
        return None
    regular, over = 1.0, round(pulses_per_revolution)
    if not comes_unevenly_each_turn(times, pulses_per_revolution):
        over = 1
        regular = regular_share(times)
        if regular < REGULAR:
            return None
        times = repaired_pulses(times).times_s
    # Uneven marks over whole turns.
    periods = np.diff(times[: (times.size - 1) // over * over + 1])
    mean_period = float(periods.mean())
    speed = 1.0 / (mean_period * pulses_per_revolution)
    spread = float(periods.std() / mean_period / np.sqrt(periods.size)) if periods.size > 1 else 0.05
    uncertainty = max(2 * spread, 1.0 / (rate_hz * (times[-1] - times[0])))
    variation = _variation(times, rate_hz, pulses_per_revolution)
    estimate = SpeedEstimate(
        speed,
        speed * (1 - uncertainty),
        speed * (1 + uncertainty),
        0.99 * regular,
        "tacho",
        variation,
    )
    return estimate, times


def _variation(times: np.ndarray, rate_hz: float, pulses_per_revolution: float) -> float:
    """Return the relative change of speed over whole turns, long enough that half a sample of edge does not count.

    Stripes are never evenly spaced, and an edge is known to a sample at best: periods of single pulses would show both.
    A speed that hunts within that length does not show in its means: fewer turns count where their lengths differ by
    more than edges explain.
    """
    turn = max(round(pulses_per_revolution), 1)
    period = float(np.median(np.diff(times)))
    longest = turn * max(1, int(np.ceil(2000 / (rate_hz * period * turn))))
    longest = min(longest, max(times.size // 4, 1))
    found = _spread(times, longest)
    step = turn
    while step < longest:
        own = _spread(times, step)
        if own * step * period * rate_hz > EDGES:
            found = max(found, own)
        step *= 2
    return found


def _spread(times: np.ndarray, step: int) -> float:
    """Return the relative difference of long and short spans of some pulses: the 95 % and the 5 % quantile."""
    spans = times[step:] - times[:-step]
    return float((np.percentile(spans, 95) - np.percentile(spans, 5)) / spans.mean())


def speed_from_vibration(
    signals: np.ndarray,
    *,
    rate_hz: float,
    hint_hz: float | None = None,
    lowest_hz: float = 4.0,
    highest_hz: float = 500.0,
    known_orders: tuple[float, ...] = (),
    bearing_orders: tuple[float, ...] = (),
    plain: PlainSpectrum | None = None,
) -> SpeedEstimate | None:
    """Return the shaft speed that explains the lines of the spectrum, or None when there is no line at all.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    rate_hz : float
    hint_hz : float or None
        Nominal speed. The search then covers 8 % around it; the hint itself is never returned as a measurement.
    lowest_hz, highest_hz : float
        Range of speeds without a hint.
    known_orders : tuple of float
        Further exact orders where a line is expected, such as a tooth mesh.
    bearing_orders : tuple of float
        Ball-pass orders. A damaged bearing has a comb of its own, often stronger than the shaft's; a shaft speed that
        puts it at one of these orders, within the usual slip, explains that comb too.
    plain : PlainSpectrum or None
        What `plain_spectrum` gives for these signals, where it is known already.

    Examples
    --------
    >>> t = np.arange(40000) / 10000
    >>> x = sum(np.sin(2 * np.pi * 24.7 * n * t) / n for n in (1, 2, 3))
    >>> noise = np.random.default_rng(0).normal(0, 0.5, t.size)
    >>> estimate = speed_from_vibration(x + noise, rate_hz=10000)
    >>> round(estimate.speed_hz, 1)
    24.7
    """
    plain = plain or plain_spectrum(signals, rate_hz=rate_hz)
    width = max(20.0, 0.5 * (hint_hz or 0.0))
    spectrum = plain.with_floor(width)
    resolution = spectrum.resolution_hz
    if hint_hz is not None:
        lowest_hz, highest_hz = 0.92 * hint_hz, 1.08 * hint_hz
    lowest_hz, highest_hz = max(lowest_hz, 3 * resolution), min(highest_hz, 0.4 * rate_hz)
    reach = highest_hz * max((2 + HARMONIC_SHOWS.size, *known_orders))
    channels = [find_peaks(spectrum, index, highest_hz=reach) for index in range(spectrum.amplitude.shape[0])]
    channels = [peaks for peaks in channels if peaks.frequency_hz.size]
    if highest_hz <= lowest_hz or not channels:
        return None
    orders = np.concatenate([np.arange(1.0, HARMONIC_SHOWS.size + 1), known_orders])
    shows = np.concatenate([HARMONIC_SHOWS, np.full(len(known_orders), 0.8)])
    sought = _Sought((lowest_hz, highest_hz), hint_hz, bearing_orders, orders, shows)
    found = _beside_hum(channels, sought)
    if found is None:
        return None
    channels, candidates, scores, best = found.channels, found.candidates_hz, found.scores, found.best_hz
    width = max(0.003 * best, resolution)
    if hint_hz is not None and bearing_orders:
        best, sought = _by_unshared_lines(found, sought, width)
    confidence = _confidence(candidates, scores, best, width, resolution) * found.trust
    if hint_hz is None:
        confidence *= _trust_without_hint(channels, best, orders, sought.shows)
    if hint_hz is None and bearing_orders:
        # Near the speed found, lines that the bearing shares with the shaft would pull: look again without them.
        near_best = speed_from_vibration(
            signals,
            rate_hz=rate_hz,
            hint_hz=best,
            known_orders=known_orders,
            bearing_orders=bearing_orders,
            plain=plain,
        )
        if near_best is not None:
            return replace(near_best, method="vibration", confidence=min(confidence, near_best.confidence))
    speed, interval = refine_speed(lambda hz: sought.comb(channels, hz), best, resolution_hz=resolution)
    method = "vibration" if hint_hz is None else NEAR_HINT
    return SpeedEstimate(speed, speed - interval, speed + interval, confidence, method)


@dataclass(frozen=True, eq=False)
class _Sought:
    """What is looked for: a comb of orders, each with the chance that it shows, at a speed of a range."""

    range_hz: tuple[float, float]
    hint_hz: float | None
    bearing_orders: tuple[float, ...]
    orders: np.ndarray
    shows: np.ndarray

    def found(self, channels: list[Peaks]) -> _Found | None:
        """Return what lines say of the speed; None where no line lets one be a candidate."""
        candidates = candidate_speeds(channels, *self.range_hz)
        if not candidates.size:
            return None
        prior = _log_prior(candidates, self.hint_hz) + _bearing_gains(channels, candidates, self.bearing_orders)
        return _Found(channels, candidates, prior, prior + self.comb(channels, candidates))

    def comb(self, channels: list[Peaks], speeds_hz: np.ndarray) -> np.ndarray:
        """Return the scores of speeds by their combs alone, shape (speeds,)."""
        comb = comb_scores(channels, speeds_hz, orders=self.orders, shows=self.shows)
        if self.hint_hz is not None:
            # A sound machine may show little but 1X; near a hint few other things make such a line.
            few = np.where(self.orders == 1.0, self.shows, _FEW * self.shows)
            comb = np.logaddexp(comb, comb_scores(channels, speeds_hz, orders=self.orders, shows=few)) - np.log(2.0)
        return comb - lost_to_neighbour(channels, speeds_hz)

    def is_hum(self, found: _Found) -> bool:
        """Return whether all lines that the best speed explains are the supply's, and no hint says that it turns so."""
        speed_hz, hint_hz = found.best_hz, self.hint_hz
        if not follows_supply(speed_hz) or (hint_hz is not None and abs(speed_hz / hint_hz - 1) < _SAID):
            return False
        speeds = np.array([speed_hz])
        gains = np.max([order_gains(one, speeds, self.orders, self.shows)[0] for one in found.channels], axis=0)
        return not (gains[~of_supply(self.orders * speed_hz, SUPPLY_TOLERANCE * speed_hz)] > _CLEAR).any()


@dataclass(frozen=True, eq=False)
class _Found:
    """Candidate speeds with their prior and their scores, by the lines of some channels; how far they are trusted."""

    channels: list[Peaks]
    candidates_hz: np.ndarray
    prior: np.ndarray
    scores: np.ndarray
    trust: float = 1.0

    @property
    def best_hz(self) -> float:
        return float(self.candidates_hz[int(np.argmax(self.scores))])


def _beside_hum(channels: list[Peaks], sought: _Sought) -> _Found | None:
    """Return what the lines say of the speed.

    Where all lines that the best speed explains are the supply's, the others are asked, if any of them may be a shaft.
    """
    found = sought.found(channels)
    if found is None or not sought.is_hum(found):
        return found
    beside = [one for one in map(without_supply, channels) if one.frequency_hz.size]
    return (sought.found(beside) if beside else None) or replace(found, trust=_HUM_TRUST)


def _by_unshared_lines(found: _Found, sought: _Sought, width_hz: float) -> tuple[float, _Sought]:
    """Return the speed that lines which no bearing shares with the shaft choose, and by which lines it was chosen.

    Which of the neighbouring speeds it is, shared lines cannot tell. Without them the choice may change, as long as the
    whole comb does not speak clearly against it.
    """
    shared = _shared_with_bearing(sought.orders, sought.bearing_orders)
    unshared = replace(sought, shows=np.where(shared, 0.0, sought.shows))
    candidates, scores = found.candidates_hz, found.scores
    other = float(candidates[int(np.argmax(found.prior + unshared.comb(found.channels, candidates)))])
    if scores[np.abs(candidates - other) < width_hz].max() > scores.max() - _CLEARLY_WORSE:
        return other, unshared
    return found.best_hz, sought


def _log_prior(candidates_hz: np.ndarray, hint_hz: float | None) -> np.ndarray:
    if hint_hz is not None:
        return -0.5 * ((candidates_hz / hint_hz - 1) / _HINT_SPREAD) ** 2
    return -0.5 * (np.log(candidates_hz / _TYPICAL_SPEED_HZ) / _SPEED_SPREAD) ** 2


def _trust_without_hint(channels: list[Peaks], speed_hz: float, orders: np.ndarray, shows: np.ndarray) -> float:
    """Return how far a speed that no hint supports can be trusted: more with more lines, less beyond usual speeds.

    A single line may be anything; and the comb of a bearing is as regular as a shaft's, so a fast one may be either.
    """
    gains = np.max([order_gains(peaks, np.array([speed_hz]), orders, shows)[0] for peaks in channels], axis=0)
    further = max(int(np.count_nonzero(gains > _SHOWN)) - 1, 0)
    if speed_hz > _FASTEST_USUAL_HZ:
        return 0.5 * (1.0 - 0.6 * float(np.exp(-further)))
    return 1.0 - 0.3 * float(np.exp(-further))


def _confidence(
    candidates_hz: np.ndarray, scores: np.ndarray, best_hz: float, width_hz: float, resolution_hz: float
) -> float:
    """Return the share of the evidence within a width of the best speed, against its rivals and against no comb.

    One comb is the best of its kind, not one of many equal guesses: rivals count by their best score each. Scores are
    halved, because neighbouring lines are not independent evidence.
    """
    near = np.abs(candidates_hz - best_hz) < width_hz
    top = scores[near].max()
    rivals = best_of_clusters(candidates_hz[~near], scores[~near], resolution_hz)
    against = float(np.exp(np.minimum(0.5 * (rivals - top), 50.0)).sum()) + float(np.exp(-0.5 * max(top, 0.0)))
    return 1.0 / (1.0 + against)


def _bearing_gains(channels: list[Peaks], speeds_hz: np.ndarray, bearing_orders: tuple[float, ...]) -> np.ndarray:
    """Return what each speed gains by explaining a comb at a ball-pass order, shape (speeds,), at least 0."""
    harmonics = np.arange(1.0, HARMONIC_SHOWS.size + 1)
    gains = np.zeros(speeds_hz.size)
    for order in bearing_orders:
        passes = candidate_speeds(channels, 0.98 * order * speeds_hz.min(), 1.02 * order * speeds_hz.max())
        scores = comb_gains(channels, passes, orders=harmonics, shows=HARMONIC_SHOWS)
        near = np.abs(passes[None, :] / (order * speeds_hz[:, None]) - 1.0) < _BEARING_SLIP
        best = np.where(near, scores[None, :], -np.inf).max(axis=1, initial=-np.inf)
        gains = np.maximum(gains, best - np.log(2.0 * len(bearing_orders)))
    return gains


def _shared_with_bearing(orders: np.ndarray, bearing_orders: tuple[float, ...]) -> np.ndarray:
    """Return which orders lie so near a ball-pass multiple or its 1X sidebands that a line there tells no speed.

    A bearing with BPFO 3.05 would otherwise pass for a shaft turning 1.7 % faster, with 3X, 4X and 6X.
    """
    shared = np.zeros(orders.size, dtype=bool)
    for bearing_order in bearing_orders:
        for sideband in (-1, 0, 1):
            multiple = np.maximum(np.rint((orders - sideband) / bearing_order), 1.0)
            shared |= np.abs(multiple * bearing_order + sideband - orders) < 1.5 * _BEARING_SLIP * orders
    return shared & (orders > 2)
