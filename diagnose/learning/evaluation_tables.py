"""An evaluation as tables of the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from ..terminal import escape
from .evaluation import UNKNOWN


def tables(data: Mapping[str, Any], files: Sequence[Mapping[str, Any]]) -> list[Table]:
    """Return the tables: recordings, if any; then, if any truth was known, confusion, calibration, conditions."""
    found = [_files(files)] if files else []
    if data.get("rows"):
        found += [_summary(data), _confusion(data), _calibration(data["calibration"])]
        found += [_conditions(name, parts) for name, parts in data.get("by", {}).items() if parts]
    return found


def _plain(title: str, heads: Iterable[str]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), title=title, title_justify="left")
    for place, head in enumerate(heads):
        table.add_column(head, justify="left" if place == 0 else "right", no_wrap=place == 0, overflow="fold")
    return table


def _files(files: Sequence[Mapping[str, Any]]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0))
    for head in ("recording", "label", "answer", "probability", "p-value"):
        table.add_column(head, justify="right" if head in ("probability", "p-value") else "left")
    for one in files:
        name, label = escape(Path(one["path"]).name), one["label"] or "-"
        if one["answer"] is None:
            table.add_row(name, label, escape(one["reason"]), "", "")
            continue
        answer = one["answer"] if one["answer"] != UNKNOWN else f"unknown ({one['likeliest']}?)"
        table.add_row(name, label, answer, f"{one['probability']:.2f}", f"{one['p_value']:.3f}")
    return table


def _summary(data: Mapping[str, Any]) -> Table:
    table = _plain("", ("", "rows", "right", "mean recall", "false alarms", "unknown"))
    for name, part in {"all": data, **data.get("situations", {})}.items():
        shares = [_percent(part[key]) for key in ("right", "balanced_recall", "false_alarms", "unknown")]
        table.add_row(name, str(part["rows"]), *shares)
    return table


def _confusion(data: Mapping[str, Any]) -> Table:
    answers = sorted({answer for row in data["confusion"].values() for answer in row} - {UNKNOWN})
    columns = [*answers, UNKNOWN]
    table = _plain("Truth down, answers across", ("", *(one.removeprefix("bearing_") for one in columns), "recall"))
    for truth, row in data["confusion"].items():
        cells = [str(row.get(answer, "")) for answer in columns]
        table.add_row(truth, *cells, _percent(data["recall"][truth]))
    return table


def _calibration(curve: Sequence[Mapping[str, float]]) -> Table:
    table = _plain("Probability stated, share right", ("stated", "right", "rows"))
    for one in curve:
        table.add_row(f"{one['stated']:.2f}", f"{one['right']:.2f}", f"{one['rows']:.0f}")
    return table


def _conditions(name: str, parts: Mapping[str, Mapping[str, Any]]) -> Table:
    table = _plain("", (name, "rows", "right", "mean recall", "false alarms", "unknown"))
    for label, part in parts.items():
        shares = [_percent(part[key]) for key in ("right", "balanced_recall", "false_alarms", "unknown")]
        table.add_row(label, str(part["rows"]), *shares)
    return table


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.1%}"
