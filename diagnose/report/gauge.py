"""Severity: a bar of zones A to D with the measured value marked, or the reason why there is none."""

from __future__ import annotations

import math
from itertools import pairwise

from ..result import Analysis, Severity
from .text import escape, number

_CONFIDENCE = {"H": "high", "M": "medium", "L": "low"}
_FIRST_SHOWN = 3
_HEADROOM = 1.35  # zone D is drawn a third as long as A to C together, so that its letter has room


def severity_block(analysis: Analysis) -> str:
    """Return the zone gauges, worst first, or the reason for the refusal."""
    if not analysis.severity:
        reason = escape(analysis.severity_refusal) or "The analysis gives no reason."
        return f'<p class="refused"><b>No severity stated.</b> {reason}</p>'
    gauges = [_gauge(severity) for severity in analysis.severity]
    more = ""
    if len(gauges) > _FIRST_SHOWN:
        rest = "".join(gauges[_FIRST_SHOWN:])
        count = len(gauges) - _FIRST_SHOWN
        more = f"<details><summary>{count} more channels or tables</summary>{rest}</details>"
    note = f'<p class="refused">{escape(analysis.severity_refusal)}</p>' if analysis.severity_refusal else ""
    return "".join(gauges[:_FIRST_SHOWN]) + more + note


def _gauge(severity: Severity) -> str:
    mark = "" if severity.verified else ' <span class="unverified">unverified table</span>'
    letter = severity.zone if severity.zone in "ABCD" and len(severity.zone) == 1 else "x"
    value = f"{number(severity.value)} {_unit(severity)}"
    return (
        f'<div class="gauge"><p class="gauge-head"><span class="zone zone-{letter}">'
        f"Zone {escape(severity.zone)}</span> "
        f"<b>{value}</b> on {escape(severity.channel)}{mark}</p>{_bar(severity)}{_source(severity)}</div>"
    )


def _unit(severity: Severity) -> str:
    return "µm" if severity.unit == "um" else escape(severity.unit)


def _bar(severity: Severity) -> str:
    bounds = [bound for bound in severity.boundaries if math.isfinite(bound) and bound > 0]
    if not bounds or bounds != sorted(bounds):
        return ""
    end = bounds[-1] * _HEADROOM
    edges = [0.0, *bounds, end]
    spoken = f"{number(severity.value)} {severity.unit}, zone {severity.zone}; boundaries " + ", ".join(
        number(bound) for bound in bounds
    )
    widths = [100 * (high - low) / end for low, high in pairwise(edges)]
    segments = "".join(
        f'<span class="seg zone-{letter}" style="width:{width:.2f}%"><b>{letter}</b></span>'
        for letter, width in zip("ABCD", widths, strict=False)
    )
    ticks = "".join(f'<span class="tick" style="left:{100 * b / end:.2f}%">{number(b)}</span>' for b in bounds)
    limits = "".join(
        f'<i class="limit" style="left:{100 * limit / end:.2f}%"></i>'
        for limit in (severity.alarm, severity.trip)
        if limit is not None and 0 < limit <= end
    )
    return (
        f'<div class="scale" role="img" aria-label="{escape(spoken)}">{_marker(severity.value, end)}'
        f'<div class="segments">{segments}{limits}</div><div class="ticks">{ticks}</div></div>'
    )


def _marker(value: float, end: float) -> str:
    if not math.isfinite(value):
        return ""
    beyond = value > end
    place = min(max(100 * value / end, 0.0), 100.0)
    side = "left" if place < 12 else "right" if place > 88 else "middle"
    text = number(value) + (" ▸ off the scale" if beyond else "")
    return f'<span class="marker {side}" style="left:{place:.2f}%"><em>{text}</em></span>'


def _source(severity: Severity) -> str:
    confidence = _CONFIDENCE.get(severity.confidence, severity.confidence)
    parts = [
        f"{escape(severity.quantity[:1].upper() + severity.quantity[1:])} in {_unit(severity)}.",
        f"{escape(severity.standard)}, {escape(severity.table)}.",
        f"Numbers from: {escape(severity.source)}; confidence {escape(confidence)}.",
    ]
    if not severity.verified:
        parts.append("<b>These boundaries rest on a weak source: check them against the standard before acting.</b>")
    limits = [
        f"{name} {number(limit)} {_unit(severity)} (dashed)"
        for name, limit in (("alarm", severity.alarm), ("trip", severity.trip))
        if limit is not None
    ]
    if limits:
        parts.append("Limits from the baseline: " + ", ".join(limits) + ".")
    if severity.note:
        parts.append(escape(severity.note))
    return f'<p class="source">{" ".join(parts)}</p>'
