"""The envelopes of a file: what ``rotorwise envelope`` shows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..datasets.recording import Nameplate
from ..simulators.errors import InvalidValueError
from .envelope_zoom import EnvelopeLine, EnvelopeZoom, Rhythm, zoom_places, zoomed
from .faults.bearing import place_of, rhythms
from .look import Looked, Shaft, at_equal_angles, shaft_of
from .signal.envelope import squared_envelope_spectrum
from .signal.kurtogram import Kurtogram, fast_kurtogram
from .signal.spectrum import Spectrum, peak_near
from .signal.whitening import prewhiten, separate

_FALSE_ALARM = 1e-3
_LINES = 8
_SLIP = 0.02
#: Rhythm of impacts and highest line that are expected where neither bearing nor speed is known.
_USUAL_RHYTHM_HZ = 100.0
_USUAL_ORDER = 6.0  # of the shaft, where no bearing is known
_HARMONICS = 4.5
_MOST_HARMONICS = 12
_SEGMENT_TURNS = 32
#: Of a band, in steps of one over the record's length: in fewer an envelope has no line above its own noise floor.
_LEAST_CELLS = 32


@dataclass(frozen=True, eq=False)
class ChannelEnvelope:
    """One channel: its kurtogram, the band taken, the spectrum there and its significant lines, strongest first.

    ``zooms`` are narrow parts of the spectrum round the harmonics of the defects seen, else round the strongest line.
    """

    channel: int
    kurtogram: Kurtogram
    low_hz: float
    high_hz: float
    spectrum: Spectrum
    lines: tuple[EnvelopeLine, ...]
    zooms: tuple[EnvelopeZoom, ...] = ()


@dataclass(frozen=True, eq=False)
class Envelopes:
    """What the command shows."""

    shaft: Shaft | None
    prepared: str
    channels: tuple[ChannelEnvelope, ...]
    rhythms: tuple[Rhythm, ...]


def measure(
    looked: Looked, *, band_hz: tuple[float, float] | None, prepare: str, range_hz: tuple[float, float] | None = None
) -> Envelopes:
    """Return the envelopes of all channels.

    Raises
    ------
    InvalidValueError
        When the band does not fit the sampling rate or the record is too short.
    """
    shaft = shaft_of(looked, range_hz=range_hz)
    signals, rate_hz = at_equal_angles(looked, shaft)
    if band_hz is not None and band_hz[1] > 0.5 * rate_hz:
        raise InvalidValueError(
            f"Band {band_hz[0]:g}-{band_hz[1]:g} Hz; allowed: up to {0.5 * rate_hz:g} Hz, half the sampling rate."
        )
    if band_hz is not None and (band_hz[1] - band_hz[0]) * looked.recording.duration_s < _LEAST_CELLS:
        raise InvalidValueError(
            f"Band {band_hz[0]:g}-{band_hz[1]:g} Hz; allowed: {_LEAST_CELLS / looked.recording.duration_s:.3g} Hz wide "
            "or wider for a record of this length. An envelope holds no frequency above its band's width."
        )
    known = known_rhythms(looked.recording.nameplate, shaft)
    usual = _USUAL_RHYTHM_HZ if shaft is None else _USUAL_ORDER * shaft.mean_hz
    fastest = max([one.frequency_hz for one in known], default=usual)
    found = []
    for index, row in enumerate(signals):
        ready = _prepared(row, prepare, rate_hz, shaft)
        kurtogram = fast_kurtogram(ready, rate_hz=rate_hz, narrowest_hz=3 * fastest)
        best = kurtogram.best
        own = float(kurtogram.low_hz[best]), float(kurtogram.high_hz[best])
        # A prewhitened signal has no band of its own any more: impacts are spread over all of them.
        low, high = band_hz or ((0.01 * rate_hz, 0.49 * rate_hz) if prepare == "prewhiten" else own)
        spectrum = squared_envelope_spectrum(
            ready,
            rate_hz=rate_hz,
            low_hz=low,
            high_hz=high,
            highest_line_hz=min(_HARMONICS * fastest, high - low),
            floor_width_hz=max(0.0 if shaft is None else shaft.mean_hz, 8.0),
        )
        lines = _lines(spectrum, shaft, known)
        zooms = zoomed(ready, rate_hz, (low, high), zoom_places(lines, known, shaft, spectrum))
        found.append(ChannelEnvelope(index, kurtogram, low, high, spectrum, lines, zooms))
    return Envelopes(shaft, prepare, tuple(found), known)


def _prepared(row: np.ndarray, prepare: str, rate_hz: float, shaft: Shaft | None) -> np.ndarray:
    if prepare == "prewhiten":
        return prewhiten(row)
    if prepare == "random":
        turn = rate_hz / (shaft.mean_hz if shaft is not None else _USUAL_RHYTHM_HZ / _USUAL_ORDER)
        # Lines a turn's frequency apart are kept apart; long segments leave fewer averages.
        segment = int(min(_SEGMENT_TURNS * turn, row.size / 16))
        return separate(row, segment_samples=max(segment, 16))[1]
    return row


def known_rhythms(plate: Nameplate, shaft: Shaft | None) -> tuple[Rhythm, ...]:
    """Return the rhythms that the machine may have, without the shaft's own; empty without a speed."""
    if shaft is None:
        return ()
    return tuple(
        Rhythm(
            f"{one.label} {place_of(bearing)}",
            one.order * shaft.mean_hz,
            None if one.modulator is None else one.modulator * shaft.mean_hz,
            "FTF" if one.label == "2BSF" else "1X",
        )
        for bearing in plate.bearings
        for one in rhythms(bearing)
    )


def _lines(spectrum: Spectrum, shaft: Shaft | None, known: tuple[Rhythm, ...]) -> tuple[EnvelopeLine, ...]:
    """Return the significant lines, strongest first, named."""
    ratio = spectrum.power_ratio[0]
    inner = np.arange(3, ratio.size - 2)
    height = spectrum.amplitude[0]
    is_peak = (height[inner] >= height[inner - 1]) & (height[inner] > height[inner + 1])
    bins = inner[is_peak & (ratio[inner] > np.log(ratio.size / _FALSE_ALARM))]
    places: list[tuple[float, float, float]] = []
    for index in bins[np.argsort(height[bins])[::-1]]:
        place = float(spectrum.frequency_hz[index])
        if any(abs(place - other) < 3 * spectrum.resolution_hz for other, _, _ in places):
            continue
        frequency, depth, _ = peak_near(spectrum, 0, place, tolerance_hz=0.5 * spectrum.resolution_hz)
        places.append((frequency, depth, float(ratio[index])))
        if len(places) == _LINES:
            break
    names = _names([frequency for frequency, _, _ in places], known, shaft, spectrum.resolution_hz)
    return tuple(
        EnvelopeLine(frequency, None if shaft is None else frequency / shaft.mean_hz, depth, power, name)
        for (frequency, depth, power), name in zip(places, names, strict=True)
    )


def _names(places_hz: list[float], known: tuple[Rhythm, ...], shaft: Shaft | None, resolution_hz: float) -> list[str]:
    """Return what the lines are, given highest first: harmonics of the shaft, families of bearing rhythms, or nothing.

    The highest line that a bearing may make takes its whole family with it; the next bearing lives on what is left.
    """
    if shaft is None:
        return [""] * len(places_hz)
    names = [_shaft_name(place, shaft.mean_hz, resolution_hz) for place in places_hz]
    for number, place in enumerate(places_hz):
        if names[number]:
            continue
        found = _rhythm_at(place, known)
        if found is None:
            continue
        for other, other_place in enumerate(places_hz):
            names[other] = names[other] or _family_name(other_place, found, shaft.mean_hz, resolution_hz)
    return names


def _shaft_name(place_hz: float, speed_hz: float, resolution_hz: float) -> str:
    order = round(place_hz / speed_hz)
    near = abs(place_hz - order * speed_hz) < 1.5 * resolution_hz
    return f"{order}X" if near and 1 <= order <= _MOST_HARMONICS else ""


def _rhythm_at(place_hz: float, known: tuple[Rhythm, ...]) -> Rhythm | None:
    """Return the rhythm nearest to a line, as its first or second harmonic, at the frequency that it really has."""
    best, found = _SLIP, None
    for one in known:
        for harmonic in (1, 2):
            error = abs(place_hz / (harmonic * one.frequency_hz) - 1)
            if error < best:
                best, found = error, replace(one, frequency_hz=place_hz / harmonic)
    return found


def _family_name(place_hz: float, one: Rhythm, speed_hz: float, resolution_hz: float) -> str:
    harmonic = round(place_hz / one.frequency_hz)
    near = abs(place_hz - harmonic * one.frequency_hz)
    if 1 <= harmonic <= _MOST_HARMONICS and near < resolution_hz * (1 + 0.5 * harmonic):
        return f"{harmonic} x {one.label}"
    modulators = [(one.modulator, one.modulator_hz)] if one.modulator_hz and one.modulator != "1X" else []
    for name, modulator in [*modulators, ("1X", speed_hz)]:
        for harmonic in (1, 2, 3, 4):
            for side in (-2, -1, 1, 2):
                wanted = harmonic * one.frequency_hz + side * modulator
                if abs(place_hz - wanted) < resolution_hz * (1.5 + 0.5 * harmonic):
                    return f"{harmonic} x {one.label} {'+' if side > 0 else '-'} {abs(side)} x {name}"
    return ""
