"""The card of a dataset: what it is, what it holds, how it was made, what it does not show; Markdown for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .generate_table import FIXED, channels_of
from .recipe import Case, MachineRecipe, Recipe
from .recipe_draw import label_columns
from .units import SI_UNIT

_LIMITS = (
    "Simulated: labels are exact, but the machines are models. What a model leaves out stands at the head of its file.",
    "Signals of one group share a machine: split by group, never by row.",
    "Speed is steady in each signal unless an effect changes it.",
    "Channels hold 32-bit numbers: 7 digits.",
)


def card_text(recipe: Recipe, found: Mapping[str, Any]) -> str:
    """Return the card.

    Parameters
    ----------
    recipe : Recipe
    found : mapping
        What the parts add up to (`store.totals`).
    """
    complete = found["signals"] >= recipe.signals
    state = "complete" if complete else f"{found['signals']} of {recipe.signals} signals so far"
    lines = [
        f"# {recipe.name}",
        "",
        recipe.meaning,
        "",
        f"{found['rows']} signals, {len(found['refused'])} refused; {state}. Seed {recipe.seed}, "
        f"fingerprint {recipe.fingerprint}.",
        "",
        *_table(("machine", "case", "split", "signals"), found["counts"]),
    ]
    for one in recipe.machines:
        lines += _machine(recipe, one)
    lines += ["## Measuring chain", "", *_table(("setting", "value"), [[n, c.text()] for n, c in recipe.chain.items()])]
    lines += _columns(recipe)
    lines += ["## Limits", "", *(f"- {text}" for text in (*recipe.limits, *_LIMITS)), ""]
    lines += _refused(found["refused"])
    versions = ", ".join(f"{name} {' and '.join(texts)}" for name, texts in found["versions"].items())
    return "\n".join([*lines, "## Made with", "", versions, "", *_READING])


_READING = (
    "## Read it",
    "",
    "```python",
    "import pandas, polars, duckdb",
    'frame = pandas.read_parquet("data", columns=["split", "case", "speed_rpm"])',
    'frame = polars.scan_parquet("data/*.parquet").filter(polars.col("split") == "train").collect()',
    'rows = duckdb.sql("select \\"case\\", count(*) from \'data/*.parquet\' group by all")',
    "```",
    "",
)


def _machine(recipe: Recipe, one: MachineRecipe) -> list[str]:
    load = one.machine.definition.load_parameter
    rows = [["speed_rpm", one.speed_rpm.text()]]
    rows += [[f"load ({load})", one.load.text()]] if one.load is not None else []
    rows += [[name, choice.text()] for name, choice in one.parameters.items()]
    lines = [
        f"## Machine {one.name}",
        "",
        f"{one.machine.definition.meaning}. Preset {one.machine.preset_name}; {recipe.draws} machine draws, "
        f"{one.per_draw} signals each, {one.duration_s:g} s at {one.rate_hz:g} Hz"
        + (f", {one.records} of each run." if one.records > 1 else "."),
        "",
        *_table(("drawn for each machine", "values"), rows),
    ]
    for case in one.cases:
        lines += _case(case)
    return lines


def _case(case: Case) -> list[str]:
    rows = [[name, choice.text()] for name, choice in case.choices]
    title = f"### {case.name}: {case.faults} a machine, at every speed and load"
    return [title, "", *(_table(("value", "values"), rows) if rows else ["No effect.", ""])]


def _columns(recipe: Recipe) -> list[str]:
    rows = [[name, kind, unit, meaning] for name, kind, unit, meaning in FIXED]
    rows += [[f"severity.{name}", "double", "", ", ".join(sources)] for name, sources in recipe.severity.items()]
    rows += [[name, "double", unit, ""] for name, unit in label_columns(recipe).items()]
    for name, said in channels_of(recipe).items():
        words = " ".join(text for text in (said["quantity"], said["location"], said["direction"]) if text)
        unit = said["unit"] or SI_UNIT.get(said["quantity"], "") or ""
        rows.append([f"signal.{name}", "list<float>", unit, words])
    lines = ["## Columns of data/*.parquet", "", "One row a signal. What a signal does not have is null.", ""]
    return [*lines, *_table(("column", "type", "unit", "meaning"), rows)]


def _refused(refused: Sequence[Mapping[str, Any]]) -> list[str]:
    if not refused:
        return []
    lines = ["## Refused draws", "", "They gave no usable signal and are not among the rows (all: manifest.json).", ""]
    rows = [[one["signal"], one["group"], one["case"], one["reason"]] for one in refused[:20]]
    return [*lines, *_table(("signal", "group", "case", "reason"), rows)]


def _table(heading: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    def line(cells: Sequence[Any]) -> str:
        return "| " + " | ".join(" ".join(str(cell).split()).replace("|", "\\|") for cell in cells) + " |"

    return [line(heading), "|" + "---|" * len(heading), *map(line, rows), ""]
