"""Sideband families found without being told the carrier or the modulator, and the shaft that they belong to.

Every strong line is tried as a carrier, every distance to its neighbours as a spacing. A family counts when lines stand
at both sides at equal distances more often than chance would put them there: each pair found is worth the logarithm of
one over the chance that any two lines of such a crowd lie there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .sidebands import SidebandFamily, find_sidebands
from .spectrum import Spectrum
from .speed_peaks import Peaks, find_peaks

_CARRIERS = 24
_PAIRS = 4
_FALSE_ALARM = 1e-2
_GAP = 0.6  # chance that a sideband within a family is lost in the noise
#: A carrier below this many spacings is a harmonic among harmonics.
_FEWEST_SPACINGS = 4.0
_WEAKEST_CARRIER = 0.5  # over its own first sidebands: below, it is one of them
_SAME = 1.5  # bins


@dataclass(frozen=True)
class BlindFamily:
    """A carrier and its sidebands, found blindly.

    Attributes
    ----------
    spacing_hz, deviation_hz : float
        Distance of the sidebands and its standard deviation.
    family : SidebandFamily
        The carrier, its sidebands with signal-to-noise ratio, and the modulation index.
    log_odds : float
        Natural logarithm of the odds against chance, all families tried considered.
    shaft : str or None
        Name of the modulator whose frequency the spacing repeats, where one does.
    shaft_error : float or None
        Spacing over that frequency, less 1.
    """

    spacing_hz: float
    deviation_hz: float
    family: SidebandFamily
    log_odds: float
    shaft: str | None = None
    shaft_error: float | None = None


def find_families(
    spectrum: Spectrum,
    *,
    channel: int,
    narrowest_hz: float,
    widest_hz: float,
    lowest_hz: float = 0.0,
    highest_hz: float | None = None,
    modulators_hz: Mapping[str, float] | None = None,
    speed_doubt: float = 0.005,
    most: int = 12,
) -> tuple[BlindFamily, ...]:
    """Return the sideband families of one channel, surest first.

    Parameters
    ----------
    spectrum : Spectrum
    channel : int
    narrowest_hz, widest_hz : float
        Spacings looked for.
    lowest_hz, highest_hz : float
        Where carriers are looked for; None goes to the end of the spectrum.
    modulators_hz : mapping of str to float, or None
        Frequencies that may modulate, by name: shafts, cages, the supply.
    speed_doubt : float
        Relative doubt about them.
    most : int
        Families returned.

    Examples
    --------
    >>> from rotorwise.diagnose.signal.spectrum import spectrum_with_floor
    >>> t = np.arange(40000) / 10000
    >>> x = (1 + 0.4 * np.cos(2 * np.pi * 16.7 * t)) * np.cos(2 * np.pi * 767 * t)
    >>> noise = np.random.default_rng(1).normal(0, 0.1, t.size)
    >>> spectrum = spectrum_with_floor(x + noise, rate_hz=10000, floor_width_hz=30)
    >>> found = find_families(
    ...     spectrum, channel=0, narrowest_hz=5, widest_hz=60, modulators_hz={"pinion": 33.3, "wheel": 16.65}
    ... )
    >>> found[0].shaft, round(found[0].spacing_hz, 1), round(found[0].family.modulation_index, 1)
    ('wheel', 16.7, 0.4)
    """
    top = float(spectrum.frequency_hz[-2]) if highest_hz is None else min(highest_hz, float(spectrum.frequency_hz[-2]))
    peaks = find_peaks(spectrum, channel, highest_hz=min(top + _PAIRS * widest_hz, float(spectrum.frequency_hz[-2])))
    if peaks.frequency_hz.size < 3:
        return ()
    allowed = np.flatnonzero((peaks.frequency_hz >= lowest_hz) & (peaks.frequency_hz <= top))
    amplitude = spectrum.amplitude[channel, np.rint(peaks.frequency_hz / spectrum.resolution_hz).astype(int)]
    carriers = allowed[np.argsort(amplitude[allowed])[::-1][:_CARRIERS]]
    known, span = modulators_hz or {}, widest_hz - narrowest_hz
    trials: list[tuple[float, float, float, int]] = []
    tried = 1
    for carrier in carriers:
        spacings, looked_at = _spacings(peaks, amplitude, int(carrier), narrowest_hz, widest_hz)
        tried += looked_at
        for log_odds, spacing, deviation in spacings:
            gain = _known_spacing(spacing, deviation, known, speed_doubt, span)
            trials.append((log_odds + gain, spacing, deviation, int(carrier)))
    price = np.log(tried / _FALSE_ALARM)
    found: list[BlindFamily] = []
    for log_odds, spacing, deviation, carrier in sorted(trials, reverse=True):
        if log_odds < price or len(found) >= most:
            break
        place = float(peaks.frequency_hz[carrier])
        if any(_tells_nothing_new(one, place, spacing, spectrum.resolution_hz) for one in found):
            continue
        family = find_sidebands(spectrum, channel=channel, carrier_hz=place, modulator_hz=spacing, pairs=_PAIRS)
        shaft, error = attributed(spacing, deviation, known, speed_doubt)
        found.append(BlindFamily(spacing, deviation, family, float(log_odds - price), shaft, error))
    return tuple(found)


def _spacings(
    peaks: Peaks, amplitude: np.ndarray, carrier: int, narrowest_hz: float, widest_hz: float
) -> tuple[list[tuple[float, float, float]], int]:
    """Return log odds, spacing and its deviation of every first pair round a carrier, and how many were looked at."""
    place = float(peaks.frequency_hz[carrier])
    widest = min(widest_hz, place / _FEWEST_SPACINGS)
    above = peaks.frequency_hz - place
    candidates = np.flatnonzero((above >= narrowest_hz) & (above <= widest))
    found = []
    for other in candidates:
        spacing = float(above[other])
        mirror = int(np.argmin(np.abs(peaks.frequency_hz - (place - spacing))))
        doubt = 3.0 * float(
            np.hypot(peaks.deviation_hz[other], peaks.deviation_hz[mirror]) + peaks.deviation_hz[carrier]
        )
        if abs(peaks.frequency_hz[mirror] - (place - spacing)) > doubt:
            continue
        if amplitude[carrier] < _WEAKEST_CARRIER * max(amplitude[other], amplitude[mirror]):
            continue
        spacing = 0.5 * float(peaks.frequency_hz[other] - peaks.frequency_hz[mirror])
        deviation = 0.5 * float(np.hypot(peaks.deviation_hz[other], peaks.deviation_hz[mirror]))
        found.append((_log_odds(peaks, place, spacing, deviation), spacing, deviation))
    return found, candidates.size


def _log_odds(peaks: Peaks, place: float, spacing: float, deviation: float) -> float:
    """Return the evidence of all sidebands at multiples of a spacing; gaps within the family speak against it."""
    numbers = np.array([number for number in range(-_PAIRS, _PAIRS + 1) if number])
    numbers = numbers[(place + numbers * spacing > 0) & (place + numbers * spacing < peaks.span_hz)]
    wanted = place + numbers * spacing
    reach = (_PAIRS + 1) * spacing
    crowd = np.searchsorted(peaks.frequency_hz, place + reach) - np.searchsorted(peaks.frequency_hz, place - reach)
    density = max(crowd, 1) / (2 * reach)
    right = np.clip(np.searchsorted(peaks.frequency_hz, wanted), 1, peaks.frequency_hz.size - 1)
    nearest = np.where(
        np.abs(peaks.frequency_hz[right] - wanted) < np.abs(peaks.frequency_hz[right - 1] - wanted), right, right - 1
    )
    doubt = 3.0 * np.hypot(peaks.deviation_hz[nearest], np.abs(numbers) * deviation)
    chance = np.clip(2 * doubt * density, 1e-4, 0.9)
    hit = np.abs(peaks.frequency_hz[nearest] - wanted) < doubt
    outermost = int(np.abs(numbers)[hit].max(initial=1))
    lost = ~hit & (np.abs(numbers) < outermost)
    # The first pair chose the spacing: one of its two lines is no evidence.
    return float(-np.log(chance[hit]).sum() + np.log(_GAP) * lost.sum() - np.max(-np.log(chance)))


def _tells_nothing_new(one: BlindFamily, place: float, spacing: float, resolution_hz: float) -> bool:
    """Return whether a family is an earlier one seen from one of its sidebands, or at a multiple of its spacing."""
    steps = (place - one.family.carrier.frequency_hz) / one.spacing_hz
    near = abs(steps - round(steps)) * one.spacing_hz < _SAME * resolution_hz * max(abs(steps), 1.0)
    multiple = spacing / one.spacing_hz
    same = abs(multiple - round(multiple)) * one.spacing_hz < _SAME * resolution_hz and round(multiple) >= 1
    return bool(near and abs(steps) < _PAIRS + 0.5 and same)


def _known_spacing(
    spacing: float, deviation: float, modulators_hz: Mapping[str, float], doubt: float, span_hz: float
) -> float:
    """Return what a spacing gains by being that of a known modulator: one over the chance to meet any."""
    if attributed(spacing, deviation, modulators_hz, doubt)[0] is None:
        return 0.0
    covered = sum(6.0 * float(np.hypot(deviation, doubt * frequency)) for frequency in modulators_hz.values())
    return max(-float(np.log(covered / span_hz)), 0.0)


def attributed(
    spacing: float, deviation: float, modulators_hz: Mapping[str, float], doubt: float
) -> tuple[str | None, float | None]:
    """Return the modulator nearest to a spacing, if it lies within three deviations, and the relative error."""
    best: tuple[float, str | None, float | None] = (3.0, None, None)
    for name, frequency in modulators_hz.items():
        distance = abs(spacing - frequency) / max(float(np.hypot(deviation, doubt * frequency)), 1e-300)
        if distance < best[0]:
            best = (distance, name, spacing / frequency - 1.0)
    return best[1], best[2]
