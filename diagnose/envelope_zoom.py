"""Narrow parts of a squared envelope spectrum, on a finer grid: a defect's lines with what modulates them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .signal.envelope import squared_envelope
from .signal.spectrum import Spectrum
from .signal.zoom import zoom_spectrum

if TYPE_CHECKING:
    from .look import Shaft

_HARMONICS = (1, 2, 3)
_SIDES = (-2, -1, 0, 1, 2)
_REACH = 2.6  # distances of the sidebands to each side, so that the second one stands free
_LEAST_BINS = 20  # of the record, to each side
_MOST = 9  # parts of one channel
_POINTS_A_BIN, _FEWEST_POINTS, _MOST_POINTS = 10, 200, 4000


@dataclass(frozen=True)
class EnvelopeLine:
    """A line of a squared envelope spectrum.

    Attributes
    ----------
    frequency_hz : float
    order : float or None
        Of the shaft, where its speed is known.
    depth : float
        Height over the mean squared envelope.
    power_ratio : float
        Power over mean noise power.
    name : str
        What has this frequency, or empty.
    """

    frequency_hz: float
    order: float | None
    depth: float
    power_ratio: float
    name: str


@dataclass(frozen=True)
class Rhythm:
    """A rhythm that a bearing defect may have, and what modulates it, in Hz."""

    label: str
    frequency_hz: float
    modulator_hz: float | None
    modulator: str


@dataclass(frozen=True)
class ZoomPlace:
    """A part of the spectrum to look at: its name, its limits in Hz, and where lines are expected, by name."""

    name: str
    low_hz: float
    high_hz: float
    expected: tuple[tuple[str, float], ...]


@dataclass(frozen=True, eq=False)
class EnvelopeZoom:
    """A part of a squared envelope spectrum.

    Attributes
    ----------
    place : ZoomPlace
    frequency_hz, depth : numpy.ndarray, shape (points,)
        A line has its height over the mean squared envelope at its own frequency, on a bin of the record or not.
    """

    place: ZoomPlace
    frequency_hz: np.ndarray
    depth: np.ndarray


def zoom_places(
    lines: tuple[EnvelopeLine, ...], known: tuple[Rhythm, ...], shaft: Shaft | None, spectrum: Spectrum
) -> tuple[ZoomPlace, ...]:
    """Return the parts worth a look: three harmonics of every defect that a line was named after, else one line.

    Parameters
    ----------
    lines : tuple of EnvelopeLine
        Strongest first.
    known : tuple of Rhythm
    shaft : Shaft or None
    spectrum : Spectrum
        Whose lines these are.
    """
    least, highest = _LEAST_BINS * spectrum.resolution_hz, float(spectrum.frequency_hz[-1])
    found = []
    for rhythm in known:
        own = [line for line in lines if f" x {rhythm.label}" in line.name]
        if own:
            found += _of_rhythm(rhythm, _frequency(rhythm, own), shaft, least, highest)
    if not found and lines:
        place = lines[0].frequency_hz
        reach = max(least, 0.0 if shaft is None else _REACH * shaft.mean_hz)
        label = lines[0].name or f"{place:.2f} Hz"
        found = [ZoomPlace(label, max(place - reach, 0.0), min(place + reach, highest), ())]
    return tuple(found[:_MOST])


def _frequency(rhythm: Rhythm, own: list[EnvelopeLine]) -> float:
    """Return the frequency that a defect really has: that of its strongest harmonic, else of the kinematics."""
    for line in own:
        count, _, name = line.name.partition(" x ")
        if name == rhythm.label:
            return line.frequency_hz / int(count)
    return rhythm.frequency_hz


def _of_rhythm(
    rhythm: Rhythm, frequency_hz: float, shaft: Shaft | None, least_hz: float, highest_hz: float
) -> list[ZoomPlace]:
    """Return a part round each harmonic of a defect that the spectrum holds, with its sidebands."""
    spacing, modulator = (rhythm.modulator_hz, rhythm.modulator) if rhythm.modulator_hz else (None, "1X")
    if spacing is None:
        spacing = 0.0 if shaft is None else shaft.mean_hz
    reach = max(_REACH * spacing, least_hz)
    short = rhythm.label.split()[0]
    found = []
    for harmonic in _HARMONICS:
        middle = harmonic * frequency_hz
        low, high = max(middle - reach, 0.0), min(middle + reach, highest_hz)
        if middle >= highest_hz:
            break
        names = ((f"{harmonic} x {short}{_side(side, modulator)}", middle + side * spacing) for side in _SIDES)
        inside = tuple((name, place) for name, place in names if low < place < high)
        found.append(ZoomPlace(f"{harmonic} x {rhythm.label}", low, high, inside))
    return found


def _side(side: int, modulator: str) -> str:
    return "" if not side else f" {'+' if side > 0 else '-'} {abs(side)} x {modulator}"


def zoomed(
    signal: np.ndarray, rate_hz: float, band_hz: tuple[float, float], places: tuple[ZoomPlace, ...]
) -> tuple[EnvelopeZoom, ...]:
    """Return parts of the squared envelope spectrum of one channel in a band.

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
    rate_hz : float
    band_hz : (float, float)
    places : tuple of ZoomPlace
    """
    if not places:
        return ()
    power, slow_hz = squared_envelope(signal, rate_hz=rate_hz, low_hz=band_hz[0], high_hz=band_hz[1])
    found = []
    for place in places:
        low, high = place.low_hz, min(place.high_hz, 0.5 * slow_hz)
        if high <= low:
            continue
        wanted = _POINTS_A_BIN * (high - low) * power.size / slow_hz
        points = int(min(max(wanted, _FEWEST_POINTS), _MOST_POINTS))
        frequency, depth = zoom_spectrum(power, rate_hz=slow_hz, low_hz=low, high_hz=high, lines=points)
        found.append(EnvelopeZoom(place, frequency, depth[0]))
    return tuple(found)
