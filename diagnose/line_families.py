"""The sideband families of a file: what ``rotorwise sidebands`` shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..datasets.recording import Nameplate
from ..simulators.errors import InvalidValueError
from .faults.bearing import place_of
from .look import Looked, Shaft, at_equal_angles, shaft_of
from .signal.blind_sidebands import BlindFamily, attributed, find_families
from .signal.cepstrum import Cepstrum, Spacing, band_cepstrum, line_spacing
from .signal.sidebands import find_sidebands
from .signal.spectrum import Spectrum, spectrum_with_floor
from .signal.zoom import zoom_spectrum

_SLOWEST_HZ, _WIDEST_HZ = 3.0, 120.0
_WIDEST_ORDER = 6.0
_LEAST_RATIO = 16.0  # of a cepstral peak: noise reaches it in one of a hundred records
_DOUBT = 2e-3
_ZOOMS, _ZOOM_POINTS = 4, 4000
_LEAST_CELLS = 4.0  # a Hann window's line is four bins wide: nearer lines are not told apart


@dataclass(frozen=True, eq=False)
class ChannelFamilies:
    """One channel: spectrum, families found, cepstrum of the band, and its spacing if it has one.

    ``zooms`` holds frequencies and amplitudes round the carriers of the surest families, finer than the spectrum.
    """

    channel: int
    spectrum: Spectrum
    families: tuple[BlindFamily, ...]
    cepstrum: Cepstrum | None
    spacing: Spacing | None
    zooms: tuple[tuple[np.ndarray, np.ndarray], ...] = ()


@dataclass(frozen=True, eq=False)
class LineFamilies:
    """What the command shows; modulators by name with their frequency in Hz."""

    shaft: Shaft | None
    modulators_hz: dict[str, float]
    channels: tuple[ChannelFamilies, ...]


def measure(
    looked: Looked, *, asked: tuple[float, float] | None, range_hz: tuple[float, float] | None = None
) -> LineFamilies:
    """Return the sideband families of all channels.

    Parameters
    ----------
    asked : (carrier, spacing) in Hz, or None
        None looks for families blindly.
    """
    shaft = shaft_of(looked, range_hz=range_hz)
    signals, rate_hz = at_equal_angles(looked, shaft)
    slow = 0.0 if shaft is None else shaft.mean_hz
    spectrum = spectrum_with_floor(signals, rate_hz=rate_hz, floor_width_hz=max(slow, 20.0))
    known = modulators(looked.recording.nameplate, shaft)
    narrowest = max(min([_SLOWEST_HZ, *(0.8 * one for one in known.values())]), 6 * spectrum.resolution_hz)
    widest = max(_WIDEST_HZ if shaft is None else _WIDEST_ORDER * slow, 4 * narrowest)
    doubt = _DOUBT if shaft is None else max(_DOUBT * (shaft.method != "tacho"), 5e-4)
    found = []
    for index, row in enumerate(signals):
        if asked is not None:
            families = (_asked_family(spectrum, index, asked, rate_hz, known),)
        else:
            families = find_families(
                spectrum,
                channel=index,
                narrowest_hz=narrowest,
                widest_hz=widest,
                modulators_hz=known,
                speed_doubt=doubt,
            )
        cepstrum = spacing = None
        try:
            cepstrum = band_cepstrum(
                row, rate_hz=rate_hz, low_hz=2 * widest, high_hz=0.4 * rate_hz, narrowest_hz=narrowest
            )
            spacing = line_spacing(cepstrum, narrowest_hz=narrowest, widest_hz=widest)
        except InvalidValueError:
            pass  # a record too short for a cepstrum still has its families
        if spacing is not None and spacing.power_ratio < _LEAST_RATIO:
            spacing = None
        zooms = tuple(_zoom(row, family, rate_hz) for family in families[:_ZOOMS])
        found.append(ChannelFamilies(index, spectrum, families, cepstrum, spacing, zooms))
    return LineFamilies(shaft, known, tuple(found))


def _zoom(row: np.ndarray, family: BlindFamily, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectrum from five sidebands below a carrier to five above it, ten points to a bin at most."""
    carrier, reach = family.family.carrier.frequency_hz, 5.0 * family.spacing_hz
    low, high = max(carrier - reach, 0.0), min(carrier + reach, 0.5 * rate_hz)
    lines = int(min(max(10 * (high - low) * row.size / rate_hz, 200), _ZOOM_POINTS))
    frequency, amplitude = zoom_spectrum(row, rate_hz=rate_hz, low_hz=low, high_hz=high, lines=lines)
    return frequency, amplitude[0]


def _asked_family(
    spectrum: Spectrum, channel: int, asked: tuple[float, float], rate_hz: float, known: dict[str, float]
) -> BlindFamily:
    carrier, spacing = asked
    if carrier >= 0.5 * rate_hz:
        raise InvalidValueError(f"Carrier {carrier:g} Hz; allowed: below {0.5 * rate_hz:g} Hz, half the sampling rate.")
    narrowest = _LEAST_CELLS * spectrum.resolution_hz
    if spacing < narrowest:
        raise InvalidValueError(
            f"Spacing {spacing:g} Hz; allowed: {narrowest:.3g} Hz or more, else carrier and sidebands are one line in "
            "the spectrum of this record. Take a longer record."
        )
    family = find_sidebands(spectrum, channel=channel, carrier_hz=carrier, modulator_hz=spacing, pairs=4)
    deviation = 0.5 * spectrum.resolution_hz
    return BlindFamily(spacing, deviation, family, 0.0, *attributed(spacing, deviation, known, _DOUBT))


def modulators(plate: Nameplate, shaft: Shaft | None) -> dict[str, float]:
    """Return what may modulate, by name, in Hz; empty without a speed."""
    if shaft is None:
        return {}
    found = {"shaft": shaft.mean_hz}
    for gear in plate.gears:
        for ratio, teeth in ((gear.driver_ratio, gear.driver_teeth), (gear.driven_ratio, gear.driven_teeth)):
            if ratio is not None and all(abs(ratio * shaft.mean_hz / one - 1) > 1e-6 for one in found.values()):
                found[f"{teeth}-tooth shaft"] = ratio * shaft.mean_hz
    for bearing in plate.bearings:
        order = bearing.geometry.defect_orders().cage * bearing.shaft_ratio
        found[f"cage {place_of(bearing)}"] = order * shaft.mean_hz
    if plate.line_frequency_hz is not None:
        found["2 x line"] = 2 * plate.line_frequency_hz
    return found
