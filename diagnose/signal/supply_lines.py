"""Lines of the electric supply: in many records stronger than the shaft's, and as regular a comb.

Multiples of 50 or 60 Hz fit every shaft at 1500, 3000, 1800 or 3600 rpm. Only synchronous machines turn so; whether one
does, its own lines beside the supply's must say, or a hint.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .speed_peaks import Peaks

SUPPLY_HZ = (50.0, 60.0)
#: Grids keep their frequency, and recorders their clock, within this share.
SUPPLY_TOLERANCE = 1e-3
#: Pole pairs of machines that may follow the supply.
POLE_PAIRS = (1, 2, 3, 4)


def of_supply(frequency_hz: np.ndarray, deviation_hz: np.ndarray | float = 0.0) -> np.ndarray:
    """Return which frequencies are multiples of a supply's, within its tolerance and two deviations."""
    frequency = np.asarray(frequency_hz, dtype=float)
    found = np.zeros(frequency.shape, dtype=bool)
    for supply in SUPPLY_HZ:
        multiple = np.maximum(np.rint(frequency / supply), 1.0) * supply
        found |= np.abs(frequency - multiple) < SUPPLY_TOLERANCE * multiple + 2 * np.asarray(deviation_hz)
    return found


def follows_supply(speed_hz: float) -> bool:
    """Return whether a speed is that of a synchronous machine."""
    return any(abs(speed_hz * pairs / supply - 1) < SUPPLY_TOLERANCE for supply in SUPPLY_HZ for pairs in POLE_PAIRS)


def without_supply(peaks: Peaks) -> Peaks:
    """Return the lines that are no multiples of a supply's frequency."""
    kept = ~of_supply(peaks.frequency_hz, peaks.deviation_hz)
    return replace(
        peaks,
        frequency_hz=peaks.frequency_hz[kept],
        deviation_hz=peaks.deviation_hz[kept],
        power_ratio=peaks.power_ratio[kept],
    )
