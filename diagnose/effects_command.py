"""What ``rotorwise effects`` does: list the catalogue of physical effects, or explain one of them."""

from __future__ import annotations

import difflib
import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError
from .cli_options import option
from .label_rows import heading, row

if TYPE_CHECKING:
    from rich.console import Console

Name = Annotated[
    str | None, typer.Argument(help="Effect to explain; all are listed when left out.", metavar="[EFFECT]",
                               show_default=False)
]  # fmt: skip
AsJson = Annotated[bool, option("--json", text="Print JSON: one object, or a list of them.")]
#: More lines than this of one signature are cut short on the screen.
MOST_LINES = 6


def effects(name: Name = None, as_json: AsJson = False) -> None:
    """List the physical effects that a simulated machine can have, or explain one."""
    from ..simulators.effect import effect_catalogue
    from ..simulators.effect_text import effect_data
    from ..simulators.machine import machine_catalogue

    catalogue = effect_catalogue()
    if name is not None and name not in catalogue:
        near = difflib.get_close_matches(name, catalogue, n=1)
        advice = f"Did you mean {near[0]}?" if near else "Correct the name."
        raise InvalidValueError(f"Effect {name!r} is unknown; allowed: {', '.join(catalogue)}. {advice}")
    if not as_json and name is None:
        _show_list({known: (effect.STAGE, effect.MEANING) for known, effect in catalogue.items()})
        return
    machines = machine_catalogue()
    chosen = [catalogue[name]] if name is not None else list(catalogue.values())
    found = [effect_data(effect, machines) for effect in chosen]
    if as_json:
        print(json.dumps(found if name is None else found[0], indent=2))
        return
    from rich.console import Console

    explain(found[0], Console(highlight=False))


def _show_list(known: dict[str, tuple[str, str]]) -> None:
    """Print one row an effect, cut to the width of the screen."""
    from rich.console import Console
    from rich.markup import escape

    from ..simulators.effect_text import STAGE_TITLES

    console = Console(highlight=False)
    wide = max(map(len, known))
    for stage, title in STAGE_TITLES.items():
        console.print(f"[bold underline]{title}[/]")
        for name, (own, meaning) in sorted(known.items()):
            if own == stage:
                console.print(
                    f"[bold]{name:{wide}}[/]  {escape(meaning)}", no_wrap=True, overflow="ellipsis", crop=True
                )
    console.print(f"{len(known)} effects. rotorwise effects NAME explains one.", style="dim")


def explain(data: dict[str, Any], console: Console) -> None:
    """Print one effect; fits 80 columns."""
    from rich.markup import escape

    console.print(f"[bold underline]{data['name']}[/]  [dim]{data['stage']}, acts on: {escape(data['acts_on'])}[/]")
    console.print(escape(data["meaning"]))
    console.print(f"\n{escape(_reflowed(data['description']))}")
    heading(console, "Lines at the default values")
    for machine, lines in data["lines"].items():
        row(console, machine, _lines(lines))
    heading(console, "Parameters")
    for parameter in data["parameters"]:
        unit = f" {parameter['unit']}" if parameter["unit"] else ""
        row(console, parameter["name"], parameter["meaning"])
        bounds = f"{parameter['lowest']:.4g} to {parameter['highest']:.4g}{unit}"
        absent = "" if parameter["absent_at"] is None else f"; absent at {parameter['absent_at']:g}"
        row(console, "", f"default {parameter['default']:.4g}{unit}, allowed {bounds}{absent}", style="dim")
        row(console, "", f"expected: {parameter['prior']} ({parameter['source']})", style="dim")
    heading(console, "What to check on the machine")
    console.print(escape(data["check"]))
    heading(console, "What looks alike, and what tells it apart")
    for rival, separates in data["rivals"].items():
        row(console, rival, separates)
    heading(console, "References")
    for reference in data["references"]:
        console.print(escape(reference))


def _lines(lines: list[dict[str, Any]]) -> str:
    """Return a signature in words; lines of one direction and one growth share them."""
    from ..simulators.effect import Line
    from ..simulators.effect_text import growth_text

    groups: dict[str, list[str]] = {}
    for line in lines[:MOST_LINES]:
        growth = growth_text(
            Line(line["order"], speed_exponent=line["speed_exponent"], load_exponent=line["load_exponent"])
        )
        direction = "all directions" if line["direction"] == "any" else line["direction"]
        groups.setdefault(f"{direction}{f', force: {growth}' if growth else ''}", []).append(line["text"])
    texts = [f"{', '.join(places)} ({words})" for words, places in groups.items()]
    more = f"; {len(lines) - MOST_LINES} more" if len(lines) > MOST_LINES else ""
    return "; ".join(texts) + more if texts else "no line of its own, see above"


def _reflowed(text: str) -> str:
    """Return paragraphs as one line each, so that the screen's width decides where lines end."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in text.split("\n\n"))
