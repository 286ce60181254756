"""Severity answers and scores as lines of text and as JSON types."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from .evaluation import TargetScore, ZoneScore
from .model import TOGETHER, Estimate, SeverityAnswer
from .targets import target_named

_ZONES = "ABCD"


def card_lines(card: dict[str, Any]) -> list[str]:
    """Return a model's card for the terminal."""
    lines = [
        f"{card['recipe']}: {card['machines']} machines, {card['records']} records, "
        f"{card['speed_rpm'][0]:.0f} to {card['speed_rpm'][1]:.0f} rpm, probes {', '.join(card['probes'])}"
    ]
    for name, smallest in card["smallest"].items():
        target = target_named(name)
        ends = [f"{target.per_si * value:.3g}" for value in (smallest, card["largest"][name])]
        lines.append(f"  {name} {ends[0]} to {ends[1]} {target.unit}")
    lines += ["each estimator takes its fault for the only one"] * bool(card["alone"])
    return [*lines, f"intervals of {100 * card['coverage']:g} %, calibrated on {card['calibration']}"]


def estimate_text(one: Estimate) -> str:
    """Return one estimate in words.

    Examples
    --------
    >>> estimate_text(Estimate("parallel offset", "mm", 0.031, 0.0, 0.05, True, False))
    'not evident; at most 0.05 mm'
    """
    top = f"{one.high:.3g} {one.unit}"
    if one.reaches_zero:
        return f"not evident; at most {top}" + (" or more" if one.beyond else "")
    return f"{one.value:.3g} {one.unit} ({one.low:.3g} to {one.high:.3g}{' or more' if one.beyond else ''})"


def answer_lines(path: str, answer: SeverityAnswer, *, coverage: float) -> list[str]:
    """Return the answer for a file for the terminal."""
    lines = [path]
    lines += [f"  {one.target:<22}{estimate_text(one)}" for one in answer.estimates]
    lines.append(
        f"  intervals of {100 * coverage:g} % at {answer.speed_rpm:.0f} rpm, faults and machine as in the training"
    )
    for name, zone in answer.predicted.items():
        span = "" if zone.lowest == zone.highest else f" ({zone.lowest} to {zone.highest})"
        given = "" if name == TOGETHER else f" if {name} is the only fault"
        lines.append(f"  zone the simulator predicts{given}: {zone.zone}{span}; {zone.table}")
    if answer.shown is not None:
        shown = answer.shown
        lines.append(f"  zone the record shows: {shown.zone}, {shown.value:.3g} {shown.unit}; {shown.standard}")
    else:
        lines.append(f"  {answer.refusal}")
    return (
        lines
        + [f"  finding: {answer.disagreement}"] * bool(answer.disagreement)
        + [f"  {one}" for one in answer.remarks]
    )


def answer_data(answer: SeverityAnswer) -> dict[str, Any]:
    """Return the answer as JSON types; numbers that are not finite become None."""
    shown = answer.shown
    return {
        "speed_rpm": answer.speed_rpm,
        "estimates": [_finite(asdict(one)) for one in answer.estimates],
        "predicted_zones": {name: _finite(asdict(zone)) for name, zone in answer.predicted.items()},
        "measured_zone": None
        if shown is None
        else {
            "zone": shown.zone,
            "value": shown.value,
            "unit": shown.unit,
            "standard": shown.standard,
            "table": shown.table,
        },
        "finding": answer.disagreement or None,
        "severity_refusal": answer.refusal or None,
        "remarks": list(answer.remarks),
    }


def score_lines(targets: Sequence[TargetScore], zones: ZoneScore | None, *, coverage: float) -> list[str]:
    """Return scores as a Markdown table and sentences; README tables are made of it."""
    lines = [
        "| severity | case | machines | records | coverage | holds 0 | error x | 90 % x | interval x |",
        "|---|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for one in targets:
        share = f"{100 * one.coverage:.1f} +- {100 * one.standard_error:.1f} %"
        factors = [_factor(value) for value in (one.error_factor, one.worst_factor, one.width_factor)]
        cells = (one.target, one.case, one.machines, one.records, share, f"{100 * one.reaches_zero:.0f} %", *factors)
        lines.append(f"| {' | '.join(str(cell) for cell in cells)} |")
    lines.append(f"Nominal coverage {100 * coverage:g} %.")
    if zones is not None:
        share = 100 * zones.right / zones.away if zones.away else math.nan
        lines.append(
            f"Zones: right in {zones.right} of {zones.away} records away from a limit ({share:.1f} %), off by two in "
            f"{zones.off_by_two} of {zones.records}; {zones.findings} disagreements reported."
        )
        lines += ["", "| measured | A | B | C | D |", "|---|--:|--:|--:|--:|"]
        lines += [f"| {_ZONES[i]} | {' | '.join(str(count) for count in row)} |" for i, row in enumerate(zones.counts)]
    return lines


def _factor(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def score_data(targets: Sequence[TargetScore], zones: ZoneScore | None) -> dict[str, Any]:
    """Return scores as JSON types."""
    return {"targets": [_finite(asdict(one)) for one in targets], "zones": None if zones is None else asdict(zones)}


def _finite(values: dict[str, Any]) -> dict[str, Any]:
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in values.items()}
