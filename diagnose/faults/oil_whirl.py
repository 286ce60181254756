"""Oil whirl: a line at 0.40-0.48 of the shaft speed, in a machine with journal bearings.

Reference: A. Muszynska, "Whirl and whip - rotor/bearing stability problems", J. Sound Vib. 110 (1986) 443.
"""

from __future__ import annotations

import numpy as np

from ..compare import comparable
from ..observe import Observation
from ..order_lines import doubt_of_shafts, fractions_resolved
from ..result import Finding, Line
from ..signal.spectrum import peak_near

_NEW = 10.0  # growth from which a line was not there before


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return oil whirl when a strong line tracks just below half the speed and no rolling bearing is known."""
    if not fractions_resolved(now) or now.recording.nameplate.bearings:
        return []
    low, high = 0.40 * now.speed_hz, 0.485 * now.speed_hz
    best, index = None, 0
    for channel in range(now.channel_count):
        found, _, _ = peak_near(now.spectrum, channel, 0.5 * (low + high), tolerance_hz=0.5 * (high - low))
        if abs(found - 0.5 * now.speed_hz) < 3 * now.spectrum.resolution_hz:
            continue  # the skirt of a half-order line
        line = now.line_at(found, channel=channel, name="whirl", tolerance_hz=0.5 * now.spectrum.resolution_hz)
        one = now.line(1.0, channel=channel)
        ratio = _velocity(now, channel, line.frequency_hz, line.amplitude) / max(
            _velocity(now, channel, one.frequency_hz, one.amplitude), 1e-300
        )
        if now.is_significant(line) and (best is None or ratio > best[1]):
            best, index = (line, ratio), channel
    if best is None or _is_image(now, best[0]):
        return []
    line, ratio = best
    growth = None
    if baseline is not None and comparable(now, baseline):
        before = baseline.line_at(line.frequency_hz, channel=index, name="whirl", tolerance_hz=0.05 * now.speed_hz)
        growth = line.amplitude / max(before.amplitude, before.noise_floor, 1e-300)
        if growth < 2:
            return []
    # Proximity probes mean journal bearings as a rule; elsewhere a belt, another shaft or a cage makes such lines too.
    journal = all(channel.quantity == "displacement" for channel in now.recording.channels)
    share = ratio / (ratio + (0.3 if journal else 0.5))
    if journal and growth is not None and growth > _NEW:
        # A sound film makes no such line: that it came counts, however large 1X is beside it.
        share = max(share, 0.6)
    elif ratio < 0.1:
        return []
    probability = (0.85 if journal else 0.4) * share * doubt_of_shafts(now)
    return [
        Finding(
            "oil_whirl",
            probability,
            f"Line at {line.order:.3f}X with {ratio:.0%} of the 1X velocity.",
            (line,),
            "Change oil temperature or load and see whether the line moves; look for forward circular orbits.",
            ("rub", "bearing_cage"),
        )
    ]


def _is_image(now: Observation, line: Line) -> bool:
    """Return whether a stronger line stands at 1X less this one: then this is the difference that it makes with 1X.

    Where forces grow faster than the motion, two lines make lines at their sum and difference, weaker than the source.
    """
    image_hz = now.speed_hz - line.frequency_hz
    tolerance = 1.5 * now.spectrum.resolution_hz + now.speed_doubt_hz(1.0)
    sizes = np.zeros(2)
    for channel in range(now.channel_count):
        for index, frequency in enumerate((line.frequency_hz, image_hz)):
            found = now.line_at(frequency, channel=channel, name="image", tolerance_hz=tolerance)
            if now.is_significant(found):
                displacement = _velocity(now, channel, found.frequency_hz, found.amplitude) / found.frequency_hz
                sizes[index] += displacement**2
    return bool(sizes[1] > sizes[0])


def _velocity(now: Observation, channel: int, frequency_hz: float, amplitude: float) -> float:
    return amplitude * float(now.velocity_factor(channel, frequency_hz))
