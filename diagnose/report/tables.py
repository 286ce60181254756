"""Tables of a report: the evidence lines and the features."""

from __future__ import annotations

import math

from ..result import Analysis, Line
from .text import MISSING, cell, decibels, display_unit, escape, fault_words, fixed, number, unit_words

_EVIDENCE_HEADS = (
    "Line",
    "Where",
    "Order",
    "Expected order",
    "Frequency (Hz)",
    "Amplitude",
    "Noise floor",
    "Signal over noise (dB)",
    "Baseline",
    "Change (dB)",
    "Speaks for",
)


def sortable_table(heads: tuple[str, ...], rows: list[str], *, caption: str, css: str = "") -> str:
    """Return a table whose columns sort by a click or the keyboard, in a frame that scrolls sideways.

    Parameters
    ----------
    heads : tuple of str
        Plain text.
    rows : list of str
        Escaped ``<tr>`` elements.
    caption : str
        Plain text; also names the frame for screen readers.
    css : str
        Class of the table.
    """
    head = "".join(f'<th scope="col"><button type="button">{escape(name)}</button></th>' for name in heads)
    return (
        f'<div class="frame" role="region" tabindex="0" aria-label="{escape(caption)}">'
        f'<table class="sortable {css}"><caption>{escape(caption)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def evidence_lines(analysis: Analysis) -> dict[Line, list[str]]:
    """Return every line that a finding uses, once, with the faults that it speaks for."""
    used: dict[Line, list[str]] = {}
    for finding in analysis.findings:
        for line in finding.lines:
            faults = used.setdefault(line, [])
            if finding.fault not in faults:
                faults.append(finding.fault)
    return used


def evidence_table(analysis: Analysis) -> str:
    """Return the table of every line behind the findings."""
    used = evidence_lines(analysis)
    if not used:
        return "<p>No spectral line carries a finding.</p>"
    rows = [_evidence_row(line, faults) for line, faults in used.items()]
    return sortable_table(_EVIDENCE_HEADS, rows, caption="Lines behind the findings", css="evidence")


def _evidence_row(line: Line, faults: list[str]) -> str:
    factor, _ = display_unit(line.unit)
    snr = decibels(line.signal_to_noise)
    before = line.baseline_amplitude
    change = decibels(line.amplitude / before) if before is not None and before > 0 else None
    signed = MISSING if change is None else f"{change:+.1f}"
    speaks_for = "; ".join(escape(fault_words(fault)) for fault in faults)
    return (
        f'<tr><th scope="row">{escape(line.name)}</th><td>{escape(line.channel)}, '
        f"{escape(line.spectrum)}</td>"
        + cell(fixed(line.order, 3), line.order)
        + cell(fixed(line.expected_order, 3), line.expected_order)
        + cell(fixed(line.frequency_hz, 2), line.frequency_hz)
        + _amplitude(line.amplitude, line.unit, factor)
        + _amplitude(line.noise_floor, line.unit, factor)
        + cell(fixed(snr, 1), snr)
        + _amplitude(before, line.unit, factor)
        + cell(signed, change)
        + f"<td>{speaks_for}</td></tr>"
    )


def _amplitude(value: float | None, unit: str | None, factor: float) -> str:
    if value is None or math.isnan(value):
        return cell(MISSING, None)
    # Sorting uses SI, so that rows in different units still stand in a fixed order.
    return cell(f'{number(value * factor)} <span class="unit">{escape(unit_words(unit))}</span>', value)


def feature_table(analysis: Analysis) -> str:
    """Return the feature vector, folded away; an empty text when there is none."""
    if not analysis.features:
        return ""
    rows = [
        f'<tr><th scope="row">{escape(name)}</th>{cell(number(float(value), digits=4), float(value))}</tr>'
        for name, value in analysis.features.items()
    ]
    table = sortable_table(("Feature", "Value"), rows, caption="Features in SI units", css="features")
    return f'<details class="fold"><summary>All {len(rows)} features</summary>{table}</details>'
