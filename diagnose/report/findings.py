"""The answer in words: verdict, warnings, ranked findings, speed and facts of the file."""

from __future__ import annotations

import math

from ..result import Analysis, Finding, SpeedEstimate
from .text import duration, escape, fault_words, fixed, number, percent

_METHODS = {
    "tacho": "tacho pulses",
    "vibration": "found in the vibration, without a hint",
    "vibration near the hint": "found in the vibration, near the stated speed",
    "hint only": "stated speed only, not confirmed by the vibration",
}


def warnings_block(analysis: Analysis) -> str:
    """Return the data-quality warnings; an empty text when there are none."""
    if not analysis.warnings:
        return ""
    items = "".join(f"<li>{escape(warning)}</li>" for warning in analysis.warnings)
    count = len(analysis.warnings)
    words = "1 warning about the data" if count == 1 else f"{count} warnings about the data"
    return f'<div class="warnings" role="note"><strong>{words}</strong><ul>{items}</ul></div>'


def remarks_block(analysis: Analysis) -> str:
    """Return what is worth knowing beside the findings; an empty text when there is nothing."""
    if not analysis.remarks:
        return ""
    items = "".join(f"<li>{escape(remark)}</li>" for remark in analysis.remarks)
    return f'<ul class="remarks">{items}</ul>'


def findings_block(analysis: Analysis, level: int) -> str:
    """Return the ranked findings as cards, or the plain statement that nothing is evident."""
    if not analysis.findings:
        return _nothing_evident(analysis)
    cards = "".join(_card(finding, rank, level) for rank, finding in enumerate(analysis.findings, start=1))
    return f'<ol class="cards">{cards}</ol>'


def _nothing_evident(analysis: Analysis) -> str:
    tested = f"{analysis.tests} spectral lines were tested; none" if analysis.tests else "No spectral line"
    return (
        '<div class="card nothing"><p class="fault">Nothing evident in this measurement</p>'
        f"<p>{tested} stands out enough to name a fault. This does not prove the machine sound: a fault "
        "that does not show at this speed, load or sensor position leaves nothing to find.</p></div>"
    )


def _card(finding: Finding, rank: int, level: int) -> str:
    known = math.isfinite(finding.probability)
    width = 100 * min(max(finding.probability, 0.0), 1.0) if known else 0.0
    parts = [
        f'<li class="card"><h{level} class="fault"><span class="rank">{rank}</span> '
        f"{escape(fault_words(finding.fault))}</h{level}>",
        f'<div class="probability"><div class="bar" aria-hidden="true"><i style="width:{width:.1f}%"></i>'
        "</div>"
        f"<span>Probability {percent(finding.probability)}</span></div>",
        f"<p>{escape(finding.summary)}</p>",
    ]
    if finding.check:
        parts.append(f'<p class="check"><b>Check:</b> {escape(finding.check)}</p>')
    if finding.rivals:
        rivals = "; ".join(escape(fault_words(rival)) for rival in finding.rivals)
        parts.append(f'<p class="rivals"><b>These data cannot tell it from:</b> {rivals}</p>')
    return "".join(parts) + "</li>"


def speed_block(speed: SpeedEstimate | None) -> str:
    """Return the shaft speed with its interval, confidence and method."""
    if speed is None:
        return (
            "<p>Speed unknown. Without it no line can be tied to the shaft, a bearing or a gear: give "
            "the speed or a tacho channel.</p>"
        )
    rows = [
        ("Speed", f"<b>{fixed(speed.speed_rpm, 1)} rpm</b> ({number(speed.speed_hz, digits=5)} Hz)"),
        ("95 % interval", f"{fixed(60 * speed.low_hz, 1)} to {fixed(60 * speed.high_hz, 1)} rpm"),
        ("Confidence", f"{percent(speed.confidence)} that this is the shaft speed"),
        ("Method", escape(_METHODS.get(speed.method, speed.method))),
    ]
    if speed.variation:
        rows.append(("Variation within the recording", f"{number(100 * speed.variation, digits=2)} % peak to peak"))
    return _definitions(rows)


def facts_block(analysis: Analysis) -> str:
    """Return where the numbers came from: file, reader, baseline, channels, rate, length."""
    rows = [("File", f'<span class="path">{escape(analysis.path)}</span>')]
    if analysis.label:
        rows.append(("Label", escape(analysis.label)))
    if analysis.reader:
        rows.append(("Read as", escape(analysis.reader)))
    baseline = escape(analysis.baseline_path) if analysis.baseline_path else "none"
    rows += [
        ("Baseline", f'<span class="path">{baseline}</span>'),
        (f"Channels ({len(analysis.channels)})", ", ".join(map(escape, analysis.channels)) or "none"),
        ("Sampling rate", f"{analysis.rate_hz:.9g} Hz"),
        ("Length", duration(analysis.duration_s)),
        ("Spectral lines tested", str(analysis.tests)),
    ]
    return _definitions(rows)


def _definitions(rows: list[tuple[str, str]]) -> str:
    return '<dl class="facts">' + "".join(f"<dt>{name}</dt><dd>{text}</dd>" for name, text in rows) + "</dl>"
