"""Rub: lines at thirds and quarters of the shaft speed, when rotor and stator touch every third or fourth turn.

Half orders alone are left to looseness, which makes the same lines; the two are rivals. Quarters beside halves are one
motion whose period doubled twice, which both of them make: there they share.
Reference: F. K. Choy and J. Padovan, J. Sound Vib. 113 (1987) 529; A. Muszynska, Shock Vib. Dig. 21 (1989) 3.
"""

from __future__ import annotations

from ..compare import comparable
from ..observe import Observation
from ..order_lines import doubt_of_shafts, fractions_resolved, strongest_line
from ..result import Finding

_FAMILIES = (("1/3X", (1 / 3, 2 / 3, 4 / 3, 5 / 3)), ("1/4X", (0.25, 0.75, 1.25, 1.75)))
_HALVES = (0.5, 1.5, 2.5)
_SHARED = 0.5  # of the quarters, where halves stand beside them
_PROBABILITY = {2: 0.25, 3: 0.45, 4: 0.60}


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return a rub when at least two lines of one fractional family stand out."""
    if not fractions_resolved(now):
        return []
    reference = baseline if comparable(now, baseline) else None
    best: Finding | None = None
    for family, orders in _FAMILIES:
        lines = [line for order in orders if (line := strongest_line(now, reference, order)) is not None]
        if len(lines) < 2 or (best is not None and len(lines) <= len(best.lines)):
            continue
        halves = [order for order in _HALVES if strongest_line(now, reference, order) is not None]
        doubled_twice = family == "1/4X" and len(halves) >= 2
        names = ", ".join(line.name for line in lines)
        best = Finding(
            "rub",
            _PROBABILITY[len(lines)] * doubt_of_shafts(now) * (_SHARED if doubled_twice else 1.0),
            f"{len(lines)} lines of the {family} family above the noise: {names}.",
            tuple(lines),
            "Check seals and clearances; look for a drifting 1X vector at constant speed (thermal bow).",
            ("looseness",),
        )
    return [] if best is None else [best]
