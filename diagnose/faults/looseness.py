"""Looseness: lines at odd multiples of half the shaft speed, from a joint that opens every second turn.

Reference: A. Muszynska and P. Goldman, "Chaotic responses of unbalanced rotor/bearing/stator systems with looseness or
rubs", Chaos, Solitons and Fractals 5 (1995) 1683.
"""

from __future__ import annotations

import numpy as np

from ..compare import comparable, order_change_db
from ..observe import Observation
from ..order_lines import doubt_of_shafts, fractions_resolved, long_comb, strongest_line
from ..result import Finding

_ORDERS = (0.5, 1.5, 2.5, 3.5, 4.5, 5.5)
_PROBABILITY = {0: 0.0, 1: 0.04, 2: 0.15, 3: 0.35, 4: 0.50, 5: 0.60, 6: 0.65}
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
        return [_from_comb(now, reference, comb)]
    if not lines:
        return []
    names = ", ".join(line.name for line in lines)
    summary = f"{len(lines)} half order{'s' if len(lines) > 1 else ''} above the noise: {names}."
    return [
        Finding(
            "looseness",
            _PROBABILITY[len(lines)] * doubt_of_shafts(now),
            summary,
            tuple(lines),
            _CHECK,
            ("rub",),
        )
    ]


def _share(now: Observation) -> float:
    """Return the share of 4X to 10X in the velocity energy, of the channel where it is largest."""
    return max(
        sum(now.velocity_share(float(order), channel=channel) for order in range(4, 11))
        for channel in range(now.channel_count)
    )


def _from_comb(now: Observation, baseline: Observation | None, comb: float) -> Finding:
    """Return what a long risen comb says; a strongly risen 1X makes harmonics too, without any looseness."""
    assert baseline is not None
    one = float(np.median(order_change_db(now, baseline, 1.0)))
    probability = (0.3 if one > 10 else 0.6) * comb**2
    if now.recording.nameplate.gears:
        # A bad tooth strikes once a turn and makes a comb too, a faint one: it does not cut off the shaft's motion.
        probability *= min(1.0, _share(now) / _SHARE_OF_COMB)
    lines = [strongest_line(now, baseline, float(order)) for order in range(4, 11)]
    return Finding(
        "looseness",
        probability,
        f"{comb:.0%} of the orders 4X to 10X at least tripled against the baseline, 1X {one:+.0f} dB: "
        "the motion is cut off.",
        tuple(line for line in lines if line is not None),
        _CHECK,
        ("rub",),
    )
