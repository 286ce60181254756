"""A result in a terminal of 80 columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.table import Table
from rich.text import Text

from ..terminal import escape
from .result import Cause, GapResult, ResidualLine
from .words import (
    amplitude_words,
    decibel_words,
    estimate_words,
    hypothesis_words,
    line_names,
    mesh_orders,
    not_compared_words,
    parameter_label,
    placebos,
    probability_words,
    sentence_of,
)

if TYPE_CHECKING:
    from rich.console import Console

#: Rows of the tables on the screen; the report and the JSON hold everything.
MOST_RESIDUALS, MOST_HYPOTHESES = 6, 4
_SMALL = 0.01


def show(result: GapResult, console: Console, *, notes: Sequence[str] = ()) -> None:
    """Print verdict, causes, rivals, the largest gaps, the gain and what was left out."""
    measured = result.measured
    count = len(measured.conditions)
    console.print()
    console.print(
        f"[bold underline]{escape(result.machine.name)}[/] ({escape(result.machine.preset_name)}), "
        f"{count} condition{'s' if count != 1 else ''}, probes {escape(', '.join(measured.probes))}"
    )
    console.print(Text(sentence_of(result), style="bold"))
    for cause in result.causes:
        console.print()
        console.print(_cause(cause))
    console.print()
    if result.residuals:
        console.print(_residuals(result))
        console.print()
    console.print(_facts(result))
    for note in (*notes, *result.remarks):
        console.print(f"[dim]- {escape(note)}[/]")


def _cause(cause: Cause) -> Table:
    table = _plain_table()
    at = f" at {cause.at}" if cause.at else ""
    table.add_row(f"[red]{probability_words(cause.probability)}[/]", f"[bold]{escape(cause.effect + at)}[/]")
    for name, one in cause.parameters.items():
        table.add_row("", escape(f"{parameter_label(name, one.unit)} {estimate_words(one)}"))
    if cause.check:
        table.add_row("check", escape(cause.check))
    return table


def _residuals(result: GapResult) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    for heading in ("line", "probe", "condition", "measured", "simulated", "sigma"):
        table.add_column(heading, justify="right" if heading in ("measured", "simulated", "sigma") else "left")
    units, names = probe_units(result), line_names(result.measured, mesh_orders(result.machine))
    for line in result.residuals[:MOST_RESIDUALS]:
        table.add_row(*(escape(text) for text in _row(line, result, units.get(line.probe, ""), names[line.column])))
    return table


def _row(line: ResidualLine, result: GapResult, unit: str, name: str) -> tuple[str, ...]:
    return (
        name,
        line.probe,
        str(result.measured.conditions[line.condition]),
        amplitude_words(abs(line.measured), unit),
        amplitude_words(abs(line.simulated), unit, beside=abs(line.measured)),
        f"{line.sigma:.3g}",
    )


def _facts(result: GapResult) -> Table:
    table = _plain_table()
    rivals = [(names, p) for names, p in result.probabilities.items() if p >= _SMALL][:MOST_HYPOTHESES]
    if rivals:
        words = [f"{hypothesis_words(names)} {probability_words(p)}" for names, p in rivals]
        table.add_row("[dim]compared[/]", escape(", ".join(words)))
    table.add_row("[dim]gain[/]", escape(_gains(result)))
    left = not_compared_words(result.not_compared)
    if left:
        table.add_row("[dim]left out[/]", escape(" ".join(left)))
    return table


def _gains(result: GapResult) -> str:
    gain = result.gain
    # Where nothing was added the first is that of calibration.
    every = {"extended machine": gain.held_out_db} if result.causes or result.empirical else {}
    every |= {"calibration alone": gain.calibration_only_db, **placebos(gain)}
    return ", ".join(f"{name} {decibel_words(value)}" for name, value in every.items() if math.isfinite(value)) or "-"


def _plain_table() -> Table:
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0), show_edge=False)
    table.add_column(no_wrap=True)
    table.add_column(ratio=1)
    return table


def probe_units(result: GapResult) -> dict[str, str]:
    """Return the SI unit of each probe of the machine by its name."""
    return {probe.name: probe.unit for probe in result.machine.bare_assembly().probes}
