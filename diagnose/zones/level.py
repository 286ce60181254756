"""The level that a row of a zone table asks for, and what has to be said about it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...datasets.recording import Recording
from ...simulators.errors import RotorwiseError
from ..signal.integrate import averaged_power, rms_from_power
from .measure import gap_share, largest_radius, peak_to_peak
from .table import TABLE_UNIT_TO_SI, ZoneRow

_SLOW_RPM = 600.0
# Usual share of the sampling rate that an anti-aliasing filter leaves untouched.
_RATE_PER_USABLE_HZ = 2.56
_FEWEST_PERIODS = 2.0
_ENOUGH_PERIODS = 8.0


class Refused(RotorwiseError):
    """Why one channel gets no zone; ``assess`` turns it into a sentence."""


@dataclass(frozen=True, eq=False)
class _Spectrum:
    recording: Recording
    index: int
    low_hz: float
    frequency_hz: np.ndarray
    power: np.ndarray


@dataclass(frozen=True, eq=False)
class Machine:
    """What levels and limits depend on besides the signal."""

    speed_rpm: float | None
    speed_is_nominal: bool
    clearance_m: float | None
    _latest: list[_Spectrum] = field(default_factory=list)

    def spectrum(self, recording: Recording, index: int, low_hz: float) -> tuple[np.ndarray, np.ndarray]:
        """Return a channel's averaged power; the latest two are kept, as the rows of a table share them."""
        for kept in self._latest:
            if kept.recording is recording and (kept.index, kept.low_hz) == (index, low_hz):
                return kept.frequency_hz, kept.power
        frequency, power = averaged_power(recording.signals[index], rate_hz=recording.rate_hz, low_hz=low_hz)
        # Two, for the recording and its baseline.
        self._latest[:] = [*self._latest[-1:], _Spectrum(recording, index, low_hz, frequency, power)]
        return frequency, power


def unit_text(row: ZoneRow) -> str:
    """Return the unit that levels and limits of this row are stated in."""
    return "um" if row.unit == "C_min" else row.unit


def quantity_text(row: ZoneRow, machine: Machine) -> str:
    """Return what is measured: quantity, detector and band."""
    if row.band_hz is None:
        return f"shaft {row.quantity}, {row.detector}"
    return f"{row.quantity}, {row.detector}, {_low_edge(row, machine):g}-{row.band_hz[1]:g} Hz"


def _low_edge(row: ZoneRow, machine: Machine) -> float:
    assert row.band_hz is not None
    slow = machine.speed_rpm is not None and machine.speed_rpm < _SLOW_RPM
    return row.slow_low_hz if slow and row.slow_low_hz else row.band_hz[0]


def level(recording: Recording, indices: tuple[int, ...], row: ZoneRow, machine: Machine) -> tuple[float, list[str]]:
    """Return the level in the table's unit and what has to be said about it."""
    scale = TABLE_UNIT_TO_SI[unit_text(row)]
    signals = [recording.signals[index] for index in indices]
    notes = []
    gaps = max(gap_share(signal) for signal in signals)
    if gaps > 0:
        notes.append(f"{100 * gaps:.2g} % of the samples missing and left out")
    if row.detector == "rms":
        value, more = _rms_value(recording, indices[0], row, machine)
    elif row.detector == "peak-to-peak":
        value, usual = peak_to_peak(signals[0], rate_hz=recording.rate_hz)
        unsteady = value > 1.25 * usual
        more = [f"unsteady: largest second stated, usual {usual / scale:.3g} {row.unit}"] if unsteady else []
    else:
        value = _radius_value(recording, indices)
        more = ["zero of both signals taken as the clearance centre"]
    return value / scale, notes + more


def _radius_value(recording: Recording, indices: tuple[int, ...]) -> float:
    if len(indices) != 2:
        name = recording.channels[indices[0]].name
        raise Refused(
            f"{name}: magnetic-bearing zones need an x and a y displacement probe at one location. "
            "Declare directions and locations, or pass --severity-table iso20816-3-shaft."
        )
    return largest_radius(recording.signals[indices[0]], recording.signals[indices[1]])


def _rms_value(recording: Recording, index: int, row: ZoneRow, machine: Machine) -> tuple[float, list[str]]:
    assert row.band_hz is not None
    channel, rate = recording.channels[index], recording.rate_hz
    low, high = _low_edge(row, machine), row.band_hz[1]
    periods = recording.duration_s * low
    if periods < _FEWEST_PERIODS or recording.samples < 16 or rate <= 2 * low:
        raise Refused(
            f"{channel.name}: {recording.duration_s:.3g} s at {rate:g} Hz is too little for a band from "
            f"{low:g} Hz: no severity. Record {_ENOUGH_PERIODS / low:g} s or more at "
            f"{_RATE_PER_USABLE_HZ * high:g} Hz or more."
        )
    notes = []
    if periods < _ENOUGH_PERIODS:
        notes.append(f"only {periods:.2g} periods of the lower band edge {low:g} Hz recorded: value uncertain")
    if rate < _RATE_PER_USABLE_HZ * high:
        usable = rate / _RATE_PER_USABLE_HZ
        notes.append(f"sampling rate {rate:g} Hz shows nothing above about {usable:.3g} Hz: true zone may be worse")
    if row.slow_low_hz and machine.speed_rpm is None:
        notes.append("speed not given: 600 r/min or more assumed; pass --speed if slower")
    frequency, power = machine.spectrum(recording, index, low)
    value = rms_from_power(
        frequency, power, quantity=channel.quantity or "", target=row.quantity, low_hz=low, high_hz=high
    )
    return float(value[0]), notes
