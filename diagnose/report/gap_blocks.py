"""The words and tables of a gap report."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from ...simulators.effect import effect_catalogue
from ..gap.detection_limits import SHOWN, size_words
from ..gap.result import Cause, GapResult, ResidualLine
from ..gap.words import (
    amplitude_words,
    decibel_words,
    estimate_words,
    gain_words,
    headline,
    hypothesis_words,
    joined_words,
    line_names,
    line_words,
    mesh_orders,
    not_compared_words,
    open_words,
    parameter_label,
    placebos,
)
from .tables import sortable_table
from .text import cell, escape, fixed, number, percent

#: Hypotheses shown at once; the others are folded away.
MOST_CANDIDATES = 8
MOST_RESIDUALS = 10
#: No probability is printed as certain or impossible, whatever rounding made of it.
_DOUBT = 1e-6
_PRINTED = {"um": " µm", "urad": " µrad", "deg": "°"}
_HEADS = ("Line", "Probe", "Condition", "Measured", "Before", "After", "Sigma")


def warnings_block(notes: Sequence[str]) -> str:
    """Return what is to be known of the data; an empty text when there is nothing."""
    if not notes:
        return ""
    items = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return f'<div class="warnings" role="note"><strong>About the data</strong><ul>{items}</ul></div>'


def causes_block(result: GapResult) -> str:
    """Return a card a cause, and what these data leave open."""
    cards = [_cause_card(one) for one in result.causes]
    if not cards:
        cards = [f'<li class="card nothing"><p class="fault">{printed(headline(result))}</p>{_fit(result)}</li>']
    if result.empirical:
        cards.append(_forces_card(result))
    left_open = open_words(result)
    if left_open:
        cards.append(f'<li class="card"><h3 class="fault">Still open</h3><p>{printed(left_open)}</p></li>')
    return f'<ol class="cards">{"".join(cards)}</ol>'


def _cause_card(cause: Cause) -> str:
    at = f" at {cause.at}" if cause.at else ""
    facts = "".join(
        f"<dt>{escape(parameter_label(name, one.unit))}</dt><dd>{printed(estimate_words(one))}</dd>"
        for name, one in cause.parameters.items()
    )
    values = f'<dl class="facts">{facts}</dl><p class="source">In brackets: 90 % interval.</p>' if facts else ""
    known = effect_catalogue().get(cause.effect)
    meaning = f"<p>{escape(known.MEANING)}</p>" if known else ""
    check = f"<p><b>Check:</b> {escape(cause.check)}</p>" if cause.check else ""
    return (
        f'<li class="card"><h3 class="fault">{escape((cause.effect + at).replace("_", " ").capitalize())}</h3>'
        f'<div class="probability">{_bar(cause.probability)}<span>{_percent(cause.probability)}</span></div>'
        f"{meaning}{values}{check}</li>"
    )


def _forces_card(result: GapResult) -> str:
    gears = mesh_orders(result.machine)
    heads = ("Line", "Place", "Direction", "Amplitude", "Phase", "Speed exponent")
    loaded = any(one.load_exponent for one in result.empirical)
    rows = []
    for one in result.empirical:
        fitted = [one.amplitude, one.phase, one.speed_exponent, *([one.load_exponent] if loaded else [])]
        cells = [escape(one.at), escape(one.direction)]
        cells += [printed(estimate_words(value)) if value else "" for value in fitted]
        line = f'<th scope="row">{escape(line_words(one.order, gears))}</th>'
        rows.append(f"<tr>{line}{''.join(f'<td>{text}</td>' for text in cells)}</tr>")
    others = sorted({other for one in result.empirical for other in one.or_at})
    where = f" A force at {joined_words(others, last='or')} does nearly as well." if others else ""
    table = sortable_table(
        (*heads, *(("Load exponent",) if loaded else ())),
        rows,
        caption=f"Amplitude at {result.empirical[0].reference_speed_rpm:.0f} rpm",
        css="gap-table",
    )
    return (
        '<li class="card"><h3 class="fault">Added: empirical forces</h3>'
        f"<p>They describe the lines that no effect explains; what makes them is unknown.</p>{table}"
        f'<p class="source">In brackets: 90 % interval.{escape(where)}</p></li>'
    )


def _fit(result: GapResult) -> str:
    # For "unknown" no hypothesis was left to judge.
    if not math.isfinite(result.misfit) or result.kind == "unknown":
        return ""
    return f"<p>Chance of a residual as large as the one that is left: {_percent(result.misfit)}.</p>"


def candidates_block(result: GapResult) -> str:
    """Return every hypothesis with its probability, the less probable ones folded away."""
    ranked = sorted(result.probabilities.items(), key=lambda item: -item[1])
    if not ranked:
        return "<p>Nothing was compared.</p>"
    rows = [
        f"<li><span>{escape(hypothesis_words(names))}</span>{_bar(p)}<span>{_percent(p)}</span>"
        f"{_score(result, names)}</li>"
        for names, p in ranked
    ]
    note = (
        "Evidence, prediction of each condition from the others, and of the held-out ones from all fitted: logarithms "
    )
    note += "of the ratio to nothing being wrong."
    shown = f'<ol class="bars">{"".join(rows[:MOST_CANDIDATES])}</ol>'
    shown += f'<p class="source">{note}</p>' if result.scores else ""
    more = len(rows) - MOST_CANDIDATES
    if more <= 0:
        return shown
    rest = f'<ol class="bars">{"".join(rows[MOST_CANDIDATES:])}</ol>'
    return f'{shown}<details class="fold"><summary>{more} more</summary>{rest}</details>'


def _score(result: GapResult, names: tuple[str, ...]) -> str:
    """Return evidence and prediction of a hypothesis against nothing being wrong; empty where it was not fitted."""
    own, nothing = result.scores.get(names), result.scores.get(())
    if own is None or nothing is None or not names:
        return ""
    evidence = own.log_evidence - nothing.log_evidence
    prediction = own.log_prediction - nothing.log_prediction
    held_out = own.log_held_out - nothing.log_held_out
    told = f", held out {held_out:+.0f}" if math.isfinite(held_out) else ""
    return f'<small class="source">evidence {evidence:+.0f}, prediction {prediction:+.0f}{told}</small>'


def gain_block(result: GapResult) -> str:
    """Return the gain of the extended machine, if there is one, beside those of calibration and placebos."""
    gain = result.gain
    every = {"extended machine": gain.held_out_db} if result.causes or result.empirical else {}
    every |= {"calibration alone": gain.calibration_only_db}
    every |= {f"placebo: {name}": value for name, value in placebos(gain).items()}
    known = {name: value for name, value in every.items() if math.isfinite(value)}
    top = max((abs(value) for value in known.values()), default=0.0) or 1.0
    rows = "".join(
        f"<li><span>{escape(name)}</span>{_bar(abs(value) / top, css='' if value >= 0 else ' less')}"
        f"<span>{decibel_words(value)}</span></li>"
        for name, value in known.items()
    )
    where = "in conditions that were not fitted" if gain.held_out else "in the fitted conditions"
    note = f'<p class="source">Fall of the residual power {where}, against the machine as given.</p>'
    return f'<p>{escape(gain_words(gain))}</p><ol class="bars">{rows}</ol>{note if rows else ""}'


def residual_table(result: GapResult) -> str:
    """Return the lines that the calibrated machine gets wrong, largest first."""
    if not result.residuals:
        return "<p>No line was compared.</p>"
    units = {one.name: one.unit for one in result.machine.bare_assembly().probes}
    names = line_names(result.measured, mesh_orders(result.machine))
    rows = [_residual_row(line, result, units.get(line.probe, ""), names[line.column]) for line in result.residuals]
    caption = "Sigma: distance before, in standard deviations"
    first = sortable_table(_HEADS, rows[:MOST_RESIDUALS], caption=caption, css="gap-table")
    if len(rows) <= MOST_RESIDUALS:
        return first
    every = sortable_table(_HEADS, rows, caption=caption, css="gap-table")
    return f'{first}<details class="fold"><summary>All {len(rows)} lines</summary>{every}</details>'


def _residual_row(line: ResidualLine, result: GapResult, unit: str, name: str) -> str:
    measured = result.measured
    probe = measured.probes.index(line.probe)
    after = abs(complex(result.after[line.condition, probe, line.column]))
    sizes = (abs(line.measured), abs(line.simulated), after)
    condition = measured.conditions[line.condition]
    return (
        f'<tr><th scope="row" data-v="{line.order:.9g}">{escape(name)}</th>'
        f'<td>{escape(line.probe)}</td><td data-v="{condition.speed_rpm:.9g}">{escape(condition)}</td>'
        + "".join(cell(printed(amplitude_words(size, unit, beside=sizes[0])), size) for size in sizes)
        + cell(fixed(line.sigma, 1) if line.sigma < 100 else number(line.sigma), line.sigma)
        + "</tr>"
    )


def left_out_block(result: GapResult) -> str:
    """Return effects that did not compete and lines that could not be seen, with the reasons."""
    items = not_compared_words(result.not_compared)
    hidden = int((~result.measured.seen).sum())
    if hidden:
        items.append(
            f"{hidden} of {result.measured.seen.size} lines: above the range of the recording, whose anti-alias filter "
            "bends them."
        )
    if not items:
        return "<p>Every effect of the catalogue that can act on this machine competed, on every line.</p>"
    return f'<ul class="left-out">{"".join(f"<li>{escape(item)}</li>" for item in items)}</ul>'


def limits_block(result: GapResult) -> str:
    """Return from which size on each effect would have shown, folded away; an empty text where that was not asked."""
    if not result.detection_limits:
        return ""
    rows = [
        f'<tr><th scope="row">{escape(one.effect.replace("_", " "))}</th><td>{escape(one.at)}</td>'
        f"<td>{escape(parameter_label(one.parameter, one.unit))}</td>"
        f"<td>{printed(size_words(one)) if math.isfinite(one.size) else 'none'}</td></tr>"
        for one in result.detection_limits
    ]
    table = sortable_table(
        ("Effect", "Part", "Strength", "Shows from"),
        rows,
        caption=f"Each strength alone. Shows: all lines together change by {SHOWN**0.5:g} standard deviations of what "
        "is uncertain. None: at no likely size.",
        css="gap-table",
    )
    return f'<details class="fold"><summary>What would have shown</summary>{table}</details>'


def calibration_block(result: GapResult) -> str:
    """Return the machine's own parameters that were fitted: by themselves, and again beside what was added."""
    units = {one.name: one.unit for one in result.machine.definition.parameters}
    columns = {"Given": result.machine, "Calibrated": result.calibrated}
    if result.calibrated.values != {name: result.extended.values[name] for name in result.calibrated.values}:
        columns["Extended"] = result.extended
    moved = [name for name in result.calibrated.values if len({one.values[name] for one in columns.values()}) > 1]
    if not moved:
        return "<p>Calibration left the machine's parameters as given.</p>"
    rows = [
        f'<tr><th scope="row">{escape(parameter_label(name, units[name]))}</th>'
        + "".join(cell(number(one.values[name], digits=4), one.values[name]) for one in columns.values())
        + f"<td>{escape(units[name])}</td></tr>"
        for name in moved
    ]
    again = "; in the extended machine they are fitted again beside what was added" if len(columns) > 2 else ""
    caption = f"Calibrated parameters of the machine{again}"
    return sortable_table(("Parameter", *columns, "Unit"), rows, caption=caption)


def extended_block(result: GapResult) -> str:
    """Return the extended machine as the text of a machine file, folded away."""
    text = escape(result.extended.to_toml())
    return f'<details class="fold"><summary>The extended machine as a file</summary><pre>{text}</pre></details>'


def printed(text: str) -> str:
    """Return words with units as a page prints them, escaped."""
    shown = re.sub(r"(?<=\d) (um|urad|deg)\b", lambda found: _PRINTED[found[1]], escape(text))
    return shown.replace("m/s2", "m/s²")


def _percent(probability: float) -> str:
    return percent(min(max(probability, _DOUBT), 1 - _DOUBT))


def _bar(share: float, *, css: str = "") -> str:
    width = 100 * min(max(share, 0.0), 1.0) if math.isfinite(share) else 0.0
    return f'<span class="bar{css}" aria-hidden="true"><i style="width:{width:.1f}%"></i></span>'
