"""Features in SI units, channel by channel: what a severity is estimated from."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..observe import Observation
from ..signal.order_tracking import constant_speed_phase, order_amplitudes

ORDERS = (1, 2, 3)
#: Bands of the velocity's or displacement's rms, in Hz; the first is the one of ISO 20816-3.
BANDS_HZ = ((10.0, 1000.0),)
#: Bands of the rms as recorded, in orders.
ORDER_BANDS = (0.2, 0.8, 3.5, 10.5, 50.0)


def absolute_features(observation: Observation) -> dict[str, float]:
    """Return what a recording shows in SI units.

    Returns
    -------
    dict of str to float
        ``speed_hz``. For every channel: ``CHANNEL.1x_amplitude`` (peak, in the channel's unit) to ``3x``;
        ``CHANNEL.1x_real`` and ``_imaginary``, the same against the tacho pulse, to 3x, NaN without a tacho of one
        pulse a turn; ``CHANNEL.2x_relative_real`` and ``_imaginary``: 2X turned back by twice the phase of 1X, 3X by
        thrice, which needs no tacho; ``CHANNEL.velocity_rms``, 10 to 1000 Hz, m/s (NaN for an unknown unit);
        ``CHANNEL.band_A_B_rms``, rms between orders A and B. Empty without a speed.
    """
    if observation.speed is None or not observation.turning:
        return {}
    values = {"speed_hz": observation.speed_hz}
    recording = observation.recording
    phase = constant_speed_phase(
        samples=recording.samples, rate_hz=recording.rate_hz, speed_hz=observation.line(1.0, channel=0).frequency_hz
    )
    free, _ = order_amplitudes(recording.signals, phase_turns=phase, orders=[float(order) for order in ORDERS])
    for index, channel in enumerate(recording.channels):
        name = channel.name
        for place, order in enumerate(ORDERS):
            values[f"{name}.{order}x_amplitude"] = observation.line(float(order), channel=index).amplitude
            fixed = complex("nan") if observation.order_vectors is None else observation.order_vectors[index, place]
            values[f"{name}.{order}x_real"], values[f"{name}.{order}x_imaginary"] = float(fixed.real), float(fixed.imag)
            if order > 1:
                turned = free[index, place] * np.exp(-1j * order * np.angle(free[index, 0]))
                values[f"{name}.{order}x_relative_real"] = float(turned.real)
                values[f"{name}.{order}x_relative_imaginary"] = float(turned.imag)
        values[f"{name}.velocity_rms"] = _velocity_rms(observation, index)
        values |= {f"{name}.{key}": value for key, value in _order_bands(observation, index).items()}
    return values


def _velocity_rms(now: Observation, channel: int) -> float:
    if now.recording.channels[channel].quantity is None:
        return float("nan")
    frequency = now.spectrum.frequency_hz
    inside = (frequency >= BANDS_HZ[0][0]) & (frequency <= BANDS_HZ[0][1])
    factor = now.velocity_factor(channel, frequency[inside])
    return _rms(now.spectrum.amplitude[channel, inside] * factor, now)


def _order_bands(now: Observation, channel: int) -> dict[str, float]:
    orders = now.spectrum.frequency_hz / now.speed_hz
    found = {}
    for low, high in pairwise(ORDER_BANDS):
        inside = (orders >= low) & (orders < high)
        found[f"band_{low:g}_{high:g}_rms"] = _rms(now.spectrum.amplitude[channel, inside], now)
    return found


def _rms(peaks: np.ndarray, now: Observation) -> float:
    """Return the rms of a band from peak amplitudes; a Hann window spreads a line over 1.5 bins of power."""
    return float(np.sqrt((peaks**2).sum() / 2 / (1.5 * now.spectrum.padding)))
