"""How the shaft's speed wanders by less than a tacho shows: 1X of all channels then moves in phase, together.

An edge of the tacho is known to a part of a sample; the phase of 1X, in a band of a few hertz, is known a hundred times
better. A wandering shaft moves it alike at every channel and hardly moves its size. A line close to 1X (mains hum, a
load that fluctuates) moves phase and size alike, and differently from channel to channel; so does noise.
"""

from __future__ import annotations

import numpy as np

from ...datasets.recording import Recording
from .observe import has_tacho, turns_of

#: Half width of the band about 1X, Hz and as a share of the speed.
BAND_HZ, BAND_SHARE = 3.2, 0.4
#: Fewest lengths of the window in a record.
FEWEST_WINDOWS = 3.0
#: The phase moves so many times as much as the size, in the middle of the channels, and with this correlation.
MORE_THAN_SIZE, ALIKE = 2.5, 0.9
#: Quantities that are no vibration.
OTHERS = ("tacho", "rotational_speed", "angle")


def phase_wander(recording: Recording) -> tuple[float, bool]:
    """Return the relative change of speed (standard deviation) that the phase of 1X would be, and whether it is one.

    Against a tacho with one pulse a turn only, else 0. Changes that the tacho itself follows are not in it.
    """
    rows = [i for i, channel in enumerate(recording.channels) if channel.quantity not in OTHERS]
    if not rows or not has_tacho(recording):
        return 0.0, False
    signals = recording.signals[rows]
    turns = turns_of(recording, signals)
    speed_hz = float((turns[-1] - turns[0]) / (turns.size - 1) * recording.rate_hz)
    half = round(recording.rate_hz / min(BAND_HZ, BAND_SHARE * speed_hz))
    if turns.size < FEWEST_WINDOWS * (2 * half + 1):
        return 0.0, False
    moving = _first_order(signals, turns, half)
    phase, size = np.unwrap(np.angle(moving), axis=1), np.abs(moving)
    time = np.arange(phase.shape[1]) / recording.rate_hz
    phase = np.stack([own - np.polyval(np.polyfit(time, own, 1), time) for own in phase])
    more = phase.std(axis=1) / np.maximum(size.std(axis=1), 1e-12)
    change = float(np.median(np.gradient(phase, time, axis=1).std(axis=1))) / (2 * np.pi * speed_hz)
    return change, bool(np.median(more) > MORE_THAN_SIZE and _likeness(phase) > ALIKE)


def _first_order(signals: np.ndarray, turns: np.ndarray, half: int) -> np.ndarray:
    """Return 1X as it moves, over its mean, complex (channels, samples less a window)."""
    from scipy.signal import fftconvolve

    finite = np.where(np.isfinite(signals), signals, 0.0)
    window = np.hanning(2 * half + 1)
    turned = (finite - finite.mean(axis=1, keepdims=True)) * np.exp(-2j * np.pi * turns)
    moving = fftconvolve(turned, (window / window.sum())[None, :], mode="valid", axes=1)
    mean = moving.mean(axis=1, keepdims=True)
    return moving / np.where(np.abs(mean) > 0, mean, 1.0)


def _likeness(phase: np.ndarray) -> float:
    """Return the median correlation of the channels' phases with the median of all; 1 for a single channel."""
    if len(phase) < 2:
        return 1.0
    common = np.median(phase, axis=0)
    spread = phase.std(axis=1) * common.std()
    return float(np.median((phase * common).mean(axis=1) / np.maximum(spread, 1e-300)))
