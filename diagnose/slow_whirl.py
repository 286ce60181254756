"""Which way the shaft whirls below its speed: an oil film drives it round forward, a stop throws it back."""

from __future__ import annotations

import numpy as np

from .observe import Observation
from .probe_pair import probe_pair
from .signal.orbit import full_spectrum

_LOW, _HIGH = 0.3, 0.6  # orders


def slow_whirl(now: Observation) -> float | None:
    """Return the whirl of the strongest line from 0.3X to 0.6X, forward less backward radius over their sum.

    None without two displacement probes at right angles, or where no line there stands out of the noise.

    Parameters
    ----------
    now : Observation
        With a speed.
    """
    pair = probe_pair(now.recording.channels)
    if pair is None or now.speed is None:
        return None
    middle, reach = 0.5 * (_LOW + _HIGH) * now.speed_hz, 0.5 * (_HIGH - _LOW) * now.speed_hz
    lines = [now.line_at(middle, channel=one, name="slow", tolerance_hz=reach) for one in pair]
    line = max(lines, key=lambda one: one.amplitude)
    if not now.is_significant(line):
        return None
    x, y = (now.recording.signals[one] for one in pair)
    found = full_spectrum(x, y, rate_hz=now.recording.rate_hz)
    place = int(np.argmin(np.abs(found.frequency_hz - line.frequency_hz)))
    near = slice(max(place - 1, 0), place + 2)
    forward, backward = float(found.forward[near].max()), float(found.backward[near].max())
    return (forward - backward) / max(forward + backward, 1e-300)
