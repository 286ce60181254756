"""Looseness: lines at odd multiples of half the shaft speed, from a joint that opens every second turn.

Reference: A. Muszynska and P. Goldman, "Chaotic responses of unbalanced rotor/bearing/stator systems with looseness or
rubs", Chaos, Solitons and Fractals 5 (1995) 1683.
"""

from __future__ import annotations

import numpy as np

from ..compare import comparable, order_change_db
from ..observe import Observation
from ..order_lines import doubt_of_shafts, fractions_resolved, long_comb, strongest_line
from ..result import Finding, Line

_ORDERS = (0.5, 1.5, 2.5, 3.5, 4.5, 5.5)
_PROBABILITY = {0: 0.0, 1: 0.04, 2: 0.15, 3: 0.35, 4: 0.50, 5: 0.60, 6: 0.65}
_RUB_CHECK = "Check seals and clearances; speed up and down: a rub comes and goes at different speeds."
_SHARE = (0.7, 0.85, 0.35)  # of looseness: direction not told, upright, sideways (a judgement)
_SHARE_OF_COMB = 0.01  # of the velocity energy, from which a comb beside gears is the shaft's own (a judgement)
_CHECK = "Check bolts, bearing fits and foundation; watch these lines while a bolt is tightened."


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return looseness when several half orders stand out that no other shaft or bearing owns."""
    if not fractions_resolved(now):
        return []
    reference = baseline if comparable(now, baseline) else None
    lines = [line for order in _ORDERS if (line := strongest_line(now, reference, order)) is not None]
    comb = 0.0 if reference is None else long_comb(now, reference)
    if comb > 0 and len(lines) < 2:
        return _from_comb(now, reference, comb)
    if not lines:
        return []
    names = ", ".join(line.name for line in lines)
    summary = f"{len(lines)} half order{'s' if len(lines) > 1 else ''} above the noise: {names}."
    return _shared(now, _PROBABILITY[len(lines)] * doubt_of_shafts(now), summary, tuple(lines))


def _shared(now: Observation, probability: float, summary: str, lines: tuple[Line, ...]) -> list[Finding]:
    """Return looseness and rub, which make the same lines, with their shares of one probability.

    Looseness is the more frequent. A joint opens upwards as a rule; a stop is touched from any side.
    """
    upright = _upright(now, lines)
    share = _SHARE[0 if upright is None else 1 if upright else 2]
    parts = (("looseness", "rub", share, _CHECK), ("rub", "looseness", 1.0 - share, _RUB_CHECK))
    return [Finding(fault, part * probability, summary, lines, check, (rival,)) for fault, rival, part, check in parts]


def _upright(now: Observation, lines: tuple[Line, ...]) -> bool | None:
    """Return whether the lines are at least twice as high vertically as horizontally, or the other way; else None."""
    power: dict[str, float] = {"horizontal": 0.0, "vertical": 0.0}
    for line in lines:
        one = {name: [0.0] for name in power}
        for channel, about in enumerate(now.recording.channels):
            if about.direction in one:
                order = line.expected_order if line.expected_order is not None else line.order
                here, base = now.line(order, channel=channel), now.line(1.0, channel=channel)
                one[about.direction].append(here.amplitude / max(base.amplitude, base.noise_floor, 1e-300))
        for name, found in one.items():
            power[name] += max(found) ** 2
    if max(power.values()) < 4.0 * min(power.values()) or min(power.values()) <= 0:
        return None
    return power["vertical"] > power["horizontal"]


def _share(now: Observation) -> float:
    """Return the share of 4X to 10X in the velocity energy, of the channel where it is largest."""
    return max(
        sum(now.velocity_share(float(order), channel=channel) for order in range(4, 11))
        for channel in range(now.channel_count)
    )


def _from_comb(now: Observation, baseline: Observation | None, comb: float) -> list[Finding]:
    """Return what a long risen comb says; a strongly risen 1X makes harmonics too, without any looseness."""
    assert baseline is not None
    one = float(np.median(order_change_db(now, baseline, 1.0)))
    probability = (0.3 if one > 10 else 0.6) * comb**2
    if now.recording.nameplate.gears:
        # A bad tooth strikes once a turn and makes a comb too, a faint one: it does not cut off the shaft's motion.
        probability *= min(1.0, _share(now) / _SHARE_OF_COMB)
    lines = [strongest_line(now, baseline, float(order)) for order in range(4, 11)]
    summary = (
        f"{comb:.0%} of the orders 4X to 10X at least tripled against the baseline, 1X {one:+.0f} dB: "
        "the motion is cut off."
    )
    return _shared(now, probability, summary, tuple(line for line in lines if line is not None))
