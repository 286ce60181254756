"""Trends: over the files of a folder, or over the blocks of one long file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..result import Analysis
from .encode import numbers
from .figures import figure
from .payload import short_name
from .text import clean, escape, fault_words, fixed, percent

_TIME_KEYS = ("time_s", "start_s", "time", "start", "t")
_FAULTS_DRAWN = 6

Trend = dict[str, Any]


def files_trend(analyses: Sequence[Analysis]) -> Trend:
    """Return what changes over the files in their order: probabilities, severity, speed, features."""
    series = [*_probabilities(analyses), *_severities(analyses)]
    speeds = [60 * one.speed.speed_hz if one.speed else math.nan for one in analyses]
    if np.isfinite(speeds).any():
        series.append(_series("Speed (rpm)", "Machine", speeds))
    for name in dict.fromkeys(name for one in analyses for name in one.features):
        series.append(_series(name, "Features (SI units)", [one.features.get(name, math.nan) for one in analyses]))
    return {
        "x": numbers(np.arange(1, len(analyses) + 1)),
        "xTitle": "File number, in the order given",
        "labels": [short_name(one) for one in analyses],
        "jump": True,
        "series": series,
    }


def blocks_trend(blocks: Sequence[dict]) -> Trend | None:
    """Return what changes over the blocks of one file; None when there is nothing to draw.

    Every key with numbers becomes a series; words (the top finding) become the text of each point.
    """
    if len(blocks) < 2:
        return None
    names = list(dict.fromkeys(str(name) for block in blocks for name in block))
    time = next((key for key in _TIME_KEYS if key in names), None)
    columns = {name: [_as_number(block.get(name)) for block in blocks] for name in names}
    series = [
        _series(name.replace("_", " "), "Blocks", values)
        for name, values in columns.items()
        if name != time and np.isfinite(values).any()
    ]
    if not series:
        return None
    words = [name for name in names if any(isinstance(block.get(name), str) for block in blocks)]
    labels = [", ".join(_words(block[name]) for name in words if block.get(name)) for block in blocks]
    x = columns[time] if time else list(range(1, len(blocks) + 1))
    return {
        "x": numbers(np.asarray(x), digits=7),
        "xTitle": "Time (s)" if time else "Block number",
        "labels": labels,
        "jump": False,
        "series": series,
    }


def trend_figure(trend: Trend, identifier: str, title: str, level: int) -> str:
    """Return the figure of a trend with its selector."""
    groups = dict.fromkeys(series["group"] for series in trend["series"])
    options = "".join(
        f'<optgroup label="{escape(group)}">'
        + "".join(
            f'<option value="{index}">{escape(series["name"])}</option>'
            for index, series in enumerate(trend["series"])
            if series["group"] == group
        )
        + "</optgroup>"
        for group in groups
    )
    chooser = f'<label for="{identifier}">Show <select id="{identifier}" data-role="series">{options}</select></label>'
    caption = "Select a point to open its file." if trend["jump"] else ""
    return figure("trend", title, chooser, caption, level)


def overview_table_rows(analyses: Sequence[Analysis]) -> list[str]:
    """Return the rows of the table of files: number, file, speed, top finding, zone, warnings."""
    return [_overview_row(index, analysis) for index, analysis in enumerate(analyses)]


def _overview_row(index: int, analysis: Analysis) -> str:
    top = analysis.findings[0] if analysis.findings else None
    finding = escape(fault_words(top.fault)) if top else "Nothing evident"
    probability = top.probability if top and math.isfinite(top.probability) else None
    zone = analysis.severity[0].zone if analysis.severity else ""
    letter = zone if zone in ("A", "B", "C", "D") else "x"
    badge = f'<span class="zone zone-{letter}">{escape(zone)}</span>' if zone else "not stated"
    rpm = 60 * analysis.speed.speed_hz if analysis.speed else None
    return (
        f'<tr><td class="num" data-v="{index + 1}">{index + 1}</td>'
        f'<th scope="row"><a class="path" href="#file-{index}">{escape(short_name(analysis))}</a></th>'
        f'<td class="num" data-v="{"" if rpm is None else f"{rpm:.6g}"}">{fixed(rpm, 1)}</td>'
        f"<td>{finding}</td>"
        f'<td class="num" data-v="{"" if probability is None else f"{probability:.6g}"}">'
        f"{percent(probability) if probability is not None else fixed(None, 0)}</td>"
        f'<td data-v="{escape(zone)}">{badge}</td>'
        f'<td class="num" data-v="{len(analysis.warnings)}">{len(analysis.warnings)}</td></tr>'
    )


def _series(name: str, group: str, values: Sequence[float]) -> dict[str, Any]:
    return {
        "name": clean(name),
        "group": group,
        "traces": [{"name": clean(name), "y": numbers(np.asarray(values))}],
    }


def _probabilities(analyses: Sequence[Analysis]) -> list[dict[str, Any]]:
    highest: dict[str, float] = {}
    for finding in (finding for one in analyses for finding in one.findings):
        if math.isfinite(finding.probability):
            highest[finding.fault] = max(finding.probability, highest.get(finding.fault, 0.0))
    if not highest:
        return []
    drawn = sorted(highest, key=lambda fault: -highest[fault])[:_FAULTS_DRAWN]
    traces = []
    for fault in drawn:
        # A fault that is not among a file's findings is not evident there, which is drawn as zero.
        values = [max([f.probability for f in one.findings if f.fault == fault], default=0.0) for one in analyses]
        traces.append({"name": fault_words(fault), "y": numbers(np.asarray(values))})
    return [{"name": "Probability of the findings", "group": "Findings", "traces": traces}]


def _severities(analyses: Sequence[Analysis]) -> list[dict[str, Any]]:
    kinds = dict.fromkeys((s.table, s.quantity, s.unit) for one in analyses for s in one.severity)
    series = []
    for table, quantity, unit in kinds:
        values = [
            max(
                (s.value for s in one.severity if (s.table, s.quantity, s.unit) == (table, quantity, unit)),
                default=math.nan,
            )
            for one in analyses
        ]
        series.append(_series(f"{quantity}, highest channel ({unit}; {table})", "Severity", values))
    return series


def _as_number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return math.nan
    return float(value)


def _words(value: object) -> str:
    text = clean(value)
    return fault_words(text) if "_" in text or text.islower() else text
