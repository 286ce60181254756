"""Electrical excitation of a motor: twice the line frequency.

Reference: W. T. Thomson and M. Fenger, IEEE Ind. Appl. Mag. 7 (2001) 26.
"""

from __future__ import annotations

from ..compare import comparable
from ..observe import Observation
from ..result import Finding

_ABNORMAL = {"A": 0.05, "B": 0.15, "C": 0.60, "D": 0.85, None: 0.25}


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return an electrical cause when twice the declared line frequency carries much of the velocity.

    Only where the record resolves it from the nearest shaft order; a line there is normal, its share decides.
    """
    line_frequency = now.recording.nameplate.line_frequency_hz
    if line_frequency is None or now.speed is None or not now.turning:
        return []
    twice = 2 * line_frequency
    if now.order_tracked and now.speed.variation * twice > now.spectrum.resolution_hz:
        return []  # at constant shaft angle a fixed frequency is smeared
    nearest = max(round(twice / now.speed_hz), 1) * now.speed_hz
    if abs(nearest - twice) < 2.5 * now.spectrum.resolution_hz:
        return []
    best = None
    for channel in range(now.channel_count):
        line = now.line_at(
            twice,
            channel=channel,
            name="2 x line",
            tolerance_hz=max(now.spectrum.resolution_hz, 5e-4 * twice),
        )
        share = now.velocity_share(line.order, channel=channel)
        if now.is_significant(line) and (best is None or share > best[1]):
            best = (line, share, channel)
    if best is None:
        return []
    line, share, channel = best
    abnormal = _ABNORMAL[now.zone]
    text = ""
    if baseline is not None and comparable(now, baseline):
        before = baseline.line_at(twice, channel=channel, name="2 x line", tolerance_hz=baseline.spectrum.resolution_hz)
        growth = line.amplitude / max(before.amplitude, before.noise_floor, 1e-300)
        abnormal = 0.8 if growth > 4 else 0.1 if growth < 2 else 0.3
        text = f", {growth:.1f} times the baseline"
    return [
        Finding(
            "electrical",
            abnormal * share,
            f"Twice the line frequency carries {share:.0%} of the velocity on {line.channel}{text}.",
            (line,),
            "Cut the power and watch whether the line vanishes at once; check air gap, phases and rotor bars.",
        )
    ]
