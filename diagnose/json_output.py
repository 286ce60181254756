"""The answer as JSON: stable names, finite numbers only."""

from __future__ import annotations

import math
from typing import Any

from .result import Analysis, Finding, Line, Severity


def as_json(analysis: Analysis) -> dict[str, Any]:
    """Return one analysis as a dictionary of JSON types; numbers that are not finite become None."""
    speed = analysis.speed
    return {
        "path": analysis.path,
        "verdict": analysis.verdict,
        "speed_rpm": None if speed is None else number(speed.speed_rpm),
        "speed": None
        if speed is None
        else {
            "low_rpm": number(60 * speed.low_hz),
            "high_rpm": number(60 * speed.high_hz),
            "confidence": number(speed.confidence),
            "method": speed.method,
            "variation": number(speed.variation),
        },
        "findings": [_finding(finding) for finding in analysis.findings],
        "severity": _severity(analysis.severity[0]) if analysis.severity else None,
        "severity_all": [_severity(one) for one in analysis.severity],
        "severity_refusal": analysis.severity_refusal or None,
        "warnings": list(analysis.warnings),
        "remarks": list(analysis.remarks),
        "model": None
        if analysis.opinion is None
        else {
            "probabilities": {name: number(one) for name, one in analysis.opinion.probabilities.items()},
            "p_value": number(analysis.opinion.p_value),
            "counted": analysis.opinion.known,
        },
        "channels": list(analysis.channels),
        "rate_hz": number(analysis.rate_hz),
        "duration_s": number(analysis.duration_s),
        "reader": analysis.reader,
        "label": analysis.label,
        "baseline": analysis.baseline_path,
        "lines_tested": analysis.tests,
        "features": {name: number(value) for name, value in analysis.features.items()},
        "blocks": [
            {key: number(value) if isinstance(value, float) else value for key, value in row.items()}
            for row in analysis.blocks
        ],
    }


def number(value: float | None) -> float | None:
    """Return a finite float, or None."""
    return float(value) if value is not None and math.isfinite(value) else None


def _finding(finding: Finding) -> dict[str, Any]:
    return {
        "fault": finding.fault,
        "probability": round(finding.probability, 4),
        "summary": finding.summary,
        "evidence": [_line(line) for line in finding.lines],
        "check": finding.check,
        "rivals": list(finding.rivals),
    }


def _line(line: Line) -> dict[str, Any]:
    return {
        "name": line.name,
        "channel": line.channel,
        "spectrum": line.spectrum,
        "order": number(line.order),
        "expected_order": number(line.expected_order),
        "frequency_hz": number(line.frequency_hz),
        "amplitude": number(line.amplitude),
        "unit": line.unit,
        "noise_floor": number(line.noise_floor),
        "signal_to_noise": number(line.signal_to_noise),
        "baseline_amplitude": number(line.baseline_amplitude),
    }


def _severity(one: Severity) -> dict[str, Any]:
    return {
        "standard": one.standard,
        "table": one.table,
        "zone": one.zone,
        "value": number(one.value),
        "unit": one.unit,
        "quantity": one.quantity,
        "boundaries": [float(value) for value in one.boundaries],
        "channel": one.channel,
        "source": one.source,
        "confidence": one.confidence,
        "verified": one.verified,
        "alarm": number(one.alarm),
        "trip": number(one.trip),
        "note": one.note,
    }
