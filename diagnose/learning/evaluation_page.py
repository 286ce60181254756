"""An evaluation as one HTML page: confusion matrix, calibration curve, tables by condition, the model's card."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..report.text import escape
from ..report.whole_page import whole_page
from .evaluation import UNKNOWN

_SIDE, _LEFT, _TOP = 300, 48, 12


def evaluation_page(
    data: Mapping[str, Any], files: Sequence[Mapping[str, Any]], remarks: Sequence[str], card: Mapping[str, Any]
) -> str:
    """Return the page of an evaluation.

    Parameters
    ----------
    data : mapping
        As `evaluated` gives it; without rows where no truth was known.
    files : sequence of mapping
        The answer for each recording.
    remarks : sequence of str
    card : mapping
        Of the model.
    """
    parts = ["<main><header><p class='kicker'>rotorwise evaluate</p>", f"<p class='verdict'>{_verdict(data)}</p>"]
    if remarks:
        items = "".join(f"<li>{escape(one)}</li>" for one in remarks)
        parts.append(f'<div class="warnings" role="note"><ul>{items}</ul></div>')
    parts.append("</header>")
    if data.get("rows"):
        parts += [_section("Confusion matrix", _confusion(data)), _section("Calibration", _curve(data["calibration"]))]
        situations = {"all": data, **data.get("situations", {})}
        parts.append(_section("By what was known", _conditions("", situations)))
        parts += [
            _section(f"By {name.replace('_', ' ')}", _conditions(name, rows))
            for name, rows in data.get("by", {}).items()
            if rows
        ]
    if files:
        parts.append(_section("Recordings", _files(files)))
    parts.append(_section("The model", _card(card)))
    return whole_page("\n".join([*parts, "</main>"]), (), title="rotorwise evaluate", scripts=())


def _verdict(data: Mapping[str, Any]) -> str:
    if not data.get("rows"):
        return "No recording with a known truth: nothing to count."
    return (
        f"{_percent(data['right'])} of {data['rows']} rows right, false alarms {_percent(data['false_alarms'])}, "
        f"unknown {_percent(data['unknown'])}."
    )


def _section(title: str, content: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{content}</section>"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f'<th scope="col" style="padding:6px 10px">{escape(one)}</th>' for one in heads)
    body = "".join("<tr>" + "".join(rows_cell for rows_cell in row) + "</tr>" for row in rows)
    return f'<div class="frame"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _cell(text: object, style: str = "") -> str:
    return f'<td style="{style}">{escape(text)}</td>' if style else f"<td>{escape(text)}</td>"


def _confusion(data: Mapping[str, Any]) -> str:
    """Return truths down and answers across; the shade is the share of the truth's rows."""
    answers = sorted({answer for row in data["confusion"].values() for answer in row} - {UNKNOWN})
    columns = [*answers, UNKNOWN]
    rows = []
    for truth, row in data["confusion"].items():
        total, right = sum(row.values()), "healthy" if truth == "not evident" else truth
        cells = [_cell(f"{truth} ({total})")]
        for answer in columns:
            count = row.get(answer, 0)
            colour = "43,122,61" if answer == right else "128,128,128" if answer == UNKNOWN else "179,38,30"
            style = f"background:rgba({colour},{0.75 * count / total:.2f})" if count else ""
            cells.append(_cell(count or "", style))
        rows.append([*cells, _cell(_percent(data["recall"][truth]))])
    note = (
        "<p class='source'>Recall: share of the rows that are like the training. A fault that does not show is right "
    )
    return _table(["truth", *columns, "recall"], rows) + note + "as healthy.</p>"


def _curve(curve: Sequence[Mapping[str, float]]) -> str:
    """Return the share of right answers over the probability stated; a dot's area is its number of rows."""
    right, bottom = _LEFT + _SIDE, _TOP + _SIDE
    parts = [
        f'<rect x="{_LEFT}" y="{_TOP}" width="{_SIDE}" height="{_SIDE}" fill="none" stroke="currentColor"/>',
        f'<line x1="{_LEFT}" y1="{bottom}" x2="{right}" y2="{_TOP}" stroke="currentColor" stroke-dasharray="4 4"/>',
    ]
    for tenth in range(0, 11, 2):
        at = tenth / 10 * _SIDE
        parts.append(_text(_LEFT + at, bottom + 16, f"{tenth / 10:g}", "middle"))
        parts.append(_text(_LEFT - 6, bottom - at + 4, f"{tenth / 10:g}", "end"))
    parts.append(_text(_LEFT + _SIDE / 2, bottom + 34, "probability stated", "middle"))
    most = max((one["rows"] for one in curve), default=1)
    for one in curve:
        x, y = _LEFT + one["stated"] * _SIDE, bottom - one["right"] * _SIDE
        radius = 3 + 9 * (one["rows"] / most) ** 0.5
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="#1f5fa8" fill-opacity="0.7"/>')
        parts.append(_text(x + radius + 2, y + 4, f"{one['rows']:.0f}", "start"))
    size = f'width="{right + 40}" height="{bottom + 44}" viewBox="0 0 {right + 40} {bottom + 44}"'
    head = (
        f'<svg {size} role="img" aria-label="share right over probability stated" font-size="12" fill="currentColor">'
    )
    rows = [[_cell(f"{one['stated']:.2f}"), _cell(f"{one['right']:.2f}"), _cell(f"{one['rows']:.0f}")] for one in curve]
    return f"{head}{''.join(parts)}</svg>" + _table(["stated", "right", "rows"], rows)


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _conditions(name: str, parts: Mapping[str, Mapping[str, Any]]) -> str:
    keys = ("right", "balanced_recall", "false_alarms", "unknown")
    rows = [
        [_cell(label), _cell(part["rows"]), *(_cell(_percent(part[key])) for key in keys)]
        for label, part in parts.items()
    ]
    return _table([name.replace("_", " "), "rows", "right", "mean recall", "false alarms", "unknown"], rows)


def _files(files: Sequence[Mapping[str, Any]]) -> str:
    rows = []
    for one in files:
        name, label = _cell(Path(one["path"]).name), _cell(one["label"] or "-")
        if one["answer"] is None:
            rows.append([name, label, _cell(one["reason"]), _cell(""), _cell("")])
            continue
        answer = one["answer"] if one["answer"] != UNKNOWN else f"unknown ({one['likeliest']}?)"
        rows.append([name, label, _cell(answer), _cell(f"{one['probability']:.2f}"), _cell(f"{one['p_value']:.3f}")])
    return _table(["recording", "label", "answer", "probability", "p-value"], rows)


def _card(card: Mapping[str, Any]) -> str:
    rows = [[_cell(name.replace("_", " ")), _cell(_words(value))] for name, value in card.items()]
    return _table(["what", ""], rows)


def _words(value: object) -> str:
    """Return an entry of a card in words: numbers short, tables within tables by their single numbers only."""
    if isinstance(value, Mapping):
        parts = {key: one for key, one in value.items() if not isinstance(one, list) or _is_plain(one)}
        return "; ".join(f"{str(key).replace('_', ' ')}: {_inner(one)}" for key, one in parts.items()) or "-"
    if isinstance(value, list) and len(value) > 8:
        return f"{len(value)}: {', '.join(map(str, value[:4]))}, ..."
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "-"
    return (
        "yes"
        if value is True
        else "no"
        if value is False
        else f"{value:.4g}"
        if isinstance(value, float)
        else str(value)
    )


def _inner(value: object) -> str:
    if not isinstance(value, Mapping):
        return _words(value)
    single = {key: one for key, one in value.items() if isinstance(one, int | float | str)}
    return ", ".join(f"{str(key).replace('_', ' ')} {_words(one)}" for key, one in single.items()) or "-"


def _is_plain(value: list[Any]) -> bool:
    return not any(isinstance(one, Mapping) for one in value)


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.1%}"
