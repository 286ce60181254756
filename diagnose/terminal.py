"""The answer in a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape as escape_markup
from rich.table import Table
from rich.text import Text

from .result import Analysis, Severity

_TRUSTED_SPEED = 0.8
_ZONE_COLOUR = {"A": "green", "B": "green", "C": "yellow", "D": "red"}


def escape(text: str) -> str:
    """Return a text that neither markup nor control characters of a file name can disturb."""
    return escape_markup("".join(one if one.isprintable() else "?" for one in text))


def show(analysis: Analysis, console: Console) -> None:
    """Print one analysis: verdict, findings, severity, speed, warnings."""
    console.print()
    console.print(f"[bold underline]{escape(Path(analysis.path).name)}[/]", soft_wrap=True)
    console.print(Text(analysis.verdict, style="bold"))
    if analysis.findings:
        console.print(_findings(analysis))
    console.print(_facts(analysis))
    for warning in analysis.warnings:
        console.print(f"[yellow]![/] {escape(warning)}")
    for remark in analysis.remarks:
        console.print(f"[dim]- {escape(remark)}[/]")


def _findings(analysis: Analysis) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    table.add_column("probability", justify="right", no_wrap=True)
    table.add_column("fault", no_wrap=True)
    table.add_column("evidence", ratio=1)
    for finding in analysis.findings:
        colour = "red" if finding.probability >= 0.5 else "yellow" if finding.probability >= 0.25 else "white"
        evidence = escape(finding.summary)
        if finding.rivals:
            evidence += f" [dim]Rivals: {', '.join(finding.rivals)}.[/]"
        table.add_row(f"[{colour}]{finding.probability:.0%}[/]", finding.fault, evidence)
    return table


def _facts(analysis: Analysis) -> Table:
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0), show_edge=False)
    table.add_column(style="dim", no_wrap=True)
    table.add_column(ratio=1)
    speed = analysis.speed
    if speed is not None:
        half = 30 * (speed.high_hz - speed.low_hz)
        table.add_row(
            "speed",
            f"{speed.speed_rpm:.1f} rpm +- {half:.1f}, {escape(speed.method)}, confidence {speed.confidence:.0%}",
        )
    if analysis.severity:
        worst, others = analysis.severity[0], analysis.severity[1:]
        limits = " / ".join(f"{value:g}" for value in worst.boundaries)
        mark = "" if worst.verified else " (unverified table)"
        table.add_row(
            "severity",
            f"{_zone(worst)} ({escape(worst.quantity)}); {escape(worst.standard)}, {escape(worst.table)}, "
            f"limits {limits}{mark}",
        )
        if worst.note:
            table.add_row("", f"[dim]{escape(worst.note)}[/]")
        if others:
            rest = f" and {len(others) - 5} more" if len(others) > 5 else ""
            table.add_row("", "; ".join(_zone(one) for one in others[:5]) + rest)
    elif analysis.severity_refusal:
        table.add_row("severity", escape(analysis.severity_refusal))
    table.add_row(
        "record",
        f"{_duration(analysis.duration_s)} at {analysis.rate_hz:g} Hz, channels {escape(_channels(analysis))}",
    )
    if analysis.baseline_path:
        table.add_row("baseline", escape(Path(analysis.baseline_path).name))
    return table


def _zone(one: Severity) -> str:
    colour = _ZONE_COLOUR.get(one.zone, "white")
    return f"[{colour}]zone {one.zone}[/] {escape(one.channel)} {one.value:.3g} {one.unit}"


def _duration(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds < 600 else f"{seconds / 60:.1f} min"


def _channels(analysis: Analysis) -> str:
    shown = ", ".join(analysis.channels[:6])
    rest = len(analysis.channels) - 6
    return shown if rest <= 0 else f"{shown} and {rest} more"


def _speed(analysis: Analysis) -> str:
    if analysis.speed is None:
        return "-"
    doubt = "" if analysis.speed.confidence >= _TRUSTED_SPEED else "?"
    return f"{analysis.speed.speed_rpm:.0f}{doubt}"


def show_overview(analyses: Sequence[Analysis], console: Console) -> None:
    """Print a folder as one table, a row a file."""
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    for column in ("file", "rpm", "zone", "finding", "probability", "warnings"):
        table.add_column(
            column,
            no_wrap=column != "finding",
            justify="right" if column in ("rpm", "probability") else "left",
        )
    for analysis in analyses:
        top = analysis.findings[0] if analysis.findings else None
        zone = analysis.severity[0].zone if analysis.severity else "-"
        table.add_row(
            escape(Path(analysis.path).name),
            _speed(analysis),
            f"[{_ZONE_COLOUR.get(zone, 'white')}]{zone}[/]",
            "nothing evident" if top is None else top.fault,
            "" if top is None else f"{top.probability:.0%}",
            str(len(analysis.warnings)),
        )
    console.print()
    console.print(table)
    marks = "? speed uncertain. " if any(_speed(one).endswith("?") for one in analyses) else ""
    if marks or any(one.warnings for one in analyses):
        console.print(f"[dim]{marks}The warnings stand in the report (--report) and in --json.[/]")
