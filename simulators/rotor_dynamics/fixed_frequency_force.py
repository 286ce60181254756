"""Forces of a frequency fixed in Hz: they follow a supply or a process, not the shaft."""

from __future__ import annotations

import math

import numpy as np

from ..errors import InvalidValueError
from ..law import Direction, InterfaceForce, Law, Timeline


def _fixed_frequency_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    angle = 2 * math.pi * parameters[0] * timeline.time_s
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([c * cos + s * sin for c, s in zip(parameters[1::2], parameters[2::2], strict=True)])


def _fixed_frequency_wave(parameters: np.ndarray, speed_rad_s: float) -> tuple[float, float, np.ndarray]:
    return 0.0, float(parameters[0]), parameters[1::2] - 1j * parameters[2::2]


FIXED_FREQUENCY_FORCE = Law("force of fixed frequency", _fixed_frequency_signals, wave=_fixed_frequency_wave)


def fixed_frequency_force(
    name: str,
    outputs: tuple[Direction, ...],
    *,
    frequency_hz: float,
    cos: tuple[float, ...],
    sin: tuple[float, ...],
) -> InterfaceForce:
    """Return F_i = cos_i cos(2 pi f t) + sin_i sin(2 pi f t) on each output, t from the first recorded sample.

    Harmonic balance at a speed where f is no multiple of the shaft's order says so; simulate in time there.

    Parameters
    ----------
    name : str
    outputs : tuple of Direction
    frequency_hz : float
    cos, sin : tuple of float
        One coefficient for each output, N or N.m.
    """
    if not len(outputs) == len(cos) == len(sin):
        raise InvalidValueError(f"Force {name}: {len(outputs)} outputs, {len(cos)} and {len(sin)} coefficients.")
    pairs = [value for pair in zip(cos, sin, strict=True) for value in pair]
    return InterfaceForce(name, FIXED_FREQUENCY_FORCE, (frequency_hz, *pairs), outputs)
