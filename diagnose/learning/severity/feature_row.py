"""What a severity is estimated from: shaft lines, band levels and bearing rhythms of named probes, in SI units.

Amplitudes are logarithms, since a fault's lines grow as a power of its size. A line below its noise is given the
noise's size and a phase of no weight, so that a record without the line says "at most this" and not a random number.
Phases are relative to 1X of the first probe: they need no tacho.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ....datasets.recording import Recording
from ....simulators.errors import InvalidValueError
from ...gap.line_noise import order_amplitudes_with_noise
from ...gap.observe import turns_of
from ...signal.envelope import squared_envelope_spectrum
from ...signal.integrate import averaged_power, rms_from_power

ORDERS = np.array([1.0, 2.0, 3.0])
#: Edges in Hz of the bands whose rms is taken as recorded: from shaft lines up to a piezo-electric sensor's resonance.
BAND_EDGES_HZ = (100.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0)
#: Bands of the envelopes; each holds several multiples of the ball-pass frequencies.
ENVELOPE_BANDS_HZ = ((500.0, 2000.0), (2000.0, 8000.0))
#: Share by which rolling elements may lag behind pure rolling.
SLIP = 0.035
#: Multiples of a ball-pass order that are looked for in the envelope.
RHYTHM_HARMONICS = 3
#: Band of ISO 20816-3.
VELOCITY_BAND_HZ = (10.0, 1000.0)
_LEAST = 1e-30


@dataclass(frozen=True, eq=False)
class ShaftLines:
    """Lines of a record at 1X, 2X and 3X.

    Attributes
    ----------
    probes : tuple of str
    speed_rpm : float
    amplitudes, noise : ndarray (probes, orders)
        Complex amplitudes against the tacho, or the record's start without one; standard deviation of their real part.
    """

    probes: tuple[str, ...]
    speed_rpm: float
    amplitudes: np.ndarray
    noise: np.ndarray


def shaft_lines(recording: Recording, *, probes: Sequence[str]) -> ShaftLines:
    """Return the shaft lines of some channels of a recording at steady speed.

    Parameters
    ----------
    recording : Recording
        Channels in SI units. With a tacho of one pulse a turn, else the speed is that of its lines.
    probes : sequence of str
        Names of the channels.

    Raises
    ------
    InvalidValueError
        For a missing probe, an unknown unit, or a record without a speed or with too few turns.
    """
    rows = [_place(recording, name) for name in probes]
    signals = recording.signals[rows]
    turns = turns_of(recording, signals)
    speed_hz = float((turns[-1] - turns[0]) / (recording.samples - 1) * recording.rate_hz)
    return ShaftLines(tuple(probes), 60 * speed_hz, *order_amplitudes_with_noise(signals, turns=turns, orders=ORDERS))


def feature_row(recording: Recording, lines: ShaftLines) -> dict[str, float]:
    """Return the features of a recording.

    Parameters
    ----------
    recording : Recording
    lines : ShaftLines
        Of that recording; phases are relative to the first probe.

    Returns
    -------
    dict of str to float
        ``speed_rpm``; for every probe P and order n = 1, 2, 3 ``P.nx`` (log10 of the peak amplitude in SI units, its
        noise added as power) and ``P.nx_cos``, ``P.nx_sin`` (phase against n times the phase of 1X at the first
        probe, times amplitude^2 / (amplitude^2 + noise^2)); for acceleration and velocity ``P.velocity`` (log10 of
        the rms in m/s, 10 to 1000 Hz); for acceleration ``P.band_A_B`` (log10 of the rms from A to B Hz); where
        bearings are known ``P.outer_A_B`` and ``P.inner_A_B`` (log10 of the squared envelope's lines at the race's
        order, over its mean).
    """
    values = {"speed_rpm": lines.speed_rpm, **_lines(lines.probes, lines.amplitudes, lines.noise)}
    for name in lines.probes:
        row = _place(recording, name)
        quantity = recording.channels[row].quantity
        if quantity in ("acceleration", "velocity"):
            values |= _levels(name, recording.signals[row], recording.rate_hz, str(quantity))
        if quantity == "acceleration":
            values |= _rhythms(name, recording, row, lines.speed_rpm / 60)
    return values


def _place(recording: Recording, name: str) -> int:
    names = [channel.name for channel in recording.channels]
    if name not in names:
        raise InvalidValueError(
            f"No channel {name!r}; the recording has {', '.join(names)}. Give channels the names of the model's probes "
            "(--channel-name, or names in recording.toml)."
        )
    place = names.index(name)
    if recording.channels[place].unit is None:
        raise InvalidValueError(f"Unit of {name} unknown: no severity can be estimated. Pass --unit or --sensitivity.")
    return place


def _lines(probes: Sequence[str], amplitudes: np.ndarray, noise: np.ndarray) -> dict[str, float]:
    power, noise_power = np.abs(amplitudes) ** 2, 2 * noise**2
    size = np.log10(np.sqrt(power + noise_power) + _LEAST)
    turned = amplitudes * np.exp(-1j * ORDERS * np.angle(amplitudes[0, 0]))
    phase = turned / (np.abs(turned) + _LEAST) * power / (power + noise_power + _LEAST)
    values = {}
    for i, probe in enumerate(probes):
        for k, order in enumerate(ORDERS):
            values[f"{probe}.{order:g}x"] = float(size[i, k])
            if (i, k) != (0, 0):
                values[f"{probe}.{order:g}x_cos"] = float(phase[i, k].real)
                values[f"{probe}.{order:g}x_sin"] = float(phase[i, k].imag)
    return values


def _levels(name: str, signal: np.ndarray, rate_hz: float, quantity: str) -> dict[str, float]:
    low, high = VELOCITY_BAND_HZ
    frequency, power = averaged_power(signal, rate_hz=rate_hz, low_hz=low)
    rms = rms_from_power(frequency, power, quantity=quantity, target="velocity", low_hz=low, high_hz=high)
    values = {f"{name}.velocity": float(np.log10(rms[0] + _LEAST))}
    if quantity == "acceleration":
        energy = np.cumsum(np.ravel(power))
        for lower, upper in pairwise(BAND_EDGES_HZ):
            if upper <= 0.5 * rate_hz:
                first, last = np.searchsorted(frequency, [lower, upper])
                inside = float(energy[last - 1] - energy[first - 1])
                values[f"{name}.band_{lower:g}_{upper:g}"] = 0.5 * float(np.log10(max(inside, 0.0) + _LEAST))
    return values


def _rhythms(name: str, recording: Recording, row: int, speed_hz: float) -> dict[str, float]:
    """Return the lines of the squared envelope at the races' orders of the first bearing; the others share them."""
    if not recording.nameplate.bearings:
        return {}
    bearing = recording.nameplate.bearings[0]
    orders = bearing.geometry.defect_orders()
    values = {}
    for low, high in ENVELOPE_BANDS_HZ:
        if high > 0.45 * recording.rate_hz:
            continue
        fastest = RHYTHM_HARMONICS * orders.inner_race * bearing.shaft_ratio * speed_hz * (1 + SLIP)
        spectrum = squared_envelope_spectrum(
            recording.signals[row],
            rate_hz=recording.rate_hz,
            low_hz=low,
            high_hz=high,
            highest_line_hz=1.1 * fastest,
            floor_width_hz=max(speed_hz, 8.0),
        )
        for race, order in (("outer", orders.outer_race), ("inner", orders.inner_race)):
            depth = 0.0
            for harmonic in range(1, RHYTHM_HARMONICS + 1):
                middle = harmonic * order * bearing.shaft_ratio * speed_hz
                near = np.abs(spectrum.frequency_hz - middle) <= SLIP * middle
                depth += float((spectrum.amplitude[0, near] ** 2).max(initial=0.0))
            values[f"{name}.{race}_{low:g}_{high:g}"] = 0.5 * float(np.log10(depth + _LEAST))
    return values
