"""Mains hum: the supply's own frequency and its multiples in the signal, from a ground loop or an unscreened cable.

Magnetic pull of a motor acts at twice the supply's frequency; nothing mechanical turns at the supply's own unless a
shaft does. So a line at exactly 50 or 60 Hz, no lower than that at twice as much, where no shaft order lies, is the
measuring chain (H. W. Ott, Electromagnetic Compatibility Engineering, Wiley 2009).
"""

from __future__ import annotations

import numpy as np

from ..observe import Observation
from ..order_lines import near_a_bearing
from ..result import Finding, Line

_SUPPLIES_HZ = (50.0, 60.0)
_EXACT = 2e-3  # a public supply keeps its frequency to 0.2 Hz
_EVEN_SHARE = 0.1  # of the signal's power, at which hum is as likely as not worth a finding
_LONE = 0.4  # without a multiple it may be another machine's line
_MOST, _LEAST_PROBABILITY = 0.95, 0.02
_PLACE = 0.25  # bins to which the place of a line is known
_APART = 2.5  # bins between the supply and the nearest multiple of half a shaft order
_CHECK = (
    "Stop the machine: hum stays. Unplug the sensor at its end of the cable: hum that stays comes from the cable. "
    "Earth the screen at one end only, keep the cable away from power lines."
)


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return hum of the measuring chain where it carries a part of the signal; a baseline has no say in it."""
    if now.speed is None or not now.turning or now.speed.method == "hint only":
        return []
    if now.order_tracked and now.speed.variation * max(_SUPPLIES_HZ) > now.spectrum.resolution_hz:
        return []  # at constant shaft angle a fixed frequency is smeared
    found = [_hum(now, channel, supply) for channel in range(now.channel_count) for supply in _supplies(now)]
    seen = [one for one in found if one is not None]
    if not seen:
        return []
    share, supply, lines = max(seen, key=lambda one: one[0])
    loudest = lines[0].channel
    probability = _MOST * share / (share + _EVEN_SHARE) * (1.0 if len(lines) > 1 else _LONE)
    if probability < _LEAST_PROBABILITY:
        return []
    channels = sorted({line.channel for _, at, some in seen if at == supply for line in some})
    names = f"{', '.join(channels[:3])}{f' and {len(channels) - 3} more' if len(channels) > 3 else ''}"
    summary = (
        f"Mains hum: the supply's {supply:g} Hz and {len(lines) - 1} of its multiples carry {share:.0%} of the signal "
        f"of {loudest}; seen on {names}. It is electrical, in the measuring chain: magnetic pull of a motor "
        f"would show at {2 * supply:g} Hz above all."
    )
    return [Finding("sensor_fault", probability, summary, lines, _CHECK, ("electrical",))]


def _supplies(now: Observation) -> list[float]:
    """Return the supply frequencies that are no order, half order or bearing rhythm of the machine in this record."""
    gears = now.recording.nameplate.gears
    ratios = {1.0, *(ratio for gear in gears for ratio in (gear.driver_ratio, gear.driven_ratio) if ratio is not None)}
    steps = [0.5 * ratio * now.speed_hz for ratio in ratios]
    declared = now.recording.nameplate.line_frequency_hz
    known = _SUPPLIES_HZ if declared is None else (declared,)
    apart = _APART * now.spectrum.resolution_hz
    return [
        one
        for one in known
        if all(abs(one - max(round(one / step), 1) * step) > apart for step in steps)
        and not near_a_bearing(now, one / now.speed_hz)
    ]


def _hum(now: Observation, channel: int, supply_hz: float) -> tuple[float, float, tuple[Line, ...]] | None:
    """Return share of the signal's power, supply and its significant lines; None where it is no hum."""
    lines = [
        now.line_at(
            times * supply_hz,
            channel=channel,
            name=f"{times} x supply",
            tolerance_hz=max(now.spectrum.resolution_hz, _EXACT * times * supply_hz),
        )
        for times in (1, 2, 3)
    ]
    if not now.is_significant(lines[0]) or lines[1].amplitude > lines[0].amplitude:
        return None
    kept = tuple(line for line in lines if now.is_significant(line))
    place = _PLACE * now.spectrum.resolution_hz
    if any(
        abs(one.frequency_hz - times * supply_hz) > place + _EXACT * one.frequency_hz
        for times, one in enumerate(lines, start=1)
        if one in kept
    ):
        return None
    power = float(np.mean(now.recording.signals[channel] ** 2))
    share = min(sum(line.amplitude**2 for line in kept) / max(2.0 * power, 1e-300), 1.0)
    return share, supply_hz, kept
