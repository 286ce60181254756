"""Vibration signals with a known truth, from closed forms: shaft lines, repeated impacts, noise.

Not a machine model: it makes the signal that a fault is known to make, for demonstrations and tests. Impacts follow
P. D. McFadden and J. D. Smith, J. Sound Vib. 96 (1984) 69, with the random slip of J. Antoni and R. B. Randall,
J. Vib. Acoust. 124 (2002) 165.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .errors import InvalidValueError


@dataclass(frozen=True)
class ImpactTrain:
    """Impacts that ring a resonance at a rate tied to the shaft.

    Parameters
    ----------
    order : float
        Impacts a turn, for example BPFO.
    amplitude : float
        Peak of one ringing impact, in the signal's unit.
    resonance_hz, damping_ratio : float
        What each impact rings.
    slip : float
        Standard deviation of the interval over the interval (0.01 for rolling elements, 0 for gear teeth).
    modulation_order, modulation_depth : float
        The impacts grow and shrink by ``1 + depth cos`` at this order (1 for an inner race in the load zone).
    """

    order: float
    amplitude: float
    resonance_hz: float
    damping_ratio: float = 0.05
    slip: float = 0.01
    modulation_order: float = 0.0
    modulation_depth: float = 0.0


def synthetic_vibration(
    *,
    duration_s: float,
    rate_hz: float,
    speed_hz: float,
    seed: int,
    shaft_lines: Mapping[float, float] | None = None,
    impacts: tuple[ImpactTrain, ...] = (),
    noise_rms: float = 0.0,
) -> np.ndarray:
    """Return one channel, shape (samples,).

    Parameters
    ----------
    duration_s, rate_hz, speed_hz : float
    seed : int
        For line phases, slip and noise.
    shaft_lines : mapping of float to float
        Order to peak amplitude.
    impacts : tuple of ImpactTrain
    noise_rms : float
        White noise.

    Examples
    --------
    >>> wave = synthetic_vibration(
    ...     duration_s=1.0, rate_hz=5000.0, speed_hz=25.0, seed=1, shaft_lines={1: 2.0}, noise_rms=0.1
    ... )
    >>> wave.shape, round(float(wave.std()), 1)
    ((5000,), 1.4)
    """
    samples = int(duration_s * rate_hz)
    if samples < 1 or speed_hz <= 0:
        raise InvalidValueError(
            f"{duration_s} s at {rate_hz} Hz and {speed_hz} turns a second; allowed: one sample or more, speed above 0."
        )
    generator = np.random.default_rng(seed)
    time = np.arange(samples) / rate_hz
    signal = generator.normal(0.0, noise_rms, samples) if noise_rms > 0 else np.zeros(samples)
    for order, amplitude in (shaft_lines or {}).items():
        signal += amplitude * np.cos(2 * np.pi * (order * speed_hz * time + generator.uniform()))
    for train in impacts:
        signal += _ringing(train, time, rate_hz, speed_hz, generator)
    return signal


def _ringing(
    train: ImpactTrain, time: np.ndarray, rate_hz: float, speed_hz: float, generator: np.random.Generator
) -> np.ndarray:
    period = 1.0 / (train.order * speed_hz)
    count = int(time[-1] / period) + 2
    strikes = np.cumsum(period * (1 + train.slip * generator.normal(size=count))) + period * (generator.uniform() - 1)
    strikes = strikes[(strikes >= 0) & (strikes < time[-1])]
    size = 1 + train.modulation_depth * np.cos(2 * np.pi * train.modulation_order * speed_hz * strikes)
    omega = 2 * np.pi * train.resonance_hz
    decay = train.damping_ratio * omega
    length = int(min(time.size, np.ceil(8 / decay * rate_hz)))
    signal = np.zeros(time.size + length)
    for strike, strength in zip(strikes, size, strict=True):
        first = int(np.ceil(strike * rate_hz))
        since = (first + np.arange(length)) / rate_hz - strike
        signal[first : first + length] += train.amplitude * strength * np.exp(-decay * since) * np.sin(omega * since)
    return signal[: time.size]
